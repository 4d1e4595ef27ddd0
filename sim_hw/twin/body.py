"""Effects of actuation, kinematics and support: what is wrong with servos, legs, chassis, ground."""

from model.errors import ConfigError
from model.values.arrays import FloatArray, IntArray
from sim_hw.plant.parameters import CrankLegs
from sim_hw.twin.effects import (
    ALL,
    BOTH,
    LEG,
    EffectKind,
    adds,
    adds_vector,
    at,
    changed,
    scales,
    sets,
    sized,
)
from sim_hw.twin.twin import Twin


def _hip_mount_offset(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    place = twin.plant.shaft_position.copy()
    place[legs, :2] += values
    return changed(twin, "plant.shaft_position", place)


def _link_length(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    if isinstance(twin.plant.leg, CrankLegs):
        raise ConfigError("effect link_length", "this robot's legs are cranks and have no links")
    longer = adds("plant.leg.crank", "plant.leg.coupler", "plant.leg.rocker")
    return longer(twin, legs, values)


def _leg_flex(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    lateral, longitudinal = values
    give = 1 / twin.plant.side_stiffness[legs] + [longitudinal, lateral]
    return changed(twin, "plant.side_stiffness", at(twin.plant.side_stiffness, legs, 1 / give))


def _ground_stiffness(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    ratio = float(values[0])
    if ratio >= 1.0:
        return twin
    own = twin.plant.stiffness * ratio / (1 - ratio)
    soft = twin.plant.ground.stiffness  # infinite where the ground is rigid
    in_series = own / (1.0 + own / soft)
    return changed(twin, "plant.ground.stiffness", in_series)


def _payload(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    loaded = changed(twin, "plant.payload", float(values[0]))
    return changed(loaded, "plant.payload_position", values[1:].copy())


KINDS = (
    EffectKind(
        "command_delay", "actuation", ALL, (sized("delay_s", "s", 0, 0.5, 0, 0.05, 0.12),),
        "a queue between the goals that arrive and the servos' control loops",
        adds("plant.drive.delay_s"),
    ),
    EffectKind(
        "servo_lag", "actuation", BOTH, (sized("time_constant_s", "s", 0, 0.5, 0, 0.05, 0.12),),
        "the control loop's set point is a low-pass of the goal", sets("plant.drive.lag_s"),
    ),
    EffectKind(
        "servo_speed_limit", "actuation", BOTH, (sized("limit_rad_s", "rad/s", 0.05, 10, 10, 1.45, 1.38),),
        "the control loop's set point moves no faster", sets("plant.drive.speed_limit"),
    ),
    EffectKind(
        "servo_compliance", "actuation", BOTH, (sized("rad_per_nm", "rad/N m", 0, 0.5, 0, 0.02, 0.06),),
        "an elastic gear between motor, which the control loop holds, and encoder",
        adds("plant.drive.compliance"),
    ),
    EffectKind(
        "gear_backlash", "actuation", LEG, (sized("width_rad", "rad", 0, 0.5, 0, 0.05, 0.12),),
        "play in the gear between motor, which the control loop holds, and encoder",
        adds("plant.drive.backlash"),
    ),
    EffectKind(
        "joint_friction", "actuation", BOTH, (sized("behind_rad", "rad", 0, 0.3, 0, 0.03, 0.08),),
        "dry friction on the shaft, as much as the control loop overcomes at this error",
        adds("plant.drive.friction_rad"),
    ),
    EffectKind(
        "shaft_zero_offset", "actuation", LEG, (sized("offset_rad", "rad", -0.6, 0.6, 0, 0.06, 0.15),),
        "the crank sits turned on the shaft behind the encoder", adds("plant.drive.crank_offset"),
    ),
    EffectKind(
        "link_length", "kinematics", BOTH,
        (
            sized("crank_m", "m", -0.008, 0.008, 0, 0.0015, 0.004),
            sized("coupler_m", "m", -0.01, 0.01, 0, 0.0, 0.0),
            sized("rocker_m", "m", -0.008, 0.008, 0, 0.0, 0.0),
        ),
        "dimensions of the plant's four-bar", _link_length,
    ),
    EffectKind(
        "hip_mount_offset", "kinematics", LEG,
        (sized("x_m", "m", -0.05, 0.05, 0, 0.008, 0.02),
         sized("y_m", "m", -0.05, 0.05, 0, 0.008, 0.02)),
        "the leg, with its transducer, is bolted on elsewhere", _hip_mount_offset,
    ),
    EffectKind(
        "leg_flex", "kinematics", ALL,
        (
            sized("lateral_m_per_n", "m/N", 0, 0.002, 0, 2e-4, 6e-4),
            sized("longitudinal_m_per_n", "m/N", 0, 0.002, 0, 2e-4, 6e-4),
        ),
        "softer springs between leg and foot along body x and y", _leg_flex,
    ),
    EffectKind(
        "leg_stiffness", "support", LEG, (sized("ratio", "", 0.2, 4, 1, 0.75, 0.5),),
        "the leg's vertical spring", scales("plant.stiffness"),
    ),
    EffectKind(
        "ground_stiffness", "support", ALL, (sized("ratio", "", 0.2, 1, 1, 0.75, 0.5),),
        "a spring between each foot and the ground, so that feet sink in", _ground_stiffness,
    ),
    EffectKind(
        "leg_length", "support", LEG, (sized("offset_m", "m", -0.02, 0.02, 0, 0.002, 0.004),),
        "the end of the leg is lower than the linkage puts it", adds("plant.leg_offset"),
    ),
    EffectKind(
        "ground_slope", "support", ALL,
        (sized("slope_x", "", -0.2, 0.2, 0, 0.02, 0.05),
         sized("slope_y", "", -0.2, 0.2, 0, 0.0, 0.02)),
        "the ground is tilted and the robot begins along it", adds_vector("plant.ground.slope"),
    ),
    EffectKind(
        "ground_step", "support", ALL,
        (sized("height_m", "m", 0, 0.02, 0, 0.003, 0.006),
         sized("x_m", "m", -0.5, 10, 0.3, 0.32, 0.32)),
        "a box on the ground, beyond x in the world",
        sets("plant.ground.step_height", "plant.ground.step_x"),
    ),
    EffectKind(
        "com_offset", "support", ALL,
        (sized("x_m", "m", -0.1, 0.1, 0, 0.01, 0.03), sized("y_m", "m", -0.1, 0.1, 0, 0.0, 0.01)),
        "the torso's centre of mass", adds_vector("plant.com"),
    ),
    EffectKind(
        "payload", "support", ALL,
        (
            sized("mass_kg", "kg", 0, 5, 0, 0.4, 1.0),
            sized("x_m", "m", -0.3, 0.3, 0, 0.15, 0.15),
            sized("y_m", "m", -0.3, 0.3, 0, 0.0, 0.05),
        ),
        "a further body fixed to the torso at shaft height", _payload,
    ),
    EffectKind(
        "chassis_twist", "support", ALL, (sized("rad_per_nm", "rad/N m", 0, 0.05, 0, 0.002, 0.006),),
        "hinges about x with springs between the rows of legs", adds("plant.twist"),
    ),
    EffectKind(
        "missed_steps", "actuation", BOTH,
        (sized("per_s", "1/s", 0, 5, 0, 0.3, 1.0), sized("hold_s", "s", 0.01, 2, 0.15, 0.15, 0.22)),
        "a servo misses its goals for a while, at random times",
        sets("plant.drive.hold_rate", "plant.drive.hold_s"), catalogued=False,
    ),
    EffectKind(
        "loose_leg_stop", "support", LEG, (sized("play_m", "m", 0, 0.01, 0, 0.002, 0.004),),
        "free play in the leg's vertical spring", adds("plant.leg_play"), catalogued=False,
    ),
)  # fmt: skip
