"""Predictions by channel name, for the tests of single effects."""

from collections.abc import Sequence

import numpy as np

from gap.interfaces import Cause, Drive
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.walks import cause, machine, simulator

COULOMB = cause("coulomb_friction")
LEGS = machine().legs.names
ML = LEGS.index("ML")


class Prediction:
    """Channels of one prediction: (F, N) for legs, (F,) for the body."""

    def __init__(
        self, trial: Trial, causes: Sequence[Cause] = (), drive: Drive = Drive.COMMAND
    ) -> None:
        self._values = simulator().predict(trial, causes, drive)
        self.time_s = simulator().observe(trial).time_s

    def __getitem__(self, name: str) -> FloatArray:
        at = [k for k, channel in enumerate(simulator().channels) if channel.name == name]
        values: FloatArray = self._values[:, at]
        return values[:, 0] if simulator().channels[at[0]].joint == "" else values

    @property
    def feet(self) -> FloatArray:
        """Foot markers, (F, N, 3)."""
        return np.stack([self[f"foot_{a}"] for a in "xyz"], axis=2)

    @property
    def force(self) -> FloatArray:
        """Foot forces, (F, N, 3)."""
        return np.stack([self[f"force_{a}"] for a in "xyz"], axis=2)


def inside(values: FloatArray, margin: int = 10) -> FloatArray:
    """Without the ends, where filters differ."""
    return values[margin:-margin]
