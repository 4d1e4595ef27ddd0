"""Motors for tests of the virtual servos: first order, no load, no plant."""

import numpy as np

from model.values.arrays import FloatArray
from sim_hw.interfaces import FirmwareControl, MotorReadings

STEP_NS = 1_000_000
NO_LOAD_RAD_S = 4.7
TIME_CONSTANT_S = 0.011


class SimpleMotors:
    """``sim_hw.interfaces.MotorWorld`` without a robot."""

    def __init__(self, firmware: FirmwareControl, count: int) -> None:
        self._firmware = firmware
        self._now_ns: int | None = None
        self.ticks = np.full(count, 2048.0)
        self.rate = np.zeros(count)
        self.currents = np.zeros(count)
        self.volts = np.full(count, 12.0)
        self.temperature_c: FloatArray = np.full(count, 30.0)
        self.hold = False
        self.jammed = np.zeros(count)

    def advance_to(self, t_ns: int) -> None:
        if self._now_ns is None:
            self._now_ns = t_ns
        while self._now_ns + STEP_NS <= t_ns:
            self._now_ns += STEP_NS
            duty = self._firmware.duty(self.ticks, self.rate, self.currents, STEP_NS * 1e-9)
            if not self.hold:
                final = np.where(self._firmware.driven, duty, 0.0) * NO_LOAD_RAD_S
                final = np.where(self.jammed > 0, 0.0, final)
                self.rate += (final - self.rate) * (STEP_NS * 1e-9 / TIME_CONSTANT_S)
                self.ticks += self.rate * STEP_NS * 1e-9 * 4096 / (2 * np.pi)

    def jam(self, index: int, torque_n_m: float) -> None:
        self.jammed[index] = torque_n_m

    def motors(self) -> MotorReadings:
        return MotorReadings(self.ticks, self.rate, self.currents, self.volts, self.temperature_c)
