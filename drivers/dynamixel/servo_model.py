"""One model of servo as data: its registers, units, modes, and what its motor can do."""

import math
from dataclasses import dataclass

from drivers.dynamixel.registers import OperatingMode, RegisterTable
from drivers.dynamixel.units import BAUD_RATES_BY_CODE, VELOCITY_UNIT_RAD_S, VOLTAGE_UNIT_V


@dataclass(frozen=True, slots=True)
class MotorRatings:
    """What the data sheet says of motor and gear, at one voltage.

    Attributes:
        voltage_v: At which voltage.
        stall_torque_n_m: Momentary torque at standstill.
        stall_current_a: Current at standstill.
        no_load_rpm: Speed without load [rev/min].
    """

    voltage_v: float
    stall_torque_n_m: float
    stall_current_a: float
    no_load_rpm: float

    @property
    def no_load_rad_s(self) -> float:
        """Speed without load [rad/s]."""
        return self.no_load_rpm * 2 * math.pi / 60


@dataclass(frozen=True, slots=True, eq=False)
class ServoModel:
    """A model of servo with protocol 2.0. Two of them are equal only if they are the same.

    Attributes:
        name: Its name, as robot files have it.
        number: Model number, register 0.
        table: Its registers.
        current_unit_a: One count of current [A]; NaN where it measures a load and no current.
        modes: Operating modes it has.
        ratings: What its motor can do.
        watchdog_firmware: First firmware version with a bus watchdog.
    """

    name: str
    number: int
    table: RegisterTable
    current_unit_a: float
    modes: frozenset[OperatingMode]
    ratings: MotorRatings
    watchdog_firmware: int

    @property
    def measures_current(self) -> bool:
        """Whether it has a current; it has a load otherwise, inferred from its own output."""
        return math.isfinite(self.current_unit_a)

    @property
    def highest_speed_rad_s(self) -> float:
        """Largest speed that its velocity limit can be set to [rad/s]."""
        return self.table["velocity_limit"].maximum * VELOCITY_UNIT_RAD_S

    @property
    def highest_current_a(self) -> float:
        """Largest current that its current limit can be set to [A]; NaN where it measures none."""
        if not self.measures_current:
            return math.nan
        return self.table["current_limit"].maximum * self.current_unit_a

    @property
    def lowest_voltage_v(self) -> float:
        """Smallest supply voltage that its limits can be set to [V]."""
        return self.table["min_voltage_limit"].minimum * VOLTAGE_UNIT_V

    @property
    def highest_voltage_v(self) -> float:
        """Largest supply voltage that its limits can be set to [V]."""
        return self.table["max_voltage_limit"].maximum * VOLTAGE_UNIT_V

    @property
    def baud_rates(self) -> tuple[int, ...]:
        """Baud rates it can be set to."""
        return BAUD_RATES_BY_CODE[: self.table["baud_rate"].maximum + 1]
