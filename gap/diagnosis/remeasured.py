"""How far the gap shrinks from one simulator to another: the proof of a corrected robot file."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from gap.delegate import Delegate
from gap.diagnosis.how_far import HowFar, how_far
from gap.diagnosis.study import make_study
from gap.interfaces import Cause, Drive, Effect, Scope, Simulator
from gap.residuals.hold_out import HoldOut
from model.values.arrays import FloatArray
from record.trial.trial import Trial

_CORRECTED = Effect("corrected", "", (), (Scope.ALL,), "The corrected robot file.", "None.")


class _Switch(Delegate):
    """The simulator before; with its only effect added, the one after."""

    def __init__(
        self, before: Simulator, after: Simulator, progress: Callable[[float], None]
    ) -> None:
        super().__init__(before)
        # what hunts is not compared, as in the diagnosis
        hunts = next((one.hunts for one in before.effects if one.hunts), "")
        self.effects = (replace(_CORRECTED, hunts=hunts),)
        self._after, self._progress, self._done = after, progress, 0
        self.expected = 1  # predictions in all

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        predicted = (self._after if causes else self.inner).predict(trial, (), drive)
        self._done += 1
        self._progress(min(1.0, self._done / self.expected))
        return predicted


def remeasure(
    trials: Sequence[Trial],
    references: Sequence[Trial],
    before: Simulator,
    after: Simulator,
    seed: int = 0,
    progress: Callable[[float], None] = lambda share: None,
    hold_out: HoldOut | None = None,
) -> HowFar:
    """Measure the gap with both simulators on the trials that a diagnosis holds out.

    What references predict is subtracted from both, as in the diagnosis. They are of the robot before it
    changed, so only the simulator before is compared with them.

    Args:
        trials: Measured runs.
        references: Runs of the same machine assumed healthy.
        before: The simulator as it was.
        after: The simulator of the corrected file.
        seed: Of the resampling.
        progress: Gets the share that is done.
        hold_out: Which of the trials judge; None holds out evenly.

    Raises:
        GapError: A trial cannot be compared.
    """
    switch = _Switch(before, after, progress)
    study = make_study(trials, switch, references, hold_out=hold_out)
    switch.expected = len(study.fitted) + len(study.references) + 2 * len(study.held)
    return how_far(study.held_evidence(), (Cause(_CORRECTED.name, (), ()),), seed)
