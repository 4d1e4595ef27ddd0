"""In which recorded ticks of a walk nothing happens: what the step's watches and its gate would let pass.

Each answer errs on one side: a tick that is not certain is left to the step, which decides.
"""

from typing import NamedTuple

import numpy as np

from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import TICK_RAD
from gaits.plan import Walking
from model.quasistatic.frame import FrameRows
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.faults import StopReason
from model.values.input_rows import InputRows, ServoRows
from model.values.tick import Intent, Mode, Request
from model.values.tick_rows import ForceRows, JointRows
from robot.config.robot_file import RobotConfig
from robot.config.safety import BodyLimits
from robot.config.servo import SafetyLimits
from robot.control.modes import GaitBook
from robot.control.safety import (
    ALERT_BIT,
    ENDING_TICK,
    LAST_TICK,
    LONG_GAP_S,
    SPEED_SLACK,
    STALE_SLACK_NS,
)
from robot.control.state import ControllerState

# Leaning and load are computed in another order here: nearer to a limit than this share, the step decides.
MARGIN = 1e-9


class Commands(NamedTuple):
    """Commands of T ticks, and what each of them follows.

    Attributes:
        t_ns: Times, (T,).
        angle_rad: Goals, (T, N).
        rate_rad_s: Their speeds, (T, N).
        before_ns: When the servos had the command before, (T,).
        before_rad: Its goals, (T, N).
    """

    t_ns: IntArray
    angle_rad: FloatArray
    rate_rad_s: FloatArray
    before_ns: IntArray
    before_rad: FloatArray


def walks_on(state: ControllerState, book: GaitBook) -> bool:
    """Whether the robot walks, and nothing is left over from the tick before."""
    phase, memory, plan = state.decision.phase, state.decision.recovery.memory, None
    if isinstance(phase.plan, Walking):
        plan = phase.plan
    return (
        state.index > 0
        and phase.mode is Mode.WALK
        and phase.stop_reason is StopReason.NONE
        and plan is not None
        and not book.refuses(
            Request(
                Intent.WALK, plan.gait.name, plan.frequency.end, plan.steer.end, StopReason.NONE
            )
        )
        and state.allowed.command.torque
        and not state.allowed.recover
        and not state.command.refused
        and not memory.paused
        and not (memory.down.any() or memory.back.any())
    )


def goes_on(inputs: InputRows, plan: Walking, late_limit_s: float, period_ns: int) -> BoolArray:
    """In which ticks servos answer, nothing new is wished, and the loop is on time, (T,)."""
    request, timing, servos = inputs.request, inputs.timing, inputs.servos
    same_gait = np.array([gait == plan.gait.name for gait in request.gait])
    usual: BoolArray = (
        inputs.known
        & servos.valid.all(axis=1)
        & (request.intent == Intent.WALK.value)
        & (request.frequency_hz == plan.frequency.end)
        & (request.steer == plan.steer.end)
        & same_gait
        & (timing.missed * period_ns * 1e-9 < LONG_GAP_S)
        & (timing.lateness_ns * 1e-9 <= late_limit_s)
    )
    return usual


def servos_well(
    servos: ServoRows, joints: JointRows, sent_rad: FloatArray, limits: SafetyLimits
) -> BoolArray:
    """In which ticks the watch over servos finds nothing, nor do their turns end, (T,)."""
    lag = np.abs(joints.angle_rad - sent_rad)
    of_each: BoolArray = (
        (servos.error_byte < ALERT_BIT)
        & (servos.hardware_error <= 0)
        & (joints.temperature_c <= limits.max_temperature_c)
        & ~(
            np.abs(joints.current_a) > limits.max_current_a
        )  # one that is not measured is not judged
        & (joints.voltage_v >= limits.min_voltage_v)
        & (lag <= limits.max_following_error_rad)
        & (np.abs(servos.position_ticks) <= ENDING_TICK)
    )
    return all_legs(of_each)


def body_well(
    contact: FrameRows, forces: ForceRows | None, position_m: FloatArray, weight_n: float,
    limits: BodyLimits,
) -> BoolArray:  # fmt: skip
    """In which ticks the model has an answer, and the body neither leans nor hangs nor is away, (T,).

    Args:
        contact: The model's answers.
        forces: Measured ones, where every leg has a sensor.
        position_m: Where dead reckoning was in the tick before, (T, 2).
        weight_n: The robot's weight [N].
        limits: Limits.
    """
    most, far_m = limits.max_tilt * (1 - MARGIN), limits.max_distance * (1 - MARGIN)
    lean = np.arctan(np.hypot(contact.pose[:, 0], contact.pose[:, 1]))
    well: BoolArray = contact.answered & (lean <= most) & (np.hypot(*position_m.T) <= far_m)
    if forces is not None:
        known, (x, y, z) = forces.valid.all(axis=1), forces.force_n.sum(axis=1).T
        load_n, across_n = np.sqrt(x * x + y * y + z * z), np.hypot(x, y)
        upright = (np.arctan2(across_n, z) <= most) | (load_n <= 0.5 * weight_n * (1 - MARGIN))
        carried = load_n >= limits.min_load * weight_n * (1 + MARGIN)
        well &= ~known | (upright & carried)
    return well


def passes(commands: Commands, limits: SafetyLimits, bus: ServoBusSettings) -> BoolArray:
    """Which commands the safety gate lets through, and the loop finds recent enough, (T,)."""
    elapsed_ns = commands.t_ns - commands.before_ns
    known = np.isfinite(commands.angle_rad) & np.isfinite(commands.rate_rad_s)
    ticks = np.abs(bus.zeros + bus.signs * commands.angle_rad / TICK_RAD)
    allowed_rad = limits.max_speed_rad_s * SPEED_SLACK * elapsed_ns * 1e-9 + TICK_RAD
    step_rad = np.abs(commands.angle_rad - commands.before_rad)
    allowed: BoolArray = (
        (known & (ticks <= LAST_TICK) & (step_rad <= allowed_rad[:, None])).all(axis=1)
        & (elapsed_ns > 0)
        & (elapsed_ns <= bus.watchdog_s * 1e9 + STALE_SLACK_NS)
        & (elapsed_ns * 1e-9 < bus.watchdog_s)
    )
    return allowed


def all_legs(rows: BoolArray) -> BoolArray:
    """In which ticks something holds of all legs, (T,)."""
    every: BoolArray = np.logical_and.reduce(rows, axis=1)
    return every


def sensed_by_all(config: RobotConfig) -> bool:
    """Whether every leg has a force sensor."""
    return bool((config.force_sensor.transducers > 0).all())


def leading(usual: BoolArray) -> int:
    """How many ticks there are before the first unusual one."""
    return len(usual) if usual.all() else int(np.argmin(usual))
