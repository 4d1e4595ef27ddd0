"""A simulator that uses one robot file for the trials and another for the references.

References are runs of the robot before it changed: their simulator is that of the file recorded with them,
also where the trials are compared with a corrected one.
"""

from collections.abc import Sequence

from gap.delegate import Delegate
from gap.interfaces import Cause, DataFault, Drive, Observation, Simulator
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial


class TwoMachines(Delegate):
    """Two simulators of the same legs.

    Args:
        own: Simulator of the trials; its name, catalogue and channels are those of the pair.
        other: Simulator of the references.
        references: The references.

    Raises:
        GapError: The two have different legs.
    """

    def __init__(self, own: Simulator, other: Simulator, references: tuple[Trial, ...]) -> None:
        super().__init__(own)
        self._other, self._references = other, references
        if own.joints != other.joints:
            raise GapError(
                f"the robot file has legs {', '.join(own.joints)}, that of the references "
                f"{', '.join(other.joints)}; give one of the same legs"
            )

    def observe(self, trial: Trial) -> Observation:
        """Observe as the trial's simulator does."""
        return self._of(trial).observe(trial)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Predict as the trial's simulator does."""
        return self._of(trial).predict(trial, causes, drive)

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Check as the trial's simulator does."""
        return self._of(trial).check(trial)

    def _of(self, trial: Trial) -> Simulator:
        return self._other if any(trial is one for one in self._references) else self.inner
