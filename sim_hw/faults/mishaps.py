"""What happens to servos, shafts and the cable of the servo bus in a scenario."""

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from model.values.arrays import FloatArray
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.faults.kinds import (
    Brownout,
    Overheating,
    Overload,
    ScenarioFault,
    SilentServo,
    StuckShaft,
    Unplug,
)
from sim_hw.faults.time import ScenarioTime
from sim_hw.interfaces import FirmwareControl, MotorReadings, MotorWorld

FOREVER_NS = 2**62
MISHAPS = (SilentServo, Brownout, Overheating, Overload, StuckShaft, Unplug)


class DisturbedMotors:
    """``sim_hw.interfaces.MotorWorld`` as the servos' sensors see it when something is wrong.

    Args:
        world: The motors.
        firmware: Tells which ones are driven.
    """

    def __init__(self, world: MotorWorld, firmware: FirmwareControl) -> None:
        self._world = world
        self._firmware = firmware
        self.hot: dict[int, float] = {}
        self.loaded: dict[int, float] = {}

    def advance_to(self, t_ns: int) -> None:
        """Let the world run."""
        self._world.advance_to(t_ns)

    def motors(self) -> MotorReadings:
        """Return what the sensors give; an overload's current flows only while the motor is driven."""
        now, driven = self._world.motors(), self._firmware.driven
        loaded = {i: a for i, a in self.loaded.items() if driven[i]}
        return now._replace(
            current_a=_replaced(now.current_a, loaded),
            temperature_c=_replaced(now.temperature_c, self.hot),
        )

    def jam(self, index: int, torque_n_m: float) -> None:
        """Jam a shaft, or free it."""
        self._world.jam(index, torque_n_m)


def _replaced(values: FloatArray, others: dict[int, float]) -> FloatArray:
    changed = np.array(values, dtype=np.float64)
    for index, value in others.items():
        changed[index] = value
    return changed


class ServoMishaps:
    """Brings mishaps about at their time and puts things right at their end.

    Args:
        bus: The servos.
        motors: What their sensors see; the bus was built on it.
        faults: All faults of the scenario.
        time: The scenario's time.
    """

    def __init__(
        self,
        bus: VirtualServoBus,
        motors: DisturbedMotors,
        faults: Sequence[ScenarioFault],
        time: ScenarioTime,
    ) -> None:
        self._bus = bus
        self._motors = motors
        self._time = time
        self._faults = [fault for fault in faults if isinstance(fault, MISHAPS)]
        self._active: list[ScenarioFault] = []
        self._index = {servo.servo_id: i for i, servo in enumerate(bus.servos)}
        self._silent: set[int] = set()
        self._applied_ns = -1
        self._up_to_date = False
        self._times: list[int] | None = None
        self.plugged = True

    def any_torque(self) -> bool:
        """Whether any servo has torque."""
        return any(servo.table.get("torque_enable") for servo in self._bus.servos)

    def changes(self, until_ns: int) -> list[int]:
        """Return the times up to ``until_ns`` at which a mishap starts or ends, since the last one."""
        if until_ns <= self._applied_ns:  # asked for at every byte
            return []
        times = self._all_changes()
        return times[bisect_right(times, self._applied_ns) : bisect_right(times, until_ns)]

    def _all_changes(self) -> list[int]:
        """Return every time at which a mishap starts or ends, in order; none before second 0 is known."""
        if self._times is None:
            if not self._time.begun:
                return []
            self._times = self._time.changes(self._faults, -1, FOREVER_NS)
        return self._times

    def apply(self, t_ns: int) -> None:
        """Make things be as they are at a time."""
        if self._up_to_date and self._applied_ns <= t_ns and not self.changes(t_ns):
            self._applied_ns = t_ns
            return
        self._applied_ns, self._up_to_date = t_ns, self._time.begun
        before = self._active
        self._active = [fault for fault in self._faults if self._time.active(fault, t_ns)]
        for fault in self._faults:
            if isinstance(fault, Brownout) and (fault in before) != (fault in self._active):
                self._lose_power(fault, t_ns)
        if self._active != before:
            self._set_all(self._active)

    def _lose_power(self, fault: Brownout, t_ns: int) -> None:
        """RAM goes when the power goes; turns made without it are not counted when it comes back."""
        for i in self._targets(fault.servo):
            self._bus.servos[i].restart(t_ns)

    def _targets(self, servo_id: int | None) -> list[int]:
        return (
            [self._index[servo_id]] if servo_id is not None else list(range(len(self._bus.servos)))
        )

    def _set_all(self, active: Sequence[ScenarioFault]) -> None:
        silent: dict[int, bool] = {}
        jammed = dict.fromkeys(range(len(self._bus.servos)), 0.0)
        self._motors.hot.clear()
        self._motors.loaded.clear()
        for fault in active:
            match fault:
                case SilentServo():
                    silent[fault.servo] = silent.get(fault.servo, False) or fault.chain_breaks
                case Brownout():
                    for i in self._targets(fault.servo):
                        silent.setdefault(self._bus.servos[i].servo_id, False)
                case Overheating():
                    self._motors.hot[self._index[fault.servo]] = fault.temperature_c
                case Overload():
                    self._motors.loaded[self._index[fault.servo]] = fault.current_a
                case StuckShaft():
                    jammed[self._index[fault.servo]] += fault.torque_n_m
        self.plugged = not any(isinstance(fault, Unplug) for fault in active)
        self._silence(silent)
        for i, torque_n_m in jammed.items():
            self._motors.jam(i, torque_n_m)

    def _silence(self, silent: dict[int, bool]) -> None:
        """Take servos off the wire; put back only those that we took."""
        for servo_id in self._silent - set(silent):
            self._bus.silence(servo_id, on=False)
        for servo_id, chain_breaks in silent.items():
            self._bus.silence(servo_id, chain_breaks=chain_breaks)
        self._silent = set(silent)
