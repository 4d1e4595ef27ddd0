"""Simulators that differ from another one in one thing, and leave it all else."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from gap.interfaces import (
    Cause,
    DataFault,
    Drive,
    Effect,
    Observation,
    Simulator,
    check_causes,
)
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.header import TrialHeader
from record.trial.trial import Trial

OTHER_SIZE = 1.5  # times as heavy or as large: no load that a machine may carry makes it that

ManyRequest = tuple[Trial, tuple[Cause, ...], Drive]
PredictMany = Callable[[Sequence[ManyRequest]], list[FloatArray]]


def many_of(simulator: Simulator) -> PredictMany | None:
    """Return how a simulator predicts many sets of causes at once, on threads of its own, or None."""
    many: PredictMany | None = getattr(simulator, "predict_many", None)
    return many


@dataclass(frozen=True, slots=True)
class MachineSize:
    """A weight or a length that says which machine it is, such as 64 N of weight."""

    name: str
    value: float
    unit: str

    @property
    def words(self) -> str:
        """The value with its unit."""
        return f"{self.value:.3g} {self.unit}"


def sizes_of(simulator: Simulator) -> tuple[MachineSize, ...]:
    """Return what a simulator says of its machine's size; nothing where it says nothing."""
    sizes: tuple[MachineSize, ...] = getattr(simulator, "sizes", ())
    return sizes


class Delegate:
    """Implements ``gap.interfaces.Simulator`` by asking another simulator."""

    def __init__(self, inner: Simulator) -> None:
        self.inner = inner
        self.name, self.stages = inner.name, inner.stages
        self.joints, self.bodies = inner.joints, inner.bodies
        self.effects, self.channels = inner.effects, inner.channels

    def observe(self, trial: Trial) -> Observation:
        """Observe as the trial's simulator does."""
        return self.of(trial).observe(trial)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Predict as the trial's simulator does."""
        return self.of(trial).predict(trial, causes, drive)

    @property
    def predict_many(self) -> PredictMany | None:
        """Predict many at once, each as its trial's simulator does; None where one of them cannot."""
        own = type(self)
        if own.predict is not Delegate.predict and own._many is Delegate._many:
            return None  # it predicts in its own manner, one by one
        return self._many if all(map(many_of, self.machines)) else None

    def _many(self, requests: Sequence[ManyRequest]) -> list[FloatArray]:
        answers: dict[int, FloatArray] = {}
        for machine in self.machines:
            own = [i for i, (trial, _, _) in enumerate(requests) if self.of(trial) is machine]
            many = many_of(machine)
            assert many is not None
            made = many([requests[i] for i in own]) if own else []
            answers |= dict(zip(own, made, strict=True))
        return [answers[i] for i in range(len(requests))]

    @property
    def machines(self) -> tuple[Simulator, ...]:
        """The simulators that answer."""
        return (self.inner,)

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Check as the trial's simulator does."""
        return self.of(trial).check(trial)

    def of(self, trial: Trial) -> Simulator:
        """Return the simulator that answers for a trial."""
        del trial
        return self.inner


MachineKey = tuple[str, object, str]


def machine_key(header: TrialHeader) -> MachineKey:
    """Return what a trial says of its machine: trials that agree in it have one simulator."""
    return (header.robot_text, header.constants, header.drive)


class MachineOfEach(Delegate):
    """Trials of machines that differ in their files only: each trial is simulated with its own.

    The catalogue holds the effects that all of them have, so that a cause can be of all of them. Its
    numbers stay within the bounds of each machine, which grow with its size.

    Args:
        machines: What each trial says of its machine (``machine_key``), what it is called in messages, and
            its simulator; the first one answers for trials of none of them.

    Raises:
        GapError: Two of them differ in what they may not: joints, bodies, stages or channels.
    """

    def __init__(self, machines: Sequence[tuple[MachineKey, str, Simulator]]) -> None:
        first_name, first = machines[0][1:]
        super().__init__(first)
        for _, name, other in machines[1:]:
            _refuse_different(first_name, first, name, other)
        self.effects = tuple(_common(first.effects, [one.effects for _, _, one in machines[1:]]))
        self._of = {key: one for key, _, one in machines}

    @property
    def machines(self) -> tuple[Simulator, ...]:
        """The simulators that answer."""
        return tuple(self._of.values())

    def of(self, trial: Trial) -> Simulator:
        """Return the simulator of a trial's own machine."""
        return self._of.get(machine_key(trial.header), self.inner)

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Check as the trial's simulator does, and that its machine is as large as the first one."""
        own = self.of(trial)
        apart = _other_size(sizes_of(self.inner), sizes_of(own))
        if not apart:
            return own.check(trial)
        words = f"{trial.header.robot_file or 'its file'} {apart}"
        return (DataFault("other_machine", "machine", words, True), *own.check(trial))


def _refuse_different(first: str, one: Simulator, name: str, other: Simulator) -> None:
    for what, ours, theirs in (
        ("joints", one.joints, other.joints),
        ("bodies", one.bodies, other.bodies),
        ("stages", one.stages, other.stages),
        ("channels", _channel_words(one), _channel_words(other)),
    ):
        if ours == theirs:
            continue
        apart = [part for part in (*ours, *theirs) if (part in ours) != (part in theirs)]
        words = f"differ in {', '.join(apart)}" if apart else "have them in another order"
        raise GapError(
            f"{what} may not differ between the machines of one diagnosis: {first} and {name} {words}; "
            "diagnose their runs separately, or correct the file"
        )


def _channel_words(simulator: Simulator) -> tuple[str, ...]:
    return tuple(f"{c.name} {c.joint} [{c.unit}]".replace("  ", " ") for c in simulator.channels)


def _common(ours: Sequence[Effect], others: Sequence[Sequence[Effect]]) -> Iterator[Effect]:
    """Yield the effects that all machines have, with bounds that hold for all of them."""
    known = [{effect.name: effect for effect in one} for one in others]
    for effect in ours:
        same = [one.get(effect.name) for one in known]
        alike = [other for other in same if other is not None and _names(other) == _names(effect)]
        if len(alike) == len(known) and (within := _within(effect, alike)) is not None:
            yield within


def _names(effect: Effect) -> list[str]:
    return [p.name for p in effect.parameters]


def _within(effect: Effect, others: Sequence[Effect]) -> Effect | None:
    """The effect with its numbers within the bounds of others, too; None where nothing is left of them.

    Where bounds are the same it is the effect itself.
    """
    parameters = []
    for p, *theirs in zip(effect.parameters, *(one.parameters for one in others), strict=True):
        lower = max(one.lower for one in (p, *theirs))
        upper = min(one.upper for one in (p, *theirs))
        if not lower <= p.neutral <= upper or not lower < upper:
            return None
        parameters.append(replace(p, lower=lower, upper=upper))
    kept = tuple(parameters)
    return effect if kept == effect.parameters else replace(effect, parameters=kept)


def _other_size(ours: Sequence[MachineSize], theirs: Sequence[MachineSize]) -> str:
    """Say in what one machine is of another size than the other; empty where it is not."""
    known = {one.name: one for one in ours}
    for one in theirs:
        first = known.get(one.name)
        if first is not None and not 1 / OTHER_SIZE < one.value / first.value < OTHER_SIZE:
            return (
                f"has a {one.name} of {one.words}, the file of the first trial one of {first.words}"
            )
    return ""


class Without(Delegate):
    """A simulator that lacks some effects, by name: what is diagnosed when the cause has no name?"""

    def __init__(self, whole: Simulator, missing: Sequence[str]) -> None:
        super().__init__(whole)
        self.effects = tuple(effect for effect in whole.effects if effect.family not in missing)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Predict as the whole simulator does.

        Raises:
            GapError: A cause is a missing one.
        """
        check_causes(causes, self)
        return super().predict(trial, causes, drive)

    def _many(self, requests: Sequence[ManyRequest]) -> list[FloatArray]:
        for _, causes, _ in requests:
            check_causes(causes, self)
        return super()._many(requests)
