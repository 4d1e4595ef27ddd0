"""How far the gap shrinks from one simulator to another: the proof of a corrected robot file."""

from collections.abc import Callable, Sequence

from gap.diagnosis.diagnose import measure_floor
from gap.diagnosis.how_far import HowFar, how_far
from gap.interfaces import Cause, Channel, DataFault, Drive, Effect, Observation, Scope, Simulator
from gap.residuals.evidence import make_evidence
from gap.residuals.parts import split, whole_part
from gap.residuals.predictions import Predictor
from model.values.arrays import FloatArray
from record.trial.trial import Trial

_CORRECTED = Effect("corrected", "", (), (Scope.ALL,), "The corrected robot file.", "None.")


class _Switch:
    """The simulator before; with its only effect added, the one after."""

    def __init__(
        self, before: Simulator, after: Simulator, progress: Callable[[float], None]
    ) -> None:
        self._before, self._after = before, after
        self._progress, self._done = progress, 0
        self.expected = 1  # predictions in all

    @property
    def name(self) -> str:
        return self._before.name

    @property
    def stages(self) -> tuple[str, ...]:
        return self._before.stages

    @property
    def joints(self) -> tuple[str, ...]:
        return self._before.joints

    @property
    def effects(self) -> tuple[Effect, ...]:
        return (_CORRECTED,)

    @property
    def channels(self) -> tuple[Channel, ...]:
        return self._before.channels

    def observe(self, trial: Trial) -> Observation:
        return self._before.observe(trial)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        found = (self._after if causes else self._before).predict(trial, (), drive)
        self._done += 1
        self._progress(min(1.0, self._done / self.expected))
        return found

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        return self._before.check(trial)


def remeasure(
    trials: Sequence[Trial],
    references: Sequence[Trial],
    before: Simulator,
    after: Simulator,
    seed: int = 0,
    progress: Callable[[float], None] = lambda share: None,
) -> HowFar:
    """Measure the gap with both simulators on the trials that a diagnosis keeps back.

    What references let expect is taken off both, as in the diagnosis. They are of the robot before it
    changed, so only the simulator before is held against them.

    Args:
        trials: Measured runs.
        references: Runs of the same machine believed healthy.
        before: The simulator as it was.
        after: The simulator of the corrected file.
        seed: Of the resampling.
        progress: Told the share that is done.

    Raises:
        GapError: A trial cannot be compared.
    """
    switch = _Switch(before, after, progress)
    everything = (*trials, *references)
    observations = [switch.observe(one) for one in everything]
    predictor = Predictor(switch, everything, None)
    fitted, held = split(trials, observations[: len(trials)])
    healthy = [
        whole_part(len(trials) + i, one, observations[len(trials) + i])
        for i, one in enumerate(references)
    ]
    switch.expected = len(fitted) + len(healthy) + 2 * len(held)
    floor, _ = measure_floor(predictor, healthy, fitted, Drive.COMMAND)
    evidence = make_evidence(predictor, held, Drive.COMMAND, floor)
    return how_far(evidence, switch.channels, (Cause(_CORRECTED.name, (), ()),), seed)
