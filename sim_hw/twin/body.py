"""Effects of actuation, kinematics and support: what is wrong with servos, legs, chassis, ground."""

from collections.abc import Callable
from dataclasses import replace

from model.values.arrays import FloatArray, IntArray
from sim_hw.plant.parameters import DriveParameters, GroundParameters
from sim_hw.twin.effects import ALL, BOTH, LEG, EffectKind, EffectParameter
from sim_hw.twin.twin import Twin


def at(array: FloatArray, legs: IntArray, value: FloatArray | float) -> FloatArray:
    """Return a copy of a leg-wise array with another value at some legs."""
    changed = array.copy()
    changed[legs] = value
    return changed


def _drive(twin: Twin, **changes: object) -> Twin:
    drive: DriveParameters = replace(twin.plant.drive, **changes)  # type: ignore[arg-type]
    return replace(twin, plant=replace(twin.plant, drive=drive))


def _plant(twin: Twin, **changes: object) -> Twin:
    return replace(twin, plant=replace(twin.plant, **changes))  # type: ignore[arg-type]


def _ground(twin: Twin, **changes: object) -> Twin:
    ground: GroundParameters = replace(twin.plant.ground, **changes)  # type: ignore[arg-type]
    return _plant(twin, ground=ground)


def _drive_at(name: str) -> Callable[[Twin, IntArray, FloatArray], Twin]:
    """Set one leg-wise number of the drive."""

    def apply(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
        return _drive(twin, **{name: at(getattr(twin.plant.drive, name), legs, values[0])})

    return apply


def _command_delay(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _drive(twin, delay_s=float(values[0]))


def _link_length(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    plant = twin.plant
    return _plant(
        twin,
        crank=at(plant.crank, legs, plant.crank[legs] + values[0]),
        coupler=at(plant.coupler, legs, plant.coupler[legs] + values[1]),
        rocker=at(plant.rocker, legs, plant.rocker[legs] + values[2]),
    )


def _hip_mount_offset(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    place = twin.plant.shaft_position.copy()
    place[legs, :2] += values
    return _plant(twin, shaft_position=place)


def _leg_flex(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    lateral, longitudinal = values
    give = 1 / twin.plant.side_stiffness[legs] + [longitudinal, lateral]
    return _plant(twin, side_stiffness=at(twin.plant.side_stiffness, legs, 1 / give))


def _leg_stiffness(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    stiffness = twin.plant.stiffness
    return _plant(twin, stiffness=at(stiffness, legs, stiffness[legs] * values[0]))


def _ground_stiffness(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    ratio = float(values[0])
    if ratio >= 1.0:
        return twin
    return _ground(twin, stiffness=twin.plant.stiffness * ratio / (1 - ratio))


def _leg_length(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    offset = twin.plant.leg_offset
    return _plant(twin, leg_offset=at(offset, legs, offset[legs] + values[0]))


def _ground_slope(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _ground(twin, slope=twin.plant.ground.slope + values)


def _ground_step(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _ground(twin, step_height=float(values[0]), step_x=float(values[1]))


def _com_offset(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _plant(twin, com=twin.plant.com + values)


def _payload(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _plant(twin, payload=float(values[0]), payload_position=values[1:].copy())


def _chassis_twist(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _plant(twin, twist=float(values[0]))


def _missed_steps(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    rate = at(twin.plant.drive.hold_rate, legs, values[0])
    return _drive(twin, hold_rate=rate, hold_s=float(values[1]))


def _loose_leg_stop(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _plant(twin, leg_play=at(twin.plant.leg_play, legs, values[0]))


def _p(name: str, unit: str, low: float, high: float, *sizes: float) -> EffectParameter:
    neutral, mild, strong = sizes
    return EffectParameter(name, unit, low, high, neutral, mild, strong)


KINDS = (
    EffectKind(
        "command_delay", "actuation", ALL, (_p("delay_s", "s", 0, 0.5, 0, 0.05, 0.12),),
        "a queue between the goals that arrive and the servos' control loops", _command_delay,
    ),
    EffectKind(
        "servo_lag", "actuation", BOTH, (_p("time_constant_s", "s", 0, 0.5, 0, 0.05, 0.12),),
        "the control loop's set point is a low-pass of the goal", _drive_at("lag_s"),
    ),
    EffectKind(
        "servo_speed_limit", "actuation", BOTH, (_p("limit_rad_s", "rad/s", 0.05, 10, 10, 1.45, 1.38),),
        "the control loop's set point moves no faster", _drive_at("speed_limit"),
    ),
    EffectKind(
        "servo_compliance", "actuation", BOTH, (_p("rad_per_nm", "rad/N m", 0, 0.5, 0, 0.02, 0.06),),
        "an elastic gear between motor, which the control loop holds, and encoder",
        _drive_at("compliance"),
    ),
    EffectKind(
        "gear_backlash", "actuation", LEG, (_p("width_rad", "rad", 0, 0.5, 0, 0.05, 0.12),),
        "play in the gear between motor, which the control loop holds, and encoder",
        _drive_at("backlash"),
    ),
    EffectKind(
        "shaft_zero_offset", "actuation", LEG, (_p("offset_rad", "rad", -0.6, 0.6, 0, 0.06, 0.15),),
        "the crank sits turned on the shaft behind the encoder", _drive_at("crank_offset"),
    ),
    EffectKind(
        "link_length", "kinematics", BOTH,
        (
            _p("crank_m", "m", -0.008, 0.008, 0, 0.0015, 0.004),
            _p("coupler_m", "m", -0.01, 0.01, 0, 0.0, 0.0),
            _p("rocker_m", "m", -0.008, 0.008, 0, 0.0, 0.0),
        ),
        "dimensions of the plant's four-bar", _link_length,
    ),
    EffectKind(
        "hip_mount_offset", "kinematics", LEG,
        (_p("x_m", "m", -0.05, 0.05, 0, 0.008, 0.02), _p("y_m", "m", -0.05, 0.05, 0, 0.008, 0.02)),
        "the leg, with its transducer, is bolted on elsewhere", _hip_mount_offset,
    ),
    EffectKind(
        "leg_flex", "kinematics", ALL,
        (
            _p("lateral_m_per_n", "m/N", 0, 0.002, 0, 2e-4, 6e-4),
            _p("longitudinal_m_per_n", "m/N", 0, 0.002, 0, 2e-4, 6e-4),
        ),
        "softer springs between leg and foot along body x and y", _leg_flex,
    ),
    EffectKind(
        "leg_stiffness", "support", LEG, (_p("ratio", "", 0.2, 4, 1, 0.75, 0.5),),
        "the leg's vertical spring", _leg_stiffness,
    ),
    EffectKind(
        "ground_stiffness", "support", ALL, (_p("ratio", "", 0.2, 1, 1, 0.75, 0.5),),
        "a spring between each foot and the ground, so that feet sink in", _ground_stiffness,
    ),
    EffectKind(
        "leg_length", "support", LEG, (_p("offset_m", "m", -0.02, 0.02, 0, 0.002, 0.004),),
        "the end of the leg is lower than the linkage puts it", _leg_length,
    ),
    EffectKind(
        "ground_slope", "support", ALL,
        (_p("slope_x", "", -0.2, 0.2, 0, 0.02, 0.05), _p("slope_y", "", -0.2, 0.2, 0, 0.0, 0.02)),
        "the ground is tilted and the robot begins along it", _ground_slope,
    ),
    EffectKind(
        "ground_step", "support", ALL,
        (_p("height_m", "m", 0, 0.02, 0, 0.003, 0.006), _p("x_m", "m", -0.5, 10, 0.3, 0.32, 0.32)),
        "a box on the ground, beyond x in the world", _ground_step,
    ),
    EffectKind(
        "com_offset", "support", ALL,
        (_p("x_m", "m", -0.1, 0.1, 0, 0.01, 0.03), _p("y_m", "m", -0.1, 0.1, 0, 0.0, 0.01)),
        "the torso's centre of mass", _com_offset,
    ),
    EffectKind(
        "payload", "support", ALL,
        (
            _p("mass_kg", "kg", 0, 5, 0, 0.4, 1.0),
            _p("x_m", "m", -0.3, 0.3, 0, 0.15, 0.15),
            _p("y_m", "m", -0.3, 0.3, 0, 0.0, 0.05),
        ),
        "a further body fixed to the torso at shaft height", _payload,
    ),
    EffectKind(
        "chassis_twist", "support", ALL, (_p("rad_per_nm", "rad/N m", 0, 0.05, 0, 0.002, 0.006),),
        "hinges about x with springs between the rows of legs", _chassis_twist,
    ),
    EffectKind(
        "missed_steps", "actuation", BOTH,
        (_p("per_s", "1/s", 0, 5, 0, 0.3, 1.0), _p("hold_s", "s", 0.01, 2, 0.15, 0.15, 0.22)),
        "a servo misses its goals for a while, at random times", _missed_steps, catalogued=False,
    ),
    EffectKind(
        "loose_leg_stop", "support", LEG, (_p("play_m", "m", 0, 0.01, 0, 0.002, 0.004),),
        "free play in the leg's vertical spring", _loose_leg_stop, catalogued=False,
    ),
)  # fmt: skip
