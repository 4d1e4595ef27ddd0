"""A simulator that another one answers for: a base class for simulators that differ in one thing."""

from collections.abc import Sequence

from gap.interfaces import Cause, DataFault, Drive, Observation, Simulator
from model.values.arrays import FloatArray
from record.trial.trial import Trial


class Delegate:
    """Implements ``gap.interfaces.Simulator`` by asking another simulator.

    Args:
        inner: The simulator that answers.
    """

    def __init__(self, inner: Simulator) -> None:
        self.inner = inner
        self.name, self.stages, self.joints = inner.name, inner.stages, inner.joints
        self.effects, self.channels = inner.effects, inner.channels

    def observe(self, trial: Trial) -> Observation:
        """Observe as the inner simulator does."""
        return self.inner.observe(trial)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Predict as the inner simulator does."""
        return self.inner.predict(trial, causes, drive)

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Check as the inner simulator does."""
        return self.inner.check(trial)
