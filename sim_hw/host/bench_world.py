"""Motors on a bench: the servos' world without a body, for runs of hours in minutes.

Each shaft is a first-order lag behind its motor's voltage and stops where it is jammed. The transducers
feel a body of a given weight spread evenly over all feet, whatever the legs do, so nothing can be learned
here about walking; for that there is ``sim_hw.host.world``. Figures of the motor: MX-106 data sheet, 12 V;
other models in proportion to their own.
"""

import math
from collections.abc import Sequence

import numpy as np

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.units import TICK_RAD
from model.values.arrays import FloatArray, IntArray
from sim_hw.interfaces import FirmwareControl, MotorReadings

STEP_NS = 2_500_000
NO_LOAD_RAD_S = 4.71
STALL_CURRENT_A = 5.2
TIME_CONSTANT_S = 0.011
SUPPLY_V = 12.0
AMBIENT_C = 30.0


class BenchWorld:
    """``sim_hw.interfaces.MotorWorld`` and ``WrenchSource`` without a plant.

    Args:
        firmware: The servos' control loops.
        zeros: Servo ticks at shaft angle 0, where the shafts begin, (N,).
        weight_n: What all transducers together feel, upward [N].
        models: Each servo's model; MX-106 where none are given.
        supply_v: Voltage at the servos.
    """

    def __init__(
        self,
        firmware: FirmwareControl,
        zeros: IntArray,
        weight_n: float,
        models: Sequence[ServoModel] = (),
        supply_v: float = SUPPLY_V,
    ) -> None:
        count = len(zeros)
        ratings = [model.ratings for model in models or [MX_106] * count]
        one = MX_106.ratings
        volts = np.array([supply_v / rating.voltage_v for rating in ratings])
        rpm = np.array([rating.no_load_rpm / one.no_load_rpm for rating in ratings])
        amperes = np.array([rating.stall_current_a / one.stall_current_a for rating in ratings])
        self._no_load_rad_s = NO_LOAD_RAD_S * (rpm * volts)
        self._stall_a = STALL_CURRENT_A * (amperes * volts)
        self._firmware = firmware
        self._now_ns: int | None = None
        self._gain = 1.0 - math.exp(-STEP_NS * 1e-9 / TIME_CONSTANT_S)
        self._ticks = zeros.astype(np.float64)
        self._rate = np.zeros(count)
        self._current = np.zeros(count)
        self._jammed = np.zeros(count, dtype=bool)
        self._supply: FloatArray = np.full(count, supply_v)
        self._temperature: FloatArray = np.full(count, AMBIENT_C)
        self._wrench = np.zeros((count, 6))
        self._wrench[:, 2] = weight_n / count

    def advance_to(self, t_ns: int) -> None:
        """Run in whole steps up to a time; the first call sets the beginning."""
        if self._now_ns is None:
            self._now_ns = t_ns
        while self._now_ns + STEP_NS <= t_ns:
            self._now_ns += STEP_NS
            self._step()
            self.stepped(self._now_ns)

    def stepped(self, t_ns: int) -> None:
        """Called behind every step, for whoever wants to look."""

    def _step(self) -> None:
        dt_s = STEP_NS * 1e-9
        duty = self._firmware.duty(self._ticks, self._rate, self._current, dt_s)
        free = self._firmware.driven & ~self._jammed
        self._rate = np.where(
            free, self._rate + (duty * self._no_load_rad_s - self._rate) * self._gain, 0
        )
        self._ticks = self._ticks + self._rate * (dt_s / TICK_RAD)
        self._current = (duty - self._rate / self._no_load_rad_s) * self._stall_a

    def stand_still_until(self, t_ns: int) -> None:
        """Skip the time until ``t_ns``, in which nothing happens."""
        if self._now_ns is not None:
            self._now_ns = max(self._now_ns, t_ns)

    def jam(self, index: int, torque_n_m: float) -> None:
        """Hold a shaft fast; 0 frees it."""
        self._jammed[index] = torque_n_m > 0

    def motors(self) -> MotorReadings:
        """Return what the servos' sensors give."""
        return MotorReadings(
            self._ticks, self._rate, self._current, self._supply, self._temperature
        )

    def wrench(self, t_ns: int) -> FloatArray:
        """Wrench on each transducer, (N, 6) [N, N m], sensor axes."""
        self.advance_to(t_ns)
        return self._wrench

    def truth(self, t_ns: int) -> None:
        """Let time pass; there is no body whose place could be told."""
        self.advance_to(t_ns)
