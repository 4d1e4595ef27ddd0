"""How far the gap shrinks from one simulator to another: the proof of a corrected robot file."""

from collections.abc import Callable, Sequence

from gap.delegate import Delegate
from gap.diagnosis.comparison.how_far import HowFar, how_far
from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause, Drive, Effect, Scope, Simulator
from model.values.arrays import FloatArray
from record.trial.trial import Trial

_CORRECTED = Effect("corrected", "", (), (Scope.ALL,), "The corrected robot file.", "None.")


class _Switch(Delegate):
    """The simulator before; with one more effect, the one after."""

    def __init__(
        self, before: Simulator, after: Simulator, progress: Callable[[float], None], expected: int
    ) -> None:
        super().__init__(before)
        self.effects = (*before.effects, _CORRECTED)
        self._after, self._progress, self._done = after, progress, 0
        self._expected = expected  # predictions in all

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        standing = tuple(one for one in causes if one.effect != _CORRECTED.name)
        corrected = len(standing) < len(causes)
        predicted = (self._after if corrected else self.inner).predict(trial, standing, drive)
        self._done += 1
        self._progress(min(1.0, self._done / self._expected))
        return predicted


def remeasure(
    study: Study,
    after: Simulator,
    seed: int = 0,
    progress: Callable[[float], None] = lambda share: None,
) -> HowFar:
    """Measure the gap of a study with its own simulator and with another one, on its held-out runs.

    The baseline model errors of the study are in both: a corrected file holds what was named beside them.
    So is what references predict, which is subtracted. They are of the robot before it changed, so only the
    simulator before is compared with them. With the study of a diagnosis (``commissioned_study``) and a
    file that holds its causes, this is the figure of that diagnosis.

    Args:
        study: Trials, references and the simulator before.
        after: The simulator of the corrected file.
        seed: Of the resampling.
        progress: Gets the share that is done.

    Raises:
        GapError: A trial cannot be compared.
    """
    count = len(study.fitted) + len(study.references) + 2 * len(study.held)
    both = study.of(_Switch(study.simulator, after, progress, count))
    return how_far(both.held_evidence(), (Cause(_CORRECTED.name, (), ()),), seed)
