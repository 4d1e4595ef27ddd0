"""The world behind the virtual devices: plant and firmware running together in fixed steps.

It knows the mounting of the servos (sign, zero) and of the transducers, and nothing of bytes.
"""

from collections import deque

import numpy as np

from drivers.mx106 import TICK_RAD
from model.signals import BodyTruth, FloatArray, IntArray
from sim_hw.interfaces import FirmwareControl
from sim_hw.plant import Plant

# A transducer averages over its sample period; nobody samples slower than this.
LONGEST_WINDOW_STEPS = 1000


class World:
    """Plant and firmware; ``sim_hw.interfaces.MotorWorld`` and ``WrenchSource``.

    Args:
        plant: The robot.
        firmware: The servos' control loops.
        signs: +1 where increasing servo position moves a stance foot backward, else -1, (N,).
        zeros: Servo ticks at shaft angle 0, (N,).
        sensor_offset_m: Transducer origin from the crank shaft, body axes, (N, 3).
        sensor_yaw_rad: Rotation about z from body axes to sensor axes, (N,).
    """

    def __init__(
        self,
        plant: Plant,
        firmware: FirmwareControl,
        *,
        signs: IntArray,
        zeros: IntArray,
        sensor_offset_m: FloatArray,
        sensor_yaw_rad: FloatArray,
    ) -> None:
        self.plant = plant
        self._firmware = firmware
        self._signs = signs.astype(np.float64)
        self._zeros = zeros.astype(np.float64)
        self._origin = plant.parameters.shaft_position + sensor_offset_m
        self._cosine, self._sine = np.cos(sensor_yaw_rad), np.sin(sensor_yaw_rad)
        self._step_ns = round(plant.dt_s * 1e9)
        self._now_ns: int | None = None
        self._recent: deque[tuple[int, FloatArray]] = deque(maxlen=LONGEST_WINDOW_STEPS)
        self._last_wrench = self._sensor_wrench()

    def advance_to(self, t_ns: int) -> None:
        """Run in whole steps up to a time, never beyond it. The first call sets the beginning."""
        if self._now_ns is None:
            self._now_ns = t_ns
        while self._now_ns + self._step_ns <= t_ns:
            self._now_ns += self._step_ns
            self._step()

    def stand_still_until(self, t_ns: int) -> None:
        """Skip the time until ``t_ns``, in which nothing happens; nothing if it is already there."""
        if self._now_ns is not None:
            self._now_ns = max(self._now_ns, t_ns)

    def _step(self) -> None:
        plant = self.plant
        duty = self._firmware.duty(
            self.encoder_ticks, self.encoder_rate, self.current_a, plant.dt_s
        )
        plant.step(duty * self._signs, self._firmware.driven)
        self._recent.append((self._now_ns or 0, self._sensor_wrench()))

    # As the servos see it.

    @property
    def encoder_ticks(self) -> FloatArray:
        """Output position, continuous, (N,) [ticks]."""
        ticks: FloatArray = self._zeros + self._signs * self.plant.shaft_angle_rad / TICK_RAD
        return ticks

    @property
    def encoder_rate(self) -> FloatArray:
        """Output speed in the servo's own sense, (N,) [rad/s]."""
        rate: FloatArray = self._signs * self.plant.shaft_rate_rad_s
        return rate

    @property
    def current_a(self) -> FloatArray:
        """Motor current in the servo's own sense, (N,) [A]."""
        current: FloatArray = self._signs * self.plant.motors.current_a
        return current

    @property
    def supply_v(self) -> FloatArray:
        """Voltage at each servo, (N,) [V]."""
        return self.plant.motors.supply_v

    @property
    def temperature_c(self) -> FloatArray:
        """Motor temperature, (N,) [degC]."""
        return self.plant.motors.temperature_c

    def jam(self, index: int, torque_n_m: float) -> None:
        """Give a shaft so much dry friction on top of its own; 0 frees it."""
        self.plant.jam_n_m[index] = torque_n_m

    # As the transducers see it.

    def wrench(self, t_ns: int) -> FloatArray:
        """Mean wrench on each transducer between the last call's time and this one.

        Returns:
            (N, 6) [N, N m], sensor axes: the ground's force on the foot, moment about the transducer.
        """
        self.advance_to(t_ns)
        window: list[FloatArray] = []
        while self._recent and self._recent[0][0] <= t_ns:
            window.append(self._recent.popleft()[1])
        if window:
            self._last_wrench = np.mean(window, axis=0)
        return self._last_wrench

    def _sensor_wrench(self) -> FloatArray:
        """The ground's force on each foot, and its moment about the transducer, now."""
        plant = self.plant
        rotation = plant.torso_rotation
        force = plant.foot_force_W @ rotation  # body axes
        lever = plant.feet_B - self._origin
        (fx, fy, fz), (x, y, z) = force.T, lever.T
        tx, ty = y * fz - z * fy, z * fx - x * fz
        c, s = self._cosine, self._sine
        wrench = np.empty((len(force), 6))
        wrench[:, 0], wrench[:, 1], wrench[:, 2] = c * fx + s * fy, c * fy - s * fx, fz
        wrench[:, 3], wrench[:, 4], wrench[:, 5] = c * tx + s * ty, c * ty - s * tx, x * fy - y * fx
        return wrench

    def truth(self, t_ns: int) -> BodyTruth:
        """Advance to a time and return where everything is."""
        self.advance_to(t_ns)
        return self.plant.truth(t_ns)
