"""A simulator that believes one robot file of the trials and another of the references.

References are runs of the robot before it changed: their simulator is that of the file beside them, also
where the trials are held against a corrected one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from gap.interfaces import Cause, Channel, DataFault, Drive, Effect, Observation, Simulator
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial


@dataclass(frozen=True, slots=True, eq=False)
class TwoMachines:
    """Implements ``gap.interfaces.Simulator``.

    Attributes:
        own: Simulator of the trials.
        other: Simulator of the references.
        references: The references.
    """

    own: Simulator
    other: Simulator
    references: tuple[Trial, ...]

    def __post_init__(self) -> None:
        if self.own.joints != self.other.joints:
            raise GapError(
                f"the robot file has legs {', '.join(self.own.joints)}, that of the references "
                f"{', '.join(self.other.joints)}; give one of the same legs"
            )

    @property
    def name(self) -> str:
        """Name of the trials' simulator."""
        return self.own.name

    @property
    def stages(self) -> tuple[str, ...]:
        """Its stages."""
        return self.own.stages

    @property
    def joints(self) -> tuple[str, ...]:
        """Its joints."""
        return self.own.joints

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Its catalogue."""
        return self.own.effects

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Its channels."""
        return self.own.channels

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
        return self.other if any(trial is one for one in self.references) else self.own
