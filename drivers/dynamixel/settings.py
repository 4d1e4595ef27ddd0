"""Settings of the servo bus, as the robot file has them. N legs."""

from dataclasses import dataclass

import numpy as np

from drivers.dynamixel.servo_model import ServoModel
from model.values.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class ServoBusSettings:
    """The servo bus and how each leg's servo is mounted.

    Attributes:
        names: Leg names, N of them.
        ids: Dynamixel id of each leg, (N,) int64.
        signs: +1 where increasing position moves a stance foot backward, else -1, (N,) int64.
        zeros: Position ticks at shaft angle 0, (N,) int64.
        models: Model of each leg's servo, N of them.
        baud_rate: [baud].
        watchdog_s: Bus watchdog time [s], 0.02 to 2.54, in steps of 20 ms.
        silent_limit: Reads in a row without an answer before the robot stops.
    """

    names: tuple[str, ...]
    ids: IntArray
    signs: IntArray
    zeros: IntArray
    models: tuple[ServoModel, ...]
    baud_rate: int
    watchdog_s: float
    silent_limit: int

    @property
    def model_of_leg(self) -> dict[str, ServoModel]:
        """Model of the servo by leg name."""
        return dict(zip(self.names, self.models, strict=True))

    @property
    def model_of_id(self) -> dict[int, ServoModel]:
        """Model of the servo by Dynamixel id."""
        return dict(zip(self.ids.tolist(), self.models, strict=True))

    @property
    def current_unit_a(self) -> FloatArray:
        """One count of each servo's current, (N,) [A]; NaN where it measures none."""
        units: FloatArray = np.array([model.current_unit_a for model in self.models])
        return units

    @property
    def measures_current(self) -> BoolArray:
        """Whose current is measured, (N,)."""
        measured: BoolArray = np.array([model.measures_current for model in self.models])
        return measured
