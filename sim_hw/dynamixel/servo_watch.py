"""Watchdogs and protections of all servos, looked after together.

Nearly always nothing is beyond a limit. That is found out with the strictest limits of all servos at once;
if anything is beyond those, each servo looks for itself.
"""

from collections.abc import Sequence

from drivers.dynamixel.units import VOLTAGE_UNIT_V, WATCHDOG_UNIT_S
from sim_hw.dynamixel.servo import VirtualServo
from sim_hw.interfaces import MotorReadings

NEVER_NS = 2**62


class ServoWatch:
    """Looks after all servos of a bus.

    Args:
        servos: The servos.
    """

    def __init__(self, servos: Sequence[VirtualServo]) -> None:
        self._servos = servos
        self._changes: list[int] = []
        self._loaded = False  # whether a protection counts how long a load lasts

    def check(self, t_ns: int, motors: MotorReadings) -> None:
        """Let watchdogs trip and protections act, with the motors as they are now."""
        if not self._loaded and self._all_well(t_ns, motors):
            return
        for servo in self._servos:
            servo.check(t_ns, motors)
        self._loaded = any(servo.protection.counts for servo in self._servos)

    def _all_well(self, t_ns: int, motors: MotorReadings) -> bool:
        servos = self._servos
        changes = [servo.table.changes for servo in servos]
        if changes != self._changes:
            self._changes = changes
            self._learn_limits()
        volts, heard_ns = motors.supply_v.tolist(), [servo.heard_ns for servo in servos]
        return (
            t_ns - min(heard_ns) <= self._patience_ns
            and self._least_v <= min(volts) / VOLTAGE_UNIT_V
            and max(volts) / VOLTAGE_UNIT_V <= self._most_v
            and max(motors.temperature_c.tolist()) <= self._most_c
            and max(map(abs, motors.current_a.tolist())) < self._most_a
        )

    def _learn_limits(self) -> None:
        """Take the strictest limits from the registers."""
        tables = [servo.table.values for servo in self._servos]
        units = [table["bus_watchdog"] for table in tables if table["bus_watchdog"] > 0]
        self._patience_ns = min(units) * WATCHDOG_UNIT_S * 1e9 if units else NEVER_NS
        self._least_v = max(table["min_voltage_limit"] for table in tables)
        self._most_v = min(table["max_voltage_limit"] for table in tables)
        self._most_c = min(table["temperature_limit"] for table in tables)
        self._most_a = min(servo.protection.limit_a for servo in self._servos)
