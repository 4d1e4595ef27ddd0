"""What the controller does with each effect of a robot file: model, readings, or nothing at all.

``gap`` adds every effect to its chain, ``sim`` every effect to the virtual robot. A controller is fed
measured shafts, so what lies between command and shaft has happened already when it looks; and what
cameras make of the truth it never sees. A log keeps what the sensors said: whoever compares that with the
model takes the file's gain, bias, drift and rotation out first, as the controller and the odometry do.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from enum import Enum
from functools import partial
from types import MappingProxyType

from model.effects.causes import Cause
from model.effects.machine_scale import size_of
from model.effects.sensing import OF_FORCES, true_forces
from model.effects.settings import settings_of
from model.errors import BigantError
from model.values.arrays import FloatArray
from model.values.legs import FootForces
from model.values.tick import Tick
from robot.config.robot_file import RobotConfig, parse_robot

# forces, (..., N, 3) [N], at times since the run began, (...,) [s], to forces without the sensors' errors
TrueForces = Callable[[FloatArray, FloatArray | float], FloatArray]


class Use(Enum):
    """What the controller and the odometry do with an effect."""

    MODEL = "added to the model"
    READING = "subtracted from the reading"
    SEEN = "seen by the encoders: nothing to add"
    BEYOND = "not undone: how far a loaded crank is from its encoder is not estimated"
    LATE = "not undone: a reading cannot be had before it comes"
    CAMERAS = "of motion capture, which the controller does not use"


_GROUPS = {
    Use.MODEL: """shaft_zero_offset link_length leg_flex ground_stiffness leg_length ground_slope
        ground_step com_offset payload chassis_twist coulomb_friction stiction stick_slip friction_patch
        foot_rolling tilt_coupling inertia_lag tether_force drag leg_stiffness foot_friction friction_level
        friction_anisotropy hip_mount_offset""",
    Use.READING: "force_gain force_bias force_drift force_rotation force_cross_talk encoder_scale",
    Use.SEEN: "command_delay servo_lag servo_speed_limit servo_compliance gear_backlash joint_friction"
    " gear_backlash_in_loop gear_backlash_dragged",
    Use.BEYOND: "servo_compliance_beyond_encoder gear_backlash_beyond_encoder",
    Use.LATE: "force_delay force_lowpass",
    Use.CAMERAS: "pose_delay pose_yaw_offset pose_origin_offset marker_on_shank clock_skew",
}
USES = MappingProxyType({name: use for use, names in _GROUPS.items() for name in names.split()})


def unused_notes(causes: Sequence[Cause]) -> tuple[str, ...]:
    """Say of each effect that the controller's model does not use why, in one line."""
    return tuple(
        f"note: effect {one.effect} of the robot file is not in the model here: {USES[one.effect].value}"
        for one in causes
        if USES[one.effect] in {Use.SEEN, Use.BEYOND, Use.LATE, Use.CAMERAS}
    )


def true_forces_of(config: RobotConfig) -> TrueForces | None:
    """Return what takes a robot file's sensor errors out; None for a file that has none."""
    if not any(cause.effect in OF_FORCES for cause in config.effects):
        return None
    robot = config.parameters
    size = size_of(robot.body.mass, robot.legs, robot.leg)
    return partial(true_forces, settings=settings_of(config.effects, config.parameters.names, size))


def true_forces_of_log(config_text: str) -> TrueForces | None:
    """Return what takes the sensor errors of a log's robot file out; None if it has none."""
    try:
        return true_forces_of(parse_robot(config_text))
    except BigantError:
        return None  # a log of another robot's software: what it measured is shown as it is


def with_true_forces(tick: Tick, without_errors: TrueForces | None, start_ns: int) -> Tick:
    """Return a tick whose forces are without the sensors' errors."""
    if without_errors is None:
        return tick
    force_n = without_errors(tick.forces.force_n, (tick.t_ns - start_ns) * 1e-9)
    return replace(tick, forces=FootForces(tick.forces.t_ns, force_n, tick.forces.valid))
