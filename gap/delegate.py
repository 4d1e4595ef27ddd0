"""Simulators that differ from another one in one thing, and leave it all else."""

from collections.abc import Callable, Sequence

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

ManyRequest = tuple[Trial, tuple[Cause, ...], Drive]
PredictMany = Callable[[Sequence[ManyRequest]], list[FloatArray]]


def many_of(simulator: Simulator) -> PredictMany | None:
    """Return how a simulator predicts many sets of causes at once, on threads of its own, or None."""
    many: PredictMany | None = getattr(simulator, "predict_many", None)
    return many


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

    The catalogue holds the effects that all of them have, so that a cause can be of all of them.

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
        own = [{effect.name: effect for effect in one.effects} for _, _, one in machines]
        self.effects = tuple(
            effect
            for effect in first.effects
            if all(_same_numbers(effect, known.get(effect.name)) for known in own)
        )
        self._of = {key: one for key, _, one in machines}

    @property
    def machines(self) -> tuple[Simulator, ...]:
        """The simulators that answer."""
        return tuple(self._of.values())

    def of(self, trial: Trial) -> Simulator:
        """Return the simulator of a trial's own machine."""
        return self._of.get(machine_key(trial.header), self.inner)


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


def _same_numbers(one: Effect, other: Effect | None) -> bool:
    return other is not None and [p.name for p in one.parameters] == [
        p.name for p in other.parameters
    ]


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
