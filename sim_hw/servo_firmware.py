"""The control loop in the servos' firmware, for all servos at once.

Source: ROBOTIS e-manual, MX-106(2.0), "Operating Mode", gains and profiles: position mode is a PID with
feedforward on the difference between trajectory and encoder, in PWM counts; K_P = n/128,
K_I = n/65536, K_D = n/16, feedforward n/4. The loop's own rate is not published ("much faster than
1 kHz"); here it runs once a physics step. Units inside: ticks, ticks/s, PWM counts (885 = 100 %).
"""

import numpy as np

from drivers.mx106 import (
    CURRENT_UNIT_A,
    DUTY_FULL,
    TICK_RAD,
    VELOCITY_UNIT_RAD_S,
    OperatingMode,
)
from model.signals import BoolArray, FloatArray

# Acceleration unit: 1 count of velocity in 64 ms.
ACCELERATION_UNIT_RAD_S2 = VELOCITY_UNIT_RAD_S / 0.064
POSITION_MODES = (
    OperatingMode.POSITION,
    OperatingMode.EXTENDED_POSITION,
    OperatingMode.CURRENT_BASED_POSITION,
)


class FirmwareBank:
    """Registers of the control loop and its state, one entry a servo.

    The virtual servos write the registers; the world calls ``duty`` once a physics step.

    Args:
        count: Number of servos.
    """

    def __init__(self, count: int) -> None:
        self.count = count
        self.mode = np.full(count, int(OperatingMode.POSITION))
        self.torque = np.zeros(count, dtype=bool)
        self.stopped = np.zeros(count, dtype=bool)  # held by a tripped watchdog
        self.goal_position = np.zeros(count)  # ticks
        self.goal_velocity = np.zeros(count)  # counts
        self.goal_current = np.zeros(count)  # counts
        self.goal_pwm = np.full(count, float(DUTY_FULL))
        self.pwm_limit = np.full(count, float(DUTY_FULL))
        self.position_p = np.full(count, 850.0)
        self.position_i = np.zeros(count)
        self.position_d = np.zeros(count)
        self.velocity_p = np.full(count, 100.0)
        self.velocity_i = np.full(count, 1920.0)
        self.feedforward_1 = np.zeros(count)
        self.feedforward_2 = np.zeros(count)
        self.profile_velocity = np.zeros(count)  # counts, 0 = step
        self.profile_acceleration = np.zeros(count)  # counts, 0 = rectangular
        self.trajectory = np.zeros(count)  # ticks
        self.trajectory_rate = np.zeros(count)  # ticks/s
        self.ramp_velocity = np.zeros(count)  # counts; goal of the velocity loop on its ramp
        self.pwm = np.zeros(count)  # last output, counts
        self._integral = np.zeros(count)  # PWM counts, one integrator a loop
        self._velocity_integral = np.zeros(count)
        self._current_integral = np.zeros(count)
        self._last_error = np.zeros(count)

    @property
    def driven(self) -> BoolArray:
        """True where the output stage is on."""
        return self.torque

    def restart(self, index: int, ticks: float) -> None:
        """Begin anew at a position: torque switched on, mode changed, power came back."""
        self.trajectory[index] = ticks
        self.trajectory_rate[index] = 0.0
        self.ramp_velocity[index] = 0.0
        for integral in (self._integral, self._velocity_integral, self._current_integral):
            integral[index] = 0.0
        self._last_error[index] = 0.0

    def profile_ongoing(self) -> BoolArray:
        """True where the trajectory has not reached its goal."""
        return np.abs(self.goal_position - self.trajectory) > 0.5

    def planned_velocity(self, index: int) -> float:
        """Return the velocity that the profile asks for now [counts]."""
        if self.mode[index] == OperatingMode.VELOCITY:
            return float(self.ramp_velocity[index])
        return float(self.trajectory_rate[index]) * TICK_RAD / VELOCITY_UNIT_RAD_S

    def duty(
        self, ticks: FloatArray, rate_rad_s: FloatArray, current_a: FloatArray, dt_s: float
    ) -> FloatArray:
        """Return the PWM duty of each servo, -1 to 1; 0 where torque is off."""
        self._advance_trajectory(dt_s)
        position = (self.mode >= POSITION_MODES[0]) & (self.mode <= POSITION_MODES[-1])
        pwm = np.where(position, self._position_loop(ticks, dt_s), 0.0)
        if not position.all():
            pwm = np.where(
                self.mode == OperatingMode.VELOCITY, self._velocity_loop(rate_rad_s, dt_s), pwm
            )
            pwm = np.where(self.mode == OperatingMode.PWM, self.goal_pwm, pwm)
            current_goal = self.goal_current * CURRENT_UNIT_A
            wanted = self._current_loop(current_goal, current_a, dt_s)
            pwm = np.where(self.mode == OperatingMode.CURRENT, wanted, pwm)
        ceiling = np.minimum(self.pwm_limit, np.abs(self.goal_pwm))
        if (self.mode == OperatingMode.PWM).any():
            ceiling = np.where(self.mode == OperatingMode.PWM, self.pwm_limit, ceiling)
        self.pwm = np.where(self.torque, np.clip(pwm, -ceiling, ceiling), 0.0)
        output: FloatArray = self.pwm / DUTY_FULL
        return output

    def _advance_trajectory(self, dt_s: float) -> None:
        """Step, rectangular or trapezoidal approach of the trajectory to the goal."""
        to_go = self.goal_position - self.trajectory
        moving = ~self.stopped
        if not self.profile_velocity.any():
            self.trajectory = np.where(moving, self.goal_position, self.trajectory)
            self.trajectory_rate = np.zeros(self.count)
            return
        to_ticks = 1.0 / TICK_RAD
        top = self.profile_velocity * VELOCITY_UNIT_RAD_S * to_ticks  # ticks/s
        ramp = self.profile_acceleration * ACCELERATION_UNIT_RAD_S2 * to_ticks  # ticks/s^2
        # fastest speed from which the ramp can still stop at the goal
        braking = np.sqrt(2 * np.maximum(ramp, 0.0) * np.abs(to_go))
        speed = np.where(ramp > 0, np.minimum(top, braking), top)
        wanted = np.sign(to_go) * speed
        step = np.where(ramp > 0, ramp * dt_s, np.inf)
        change = np.clip(wanted - self.trajectory_rate, -step, step)
        rate = self.trajectory_rate + change
        way = np.clip(rate * dt_s, -np.abs(to_go), np.abs(to_go))
        free = top == 0
        self.trajectory = np.where(
            moving, np.where(free, self.goal_position, self.trajectory + way), self.trajectory
        )
        arrived = np.abs(self.goal_position - self.trajectory) < 1e-9
        self.trajectory_rate = np.where(free | arrived | ~moving, 0.0, rate)

    def _position_loop(self, ticks: FloatArray, dt_s: float) -> FloatArray:
        error = self.trajectory - np.rint(ticks)  # the encoder counts whole ticks
        # the D gain's time base is undisclosed; per millisecond gives the order of magnitude
        derivative = (error - self._last_error) * (1e-3 / dt_s)
        self._last_error = error
        self._integral = np.clip(
            self._integral + self.position_i / 65536 * error * (dt_s / 1e-3), -DUTY_FULL, DUTY_FULL
        )
        pwm: FloatArray = (
            self.position_p / 128 * error
            + self._integral
            + self.position_d / 16 * derivative
            + self.feedforward_1 / 4 * self.trajectory_rate * 1e-3
        )
        return pwm

    def _velocity_loop(self, rate_rad_s: FloatArray, dt_s: float) -> FloatArray:
        goal = np.where(self.stopped, 0.0, self.goal_velocity)
        # one count of acceleration is one count of velocity in 64 ms; 0 does not limit it
        unlimited = (self.profile_acceleration <= 0) | self.stopped
        step = np.where(unlimited, np.inf, self.profile_acceleration * (dt_s / 0.064))
        self.ramp_velocity = self.ramp_velocity + np.clip(goal - self.ramp_velocity, -step, step)
        error = self.ramp_velocity - rate_rad_s / VELOCITY_UNIT_RAD_S  # counts
        self._velocity_integral = np.clip(
            self._velocity_integral + self.velocity_i / 65536 * error * (dt_s / 1e-3),
            -DUTY_FULL,
            DUTY_FULL,
        )
        pwm: FloatArray = self.velocity_p / 128 * error + self._velocity_integral
        return pwm

    def _current_loop(self, goal_a: FloatArray, current_a: FloatArray, dt_s: float) -> FloatArray:
        """An integrating current loop; the firmware's own is undisclosed."""
        error = np.where(self.stopped, 0.0, goal_a) - current_a
        self._current_integral = np.clip(
            self._current_integral + 50.0 * error * (dt_s / 1e-3), -885.0, 885.0
        )
        pwm: FloatArray = self._current_integral
        return pwm
