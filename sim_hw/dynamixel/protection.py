"""How a virtual servo protects itself: which hardware errors it sees.

The manual publishes no criterion for overload and no delay for the voltage error: overload here is a motor
current above a limit for some seconds (``ServoAssumed``; in proportion to a model's stall current), and the
voltage error has no delay.
"""

from collections.abc import Mapping

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.registers import HardwareError
from drivers.dynamixel.servo_model import MotorRatings
from drivers.dynamixel.units import VOLTAGE_UNIT_V
from sim_hw.assumed import ServoAssumed
from sim_hw.interfaces import MotorReadings


class Protection:
    """Watches over one servo.

    Args:
        index: Its place in the world.
        assumed: When a load is an overload.
        ratings: Of its motor.

    Attributes:
        limit_a: Current from which a load may become an overload.
    """

    def __init__(self, index: int, assumed: ServoAssumed, ratings: MotorRatings) -> None:
        self._index = index
        share = ratings.stall_current_a / MX_106.ratings.stall_current_a
        self.limit_a = share * assumed.overload_current_a
        self._limit_ns = round(assumed.overload_s * 1e9)
        self._since_ns: int | None = None

    def restart(self) -> None:
        """Forget how long the load has lasted."""
        self._since_ns = None

    @property
    def counts(self) -> bool:
        """Whether a load lasts that may become an overload."""
        return self._since_ns is not None

    def errors(
        self, registers: Mapping[str, int], t_ns: int, motors: MotorReadings, *, torque: bool
    ) -> int:
        """Return the bits of Hardware Error Status that hold now.

        Args:
            registers: The servo's registers by name; its limits are among them.
            t_ns: Now.
            motors: What the sensors give.
            torque: Whether its torque is on.
        """
        i = self._index
        error = 0
        volts = motors.supply_v.item(i) / VOLTAGE_UNIT_V
        if not registers["min_voltage_limit"] <= volts <= registers["max_voltage_limit"]:
            error |= HardwareError.INPUT_VOLTAGE
        if motors.temperature_c.item(i) > registers["temperature_limit"]:
            error |= HardwareError.OVERHEATING
        if not torque or abs(motors.current_a.item(i)) < self.limit_a:
            self._since_ns = None
        elif self._since_ns is None:
            self._since_ns = t_ns
        elif t_ns - self._since_ns > self._limit_ns:
            error |= HardwareError.OVERLOAD
        return error
