"""The control loop in the servos' firmware, for all servos at once.

Source: ROBOTIS e-manual, MX-106(2.0), "Operating Mode", gains and profiles: position mode is a PID with
feedforward on the difference between trajectory and encoder, in PWM counts; K_P = n/128,
K_I = n/65536, K_D = n/16, feedforward n/4. The loop's own rate is not published ("much faster than
1 kHz"); here it runs once a physics step. Units inside: ticks, ticks/s, PWM counts (885 = 100 %).
"""

import numpy as np

from drivers.dynamixel.mx106 import (
    CURRENT_UNIT_A,
    DUTY_FULL,
    TICK_RAD,
    VELOCITY_UNIT_RAD_S,
    OperatingMode,
)
from model.compiled import compiled
from model.values.arrays import BoolArray, FloatArray, IntArray
from sim_hw.dynamixel.goal_path import GoalPath

# Acceleration unit: 1 count of velocity in 64 ms.
ACCELERATION_UNIT_RAD_S2 = VELOCITY_UNIT_RAD_S / 0.064
FIRST_POSITION_MODE = int(OperatingMode.POSITION)
LAST_POSITION_MODE = int(OperatingMode.CURRENT_BASED_POSITION)
POSITION_MODES = (
    OperatingMode.POSITION,
    OperatingMode.EXTENDED_POSITION,
    OperatingMode.CURRENT_BASED_POSITION,
)


@compiled
def _plain_duty(
    ticks: FloatArray,
    steps_ms: float,
    goal: FloatArray,
    mode: IntArray,
    flags: BoolArray,
    loop: FloatArray,
    gains: FloatArray,
    duty: FloatArray,
) -> bool:
    """Position loops of all servos, goals followed at once; False, and nothing done, if any is otherwise.

    Args:
        ticks: Encoders, (N,).
        steps_ms: Step [ms].
        goal: Goals, (N,) [ticks].
        mode: Operating modes, (N,).
        flags: Torque on, held by a tripped watchdog, (2, N).
        loop: Trajectory, its rate, integral, last error, PWM, (5, N); changed.
        gains: P, I, D, first feedforward, PWM limit, goal PWM, profile velocity, (7, N).
        duty: Written, (N,).
    """
    for k in range(len(ticks)):
        if mode[k] < 3 or mode[k] > 5 or gains[6, k] != 0.0:
            return False
    for k in range(len(ticks)):
        if not flags[1, k]:
            loop[0, k] = goal[k]
        loop[1, k] = 0.0
        error = loop[0, k] - np.rint(ticks[k])  # the encoder counts whole ticks
        # the D gain's time base is undisclosed; per millisecond gives the order of magnitude
        derivative = (error - loop[3, k]) / steps_ms
        loop[3, k] = error
        loop[2, k] = min(max(loop[2, k] + gains[1, k] / 65536 * error * steps_ms, -885.0), 885.0)
        pwm = gains[0, k] / 128 * error + loop[2, k] + gains[2, k] / 16 * derivative
        most = min(gains[4, k], abs(gains[5, k]))
        loop[4, k] = min(max(pwm, -most), most) if flags[0, k] else 0.0
        duty[k] = loop[4, k] / 885.0
    return True


class FirmwareBank:
    """Registers of the control loop and its state, one entry a servo.

    The virtual servos write the registers; the world calls ``duty`` once a physics step.

    Args:
        count: Number of servos.
    """

    def __init__(self, count: int) -> None:
        self.count = count
        self.mode = np.full(count, int(OperatingMode.POSITION))
        self._flags = np.zeros((2, count), dtype=bool)
        self._loop = np.zeros((5, count))
        self._gains = np.zeros((7, count))
        # views: the virtual servos write single registers, the compiled loop takes them in rows
        self.torque: BoolArray = self._flags[0]
        self.stopped: BoolArray = self._flags[1]  # held by a tripped watchdog
        self.trajectory, self.trajectory_rate = self._loop[0], self._loop[1]  # ticks, ticks/s
        self._integral, self._last_error = self._loop[2], self._loop[3]  # PWM counts, ticks
        self.pwm: FloatArray = self._loop[4]  # last output, counts
        self.position_p, self.position_i, self.position_d = self._gains[0:3]
        self.feedforward_1 = self._gains[3]
        self.pwm_limit, self.goal_pwm = self._gains[4], self._gains[5]  # counts
        self.profile_velocity = self._gains[6]  # counts, 0 = step
        self.position_p[:] = 850.0
        self.pwm_limit[:] = self.goal_pwm[:] = DUTY_FULL
        self.goal_position = np.zeros(count)  # ticks
        self.goal_velocity = np.zeros(count)  # counts
        self.goal_current = np.zeros(count)  # counts
        self.velocity_p = np.full(count, 100.0)
        self.velocity_i = np.full(count, 1920.0)
        self.feedforward_2 = np.zeros(count)
        self.profile_acceleration = np.zeros(count)  # counts, 0 = rectangular
        self.ramp_velocity = np.zeros(count)  # counts; goal of the velocity loop on its ramp
        self._velocity_integral = np.zeros(count)
        self._current_integral = np.zeros(count)
        self.goal_path: GoalPath | None = None
        # machine code is loaded here, in mode 0 nothing is done: a servo that is asked must not wait for it
        empty = np.zeros(count)
        mode = np.zeros_like(self.mode)
        _plain_duty(empty, 1.0, empty, mode, self._flags, self._loop, self._gains, empty)

    @property
    def driven(self) -> BoolArray:
        """True where the output stage is on."""
        driven: BoolArray = self.torque
        return driven

    def restart(self, index: int, ticks: float) -> None:
        """Begin anew at a position: torque switched on, mode changed, power came back."""
        self.trajectory[index] = ticks
        self.trajectory_rate[index] = 0.0
        self.ramp_velocity[index] = 0.0
        for integral in (self._integral, self._velocity_integral, self._current_integral):
            integral[index] = 0.0
        self._last_error[index] = 0.0
        if self.goal_path is not None:
            self.goal_path.restart(index, ticks)

    def profile_ongoing(self) -> BoolArray:
        """True where the trajectory has not reached its goal."""
        ongoing: BoolArray = np.abs(self.goal_position - self.trajectory) > 0.5
        return ongoing

    def planned_velocity(self, index: int) -> float:
        """Return the velocity that the profile asks for now [counts]."""
        if self.mode[index] == OperatingMode.VELOCITY:
            return float(self.ramp_velocity[index])
        return float(self.trajectory_rate[index]) * TICK_RAD / VELOCITY_UNIT_RAD_S

    def duty(
        self, ticks: FloatArray, rate_rad_s: FloatArray, current_a: FloatArray, dt_s: float
    ) -> FloatArray:
        """Return the PWM duty of each servo, -1 to 1; 0 where torque is off."""
        goal = self.goal_position
        if self.goal_path is not None:
            goal = self.goal_path.advance(goal)
        output = np.empty(self.count)
        if _plain_duty(
            ticks, dt_s / 1e-3, goal, self.mode, self._flags, self._loop, self._gains, output
        ):
            return output
        self._advance_trajectory(goal, dt_s)
        pwm = self._position_loop(ticks, dt_s)
        ceiling = np.minimum(self.pwm_limit, np.abs(self.goal_pwm))
        pwm, ceiling = self._other_loops(pwm, ceiling, rate_rad_s, current_a, dt_s)
        self.pwm[:] = np.where(self.torque, np.clip(pwm, -ceiling, ceiling), 0.0)
        output[:] = self.pwm / DUTY_FULL
        return output

    def _other_loops(
        self,
        pwm: FloatArray,
        ceiling: FloatArray,
        rate_rad_s: FloatArray,
        current_a: FloatArray,
        dt_s: float,
    ) -> tuple[FloatArray, FloatArray]:
        """Return PWM and its bound where some servos are in velocity, current or PWM mode."""
        position = (self.mode >= FIRST_POSITION_MODE) & (self.mode <= LAST_POSITION_MODE)
        pwm = np.where(position, pwm, 0.0)
        pwm = np.where(
            self.mode == OperatingMode.VELOCITY, self._velocity_loop(rate_rad_s, dt_s), pwm
        )
        pwm = np.where(self.mode == OperatingMode.PWM, self.goal_pwm, pwm)
        current_goal = self.goal_current * CURRENT_UNIT_A
        wanted = self._current_loop(current_goal, current_a, dt_s)
        pwm = np.where(self.mode == OperatingMode.CURRENT, wanted, pwm)
        return pwm, np.where(self.mode == OperatingMode.PWM, self.pwm_limit, ceiling)

    def _advance_trajectory(self, goal: FloatArray, dt_s: float) -> None:
        """Rectangular or trapezoidal approach of the trajectory to the goal."""
        moving = ~self.stopped
        to_go = goal - self.trajectory
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
        self.trajectory[:] = np.where(
            moving, np.where(free, goal, self.trajectory + way), self.trajectory
        )
        arrived = np.abs(goal - self.trajectory) < 1e-9
        self.trajectory_rate[:] = np.where(free | arrived | ~moving, 0.0, rate)

    def _position_loop(self, ticks: FloatArray, dt_s: float) -> FloatArray:
        """The same as in ``_plain_duty``, and feedforward, which only a profile gives anything to."""
        error = self.trajectory - np.rint(ticks)
        derivative = (error - self._last_error) * (1e-3 / dt_s)
        self._last_error[:] = error
        self._integral[:] = np.clip(
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
