"""What happens to servos, shafts and the cable of the servo bus in a scenario."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from model.values.arrays import FloatArray
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.faults.kinds import Fault
from sim_hw.faults.servo_kinds import (
    Brownout,
    Overheating,
    Overload,
    SilentServo,
    StuckShaft,
    Unplug,
)
from sim_hw.faults.time import ScenarioTime
from sim_hw.interfaces import FirmwareControl, MotorWorld

FOREVER_NS = 2**62
MISHAPS = (SilentServo, Brownout, Overheating, Overload, StuckShaft, Unplug)


class Jammable(MotorWorld, Protocol):
    """Motors whose shafts can be jammed."""

    def jam(self, index: int, torque_n_m: float) -> None:
        """Give a shaft so much dry friction on top of its own; 0 frees it."""
        ...


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

    @property
    def encoder_ticks(self) -> FloatArray:
        """Output position."""
        return self._world.encoder_ticks

    @property
    def encoder_rate(self) -> FloatArray:
        """Output speed."""
        return self._world.encoder_rate

    @property
    def current_a(self) -> FloatArray:
        """Motor current; that of an overload flows only while the motor is driven."""
        driven = self._firmware.driven
        return _replaced(self._world.current_a, {i: a for i, a in self.loaded.items() if driven[i]})

    @property
    def supply_v(self) -> FloatArray:
        """Voltage at each servo."""
        return self._world.supply_v

    @property
    def temperature_c(self) -> FloatArray:
        """Motor temperature."""
        return _replaced(self._world.temperature_c, self.hot)


def _replaced(values: FloatArray, others: dict[int, float]) -> FloatArray:
    changed = np.array(values, dtype=np.float64)
    for index, value in others.items():
        changed[index] = value
    return changed


@dataclass(slots=True)
class _Watched:
    fault: Fault
    on: bool = False


class ServoMishaps:
    """Brings mishaps about at their time and puts things right at their end.

    Args:
        bus: The servos.
        motors: What their sensors see; the bus was built on it.
        world: The motors themselves.
        faults: All faults of the scenario.
        time: The scenario's time.
    """

    def __init__(
        self,
        bus: VirtualServoBus,
        motors: DisturbedMotors,
        world: Jammable,
        faults: Sequence[Fault],
        time: ScenarioTime,
    ) -> None:
        self._bus = bus
        self._motors = motors
        self._world = world
        self._time = time
        self._watched = [_Watched(fault) for fault in faults if isinstance(fault, MISHAPS)]
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
        times = self._all_changes()
        return times[bisect_right(times, self._applied_ns) : bisect_right(times, until_ns)]

    def _all_changes(self) -> list[int]:
        """Return every time at which a mishap starts or ends, in order; none before second 0 is known."""
        if self._times is None:
            if not self._time.begun:
                return []
            faults = [watched.fault for watched in self._watched]
            self._times = self._time.changes(faults, -1, FOREVER_NS)
        return self._times

    def apply(self, t_ns: int) -> None:
        """Make things be as they are at a time."""
        if self._up_to_date and self._applied_ns <= t_ns and not self.changes(t_ns):
            self._applied_ns = t_ns
            return
        self._applied_ns, self._up_to_date = t_ns, self._time.begun
        changed = False
        for watched in self._watched:
            on = self._time.active(watched.fault, t_ns)
            if on != watched.on:
                watched.on, changed = on, True
                if isinstance(watched.fault, Brownout):
                    self._lose_power(watched.fault, t_ns)
        if changed:
            self._set_all([watched.fault for watched in self._watched if watched.on])

    def _lose_power(self, fault: Brownout, t_ns: int) -> None:
        """RAM goes when the power goes; turns made without it are not counted when it comes back."""
        for i in self._targets(fault.servo):
            self._bus.servos[i].restart(t_ns)

    def _targets(self, servo_id: int | None) -> list[int]:
        return [self._index[servo_id]] if servo_id is not None else list(self._index.values())

    def _set_all(self, active: Sequence[Fault]) -> None:
        silent: dict[int, bool] = {}
        jammed = dict.fromkeys(self._index.values(), 0.0)
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
            self._world.jam(i, torque_n_m)

    def _silence(self, silent: dict[int, bool]) -> None:
        """Take servos off the wire; put back only those that we took."""
        for servo_id in self._silent - set(silent):
            self._bus.silence(servo_id, on=False)
        for servo_id, chain_breaks in silent.items():
            self._bus.silence(servo_id, chain_breaks=chain_breaks)
        self._silent = set(silent)
