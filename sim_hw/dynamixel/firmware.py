"""The control loop in the servos' firmware, for all servos at once. Compiled.

Source: ROBOTIS e-manual, MX-106(2.0), "Operating Mode", gains and profiles: position mode is a PID with
feedforward on the difference between trajectory and encoder, in PWM counts; K_P = n/128,
K_I = n/65536, K_D = n/16, feedforward n/4. The loop's own rate is not published ("much faster than
1 kHz"); here it runs once a physics step. Units inside: ticks, ticks/s, PWM counts (885 = 100 %).
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from drivers.dynamixel.registers import OperatingMode
from drivers.dynamixel.units import DUTY_FULL, TICK_RAD, VELOCITY_UNIT_RAD_S
from model.compiled import NUMBER, compile_for, compiled, given, in_place, out
from model.values.arrays import BoolArray, FloatArray
from sim_hw.dynamixel.goal_path import GoalPath
from sim_hw.plant.structure import REGISTER_LOOP, LoopKind, ServoLoop

CURRENT, VELOCITY, POSITION, PWM = (
    int(OperatingMode.CURRENT), int(OperatingMode.VELOCITY), int(OperatingMode.POSITION),
    int(OperatingMode.PWM),
)  # fmt: skip
# Registers that the loop works from, as the control table has them, and those that turn with Drive Mode.
COPIED = (
    "operating_mode", "pwm_limit", "position_p_gain", "position_i_gain", "position_d_gain",
    "velocity_p_gain", "velocity_i_gain", "feedforward_1st_gain", "profile_velocity",
    "profile_acceleration",
)  # fmt: skip
TURNED = ("goal_velocity", "goal_current", "goal_pwm")
# What the loop keeps: trajectory [ticks], its rate [ticks/s], goal of the velocity loop on its ramp
# [counts], integrals [PWM counts], the error behind its low pass [ticks].
STATE = (
    "trajectory", "trajectory_rate", "ramp_velocity", "position_integral", "velocity_integral",
    "current_integral", "last_error",
)  # fmt: skip
# Time constant of the low pass on the error before its slope is taken [ms]; assumed, not disclosed.
DERIVATIVE_MS = 8.0
# What the servo is built as (``ServoLoop``), in ticks and PWM counts.
BUILT = (
    "gain", "speed_damping", "angle_gain", "speed_gain", "speed_integral", "profile_speed",
    "profile_ramp",
)  # fmt: skip
# One count of current [A], the last output; ``stopped``: held by a tripped watchdog.
_OTHERS = ("current_unit", "pwm")
_NUMBERS = [
    (name, np.float64) for name in ("goal_position", *COPIED, *TURNED, *STATE, *BUILT, *_OTHERS)
]
_SWITCHES = [("torque", np.bool_), ("stopped", np.bool_), ("cascaded", np.bool_)]
FIELDS = tuple(name for name, _ in (*_NUMBERS, *_SWITCHES))
SERVO = np.dtype((np.record, np.dtype([*_NUMBERS, *_SWITCHES], align=True)))


@in_place
@compiled
def _bounded(value: float, most: float) -> float:
    return min(max(value, -most), most)


@in_place
@compiled
def _advance_trajectory(servo: Any, goal: float, dt_s: float) -> None:
    """Step, rectangular or trapezoidal approach of the trajectory to the goal."""
    speed = servo.profile_velocity * VELOCITY_UNIT_RAD_S * (1.0 / TICK_RAD)  # ticks/s
    # 1 count of acceleration is 1 count of velocity in 64 ms; ticks/s^2
    ramp = servo.profile_acceleration * (VELOCITY_UNIT_RAD_S / 0.064) * (1.0 / TICK_RAD)
    if servo.profile_velocity == 0.0:  # none by the registers: the servo's own, if it has one
        speed, ramp = servo.profile_speed, servo.profile_ramp
    if servo.stopped or speed == 0.0:
        servo.trajectory_rate = 0.0
        if not servo.stopped:
            servo.trajectory = goal
        return
    to_go = goal - servo.trajectory
    if ramp > 0:  # no faster than the ramp can still stop at the goal
        speed = min(speed, math.sqrt(2 * ramp * abs(to_go)))
    change = math.copysign(speed, to_go) - servo.trajectory_rate
    if to_go == 0.0:
        change = -servo.trajectory_rate
    if ramp > 0:
        change = _bounded(change, ramp * dt_s)
    rate = servo.trajectory_rate + change
    servo.trajectory += _bounded(rate * dt_s, abs(to_go))
    servo.trajectory_rate = 0.0 if abs(goal - servo.trajectory) < 1e-9 else rate


@in_place
@compiled
def _position_loop(servo: Any, ticks: float, rate_rad_s: float, steps_ms: float) -> float:
    error = servo.trajectory - np.rint(ticks)  # the encoder counts whole ticks
    # the D gain's time base is undisclosed; per millisecond gives the order of magnitude. Whole ticks and
    # goals that jump have no slope within a millisecond: it is that of the error behind a low pass, assumed
    derivative = (error - servo.last_error) / (DERIVATIVE_MS + steps_ms)
    servo.last_error += derivative * steps_ms
    step = servo.position_i_gain / 65536 * error * steps_ms
    servo.position_integral = _bounded(servo.position_integral + step, DUTY_FULL)
    pwm: float = (
        servo.position_p_gain / 128 * error * servo.gain
        - servo.speed_damping * rate_rad_s
        + servo.position_integral
        + servo.position_d_gain / 16 * derivative
        + servo.feedforward_1st_gain / 4 * servo.trajectory_rate * 1e-3
    )
    return pwm


@in_place
@compiled
def _cascaded_loop(servo: Any, ticks: float, rate_rad_s: float, steps_ms: float) -> float:
    """P on the angle, PI on the speed; the integral stops where the output does."""
    wanted = servo.angle_gain * (servo.trajectory - np.rint(ticks)) * TICK_RAD
    error = wanted - rate_rad_s
    step = servo.speed_integral * error * steps_ms * 1e-3
    servo.velocity_integral = _bounded(servo.velocity_integral + step, DUTY_FULL)
    pwm: float = servo.speed_gain * error + servo.velocity_integral
    return pwm


@in_place
@compiled
def _velocity_loop(servo: Any, rate_rad_s: float, steps_ms: float) -> float:
    change = (0.0 if servo.stopped else servo.goal_velocity) - servo.ramp_velocity
    if servo.profile_acceleration > 0 and not servo.stopped:  # 0 does not limit it
        change = _bounded(change, servo.profile_acceleration * (steps_ms * 1e-3 / 0.064))
    servo.ramp_velocity += change
    error = servo.ramp_velocity - rate_rad_s / VELOCITY_UNIT_RAD_S  # counts
    step = servo.velocity_i_gain / 65536 * error * steps_ms
    servo.velocity_integral = _bounded(servo.velocity_integral + step, DUTY_FULL)
    pwm: float = servo.velocity_p_gain / 128 * error + servo.velocity_integral
    return pwm


@in_place
@compiled
def _current_loop(servo: Any, current_a: float, steps_ms: float) -> float:
    """An integrating current loop; the firmware's own is undisclosed."""
    error = (0.0 if servo.stopped else servo.goal_current * servo.current_unit) - current_a
    integral: float = _bounded(servo.current_integral + 50.0 * error * steps_ms, DUTY_FULL)
    servo.current_integral = integral
    return integral


@in_place
@compiled
def firmware_duties(
    servos: Any, goal: FloatArray, ticks: FloatArray, rate_rad_s: FloatArray, current_a: FloatArray,
    dt_s: float, duty: FloatArray,
) -> None:  # fmt: skip
    """Run the loop of every servo's mode once; ``duty`` is written, (N,)."""
    steps_ms = dt_s / 1e-3
    for k in range(len(ticks)):
        servo = servos[k]
        mode = servo.operating_mode
        _advance_trajectory(servo, goal[k], dt_s)
        most = min(servo.pwm_limit, abs(servo.goal_pwm))
        if mode == VELOCITY:
            pwm = _velocity_loop(servo, rate_rad_s[k], steps_ms)
        elif mode == CURRENT:
            pwm = _current_loop(servo, current_a[k], steps_ms)
        elif mode == PWM:
            pwm, most = servo.goal_pwm, servo.pwm_limit
        elif servo.cascaded:
            pwm = _cascaded_loop(servo, ticks[k], rate_rad_s[k], steps_ms)
        else:
            pwm = _position_loop(servo, ticks[k], rate_rad_s[k], steps_ms)
        servo.pwm = _bounded(pwm, most) if servo.torque else 0.0
        duty[k] = servo.pwm / DUTY_FULL


class FirmwareBank:
    """Registers of the control loop and its state, a record a servo.

    The virtual servos write the registers; the world calls ``duty`` once a physics step.

    Args:
        count: Number of servos.
        loop: What the servos are built as.

    Attributes:
        servos: Records of ``SERVO``, (N,).
        columns: Each of their fields, (N,), by its name; views of them.
        mode: Operating modes, a view of them.
        goal_position: Goals in ticks, a view of them.
        goal_path: What lies between goals and loops, None for nothing.
    """

    def __init__(self, count: int, loop: ServoLoop = REGISTER_LOOP) -> None:
        self.servos: Any = np.zeros(count, dtype=SERVO)
        servos = self.servos
        servos["cascaded"] = loop.kind is LoopKind.CASCADED
        servos["gain"], servos["speed_damping"] = loop.gain, loop.speed_damping * DUTY_FULL
        servos["angle_gain"] = loop.angle_gain
        servos["speed_gain"] = loop.speed_gain * DUTY_FULL
        servos["speed_integral"] = loop.speed_integral * DUTY_FULL
        servos["profile_speed"] = loop.profile_speed / TICK_RAD
        servos["profile_ramp"] = loop.profile_acceleration / TICK_RAD
        self.columns: Mapping[str, FloatArray] = {name: servos[name] for name in FIELDS}
        self.mode: FloatArray = self.columns["operating_mode"]
        self.goal_position: FloatArray = self.columns["goal_position"]
        self._torque: BoolArray = self.servos["torque"]
        self._stopped: BoolArray = self.servos["stopped"]
        self.mode[:] = OperatingMode.POSITION
        self.servos["position_p_gain"] = 850.0
        self.servos["pwm_limit"] = self.servos["goal_pwm"] = DUTY_FULL
        self.goal_path: GoalPath | None = None
        # machine code is made here: a servo that is asked must not wait for it
        compile_for(firmware_duties, self.servos, *given(1, 1, 1, 1), NUMBER, *out(1))

    @property
    def driven(self) -> BoolArray:
        """True where the output stage is on."""
        driven: BoolArray = self._torque.copy()
        return driven

    @property
    def all_follow(self) -> bool:
        """Whether all servos have torque and none was stopped by its watchdog."""
        return False not in self._torque.tolist() and True not in self._stopped.tolist()

    def torque(self, index: int) -> bool:
        """Whether the output stage of one servo is on."""
        on: bool = self._torque.item(index)
        return on

    def restart(self, index: int, ticks: float) -> None:
        """Begin again at a position: torque switched on, mode changed, power came back."""
        for name in STATE:
            self.columns[name][index] = 0.0
        self.columns["trajectory"][index] = ticks
        if self.goal_path is not None:
            self.goal_path.restart(index, ticks)

    def duty(
        self, ticks: FloatArray, rate_rad_s: FloatArray, current_a: FloatArray, dt_s: float
    ) -> FloatArray:
        """Return the PWM duty of each servo, -1 to 1; 0 where torque is off."""
        path = self.goal_path
        goal = self.goal_position.copy() if path is None else path.advance(self.goal_position)
        output = np.empty(len(ticks))
        firmware_duties(self.servos, goal, ticks, rate_rad_s, current_a, dt_s, output)
        return output
