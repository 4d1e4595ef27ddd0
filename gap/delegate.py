"""Simulators that differ from another one in one thing, and leave it all else."""

from collections.abc import Sequence

from gap.interfaces import Cause, DataFault, Drive, Observation, Simulator, check_causes
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial


class Delegate:
    """Implements ``gap.interfaces.Simulator`` by asking another simulator."""

    def __init__(self, inner: Simulator) -> None:
        self.inner = inner
        self.name, self.stages, self.joints = inner.name, inner.stages, inner.joints
        self.effects, self.channels = inner.effects, inner.channels

    def observe(self, trial: Trial) -> Observation:
        """Observe as the trial's simulator does."""
        return self.of(trial).observe(trial)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Predict as the trial's simulator does."""
        return self.of(trial).predict(trial, causes, drive)

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Check as the trial's simulator does."""
        return self.of(trial).check(trial)

    def of(self, trial: Trial) -> Simulator:
        """Return the simulator that answers for a trial."""
        del trial
        return self.inner


class TwoMachines(Delegate):
    """One robot file for the trials, whose catalogue and channels are the pair's, another for references.

    References are runs of the robot before it changed: their simulator is that of the file recorded with
    them, also where the trials are compared with a corrected one.

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

    def of(self, trial: Trial) -> Simulator:
        """Return the simulator of a trial or of a reference."""
        return self._other if any(trial is one for one in self._references) else self.inner


class Without(Delegate):
    """A simulator that lacks some effects, by name: what is diagnosed when the cause has no name?"""

    def __init__(self, whole: Simulator, missing: Sequence[str]) -> None:
        super().__init__(whole)
        self.effects = tuple(effect for effect in whole.effects if effect.name not in missing)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Predict as the whole simulator does.

        Raises:
            GapError: A cause is a missing one.
        """
        check_causes(causes, self)
        return super().predict(trial, causes, drive)
