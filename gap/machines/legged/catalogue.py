"""The legged simulator's catalogue: every effect, its numbers, where they go, and words for a person.

Names, parameters and conventions are those that diagnoses from anywhere share. ``spread`` is one standard
deviation of what a builder of such machines would expect.
"""

from dataclasses import dataclass
from enum import Enum

from gap.interfaces import Effect, Parameter, Scope
from gap.machines.legged.settings import NO_LIMIT_RAD_S

STAGES = ("actuation", "kinematics", "support", "friction", "dynamics", "external", "sensing")
ALL, LEG, BOTH = (Scope.ALL,), (Scope.JOINT,), (Scope.ALL, Scope.JOINT)


class Combine(Enum):
    """What two causes of one effect do to a number together."""

    ADD = "add"
    MULTIPLY = "multiply"
    LEAST = "least"
    SET = "set"
    SERIES = "series"  # one behind the other
    LIST = "list"  # all parameters together, kept side by side


@dataclass(frozen=True, slots=True)
class Place:
    """Which field of ``gap.machines.legged.settings`` a parameter goes to.

    Attributes:
        group: ``shaft``, ``ground`` or ``sensor``.
        field: Name of the field.
        combine: How.
    """

    group: str
    field: str
    combine: Combine = Combine.ADD


@dataclass(frozen=True, slots=True)
class Entry:
    """An effect and where its parameters go, in their order (one place for LIST and for a switch)."""

    effect: Effect
    places: tuple[Place, ...]


def _number(name: str, unit: str, lower: float, upper: float, spread: float) -> Parameter:
    return Parameter(name, unit, 0.0, lower, upper, spread)


def _ratio(lower: float, upper: float, spread: float, name: str = "ratio") -> Parameter:
    return Parameter(name, "", 1.0, lower, upper, spread)


def _place(
    name: str, unit: str, neutral: float, lower: float, upper: float, spread: float
) -> Parameter:
    """A number that says where or how fast, and means nothing while its partner is neutral."""
    return Parameter(name, unit, neutral, lower, upper, spread)


def _edge(name: str) -> Parameter:
    """A place along the world's x from which the ground is another."""
    return Parameter(name, "m", 0.2, -1.0, 10.0, 0.5, located=True)


def _shaft(*fields: str) -> tuple[Place, ...]:
    return tuple(Place("shaft", name) for name in fields)


def _ground(*fields: str) -> tuple[Place, ...]:
    return tuple(Place("ground", name) for name in fields)


def _sensor(*fields: str) -> tuple[Place, ...]:
    return tuple(Place("sensor", name) for name in fields)


def _times(group: str, name: str) -> tuple[Place, ...]:
    return (Place(group, name, Combine.MULTIPLY),)


def _set(name: str) -> Place:
    return Place("ground", name, Combine.SET)


def _entry(
    name: str,
    stage: str,
    parameters: tuple[Parameter, ...],
    scopes: tuple[Scope, ...],
    places: tuple[Place, ...],
    physics: str,
    remedy: str,
) -> Entry:
    return Entry(Effect(name, stage, parameters, scopes, physics, remedy), places)


ACTUATION = (
    _entry("command_delay", "actuation", (_number("delay_s", "s", 0.0, 0.3, 0.04),), ALL,
           _shaft("delay_s"),
           "A command acts later than it is logged: the whole shaft motion is shifted in time.",
           "Check buffers, bus retries and the time at which commands are stamped."),
    _entry("servo_lag", "actuation", (_number("time_constant_s", "s", 0.0, 0.5, 0.05),), BOTH,
           (Place("shaft", "lags_s", Combine.SERIES),),
           "The shaft follows its command like a first-order low pass.",
           "Raise the servo's position gain, or give the simulator its servo loop."),
    _entry("servo_speed_limit", "actuation",
           (Parameter("limit_rad_s", "rad/s", NO_LIMIT_RAD_S, 0.2, NO_LIMIT_RAD_S, 8.0),), BOTH,
           (Place("shaft", "speed_limit_rad_s", Combine.LEAST),),
           "The shaft cannot turn faster than this; it falls behind in the fast return.",
           "Check supply voltage and the servo's profile velocity, or walk slower."),
    _entry("servo_compliance", "actuation", (_number("rad_per_nm", "rad/(N m)", 0.0, 0.2, 0.02),), BOTH,
           _shaft("compliance_rad_nm"),
           "The shaft gives under the torque of its load, and its encoder sees it.",
           "Raise the servo's position gain or add integral action."),
    _entry("gear_backlash", "actuation", (_number("width_rad", "rad", 0.0, 0.5, 0.02),), LEG,
           _shaft("backlash_rad"),
           "The shaft lies against one or the other flank of the play, whichever way its load pushes.",
           "Replace the gears or the horn of this servo."),
    _entry("shaft_zero_offset", "actuation", (_number("offset_rad", "rad", -0.6, 0.6, 0.05),), LEG,
           _shaft("zero_offset_rad"),
           "The crank sits on its shaft turned by an angle that the encoder does not see.",
           "Refit the horn, or calibrate the zero of this servo."),
)  # fmt: skip

KINEMATICS = (
    _entry("link_length", "kinematics",
           tuple(_number(f"{k}_m", "m", -0.01, 0.01, 0.001) for k in ("crank", "coupler", "rocker")),
           BOTH, _shaft("crank_m", "coupler_m", "rocker_m"),
           "Links of the four-bar are longer or shorter than drawn: the foot's path changes its shape.",
           "Measure the links between pin centres."),
    _entry("hip_mount_offset", "kinematics",
           tuple(_number(name, "m", -0.05, 0.05, 0.005) for name in ("x_m", "y_m")), LEG,
           _shaft("hip_x_m", "hip_y_m"),
           "The crank shaft is not where the drawing has it in the body frame.",
           "Measure where this leg is mounted."),
    _entry("leg_flex", "kinematics",
           tuple(_number(f"{way}_m_per_n", "m/N", 0.0, 2e-3, 5e-5) for way in ("lateral", "longitudinal")),
           ALL, _ground("flex_lateral_m_n", "flex_longitudinal_m_n"),
           "Feet give sideways and fore-aft under friction, and spring back when it goes.",
           "Stiffen legs and bearings, or give the simulator their stiffness."),
)  # fmt: skip

SUPPORT = (
    _entry("leg_stiffness", "support", (_ratio(0.1, 5.0, 0.2),), LEG,
           _times("ground", "stiffness_ratio"),
           "The spring of a leg is softer or stiffer: it carries less or more when several legs share.",
           "Look for a cracked or replaced leg spring; measure its rate."),
    _entry("ground_stiffness", "support", (_ratio(0.05, 1.0, 0.2),), ALL,
           _times("ground", "ground_stiffness"),
           "Soft ground in series with the legs: feet sink in, and their markers do not see it.",
           "Walk on firm ground, or give the simulator the ground's stiffness."),
    _entry("leg_length", "support", (_number("offset_m", "m", -0.03, 0.03, 0.003),), LEG,
           _ground("leg_length_m"),
           "A leg is longer or shorter below its linkage: it takes load earlier or later than the others.",
           "Check foot tip and clamping of this leg."),
    _entry("ground_slope", "support",
           tuple(_number(name, "", -0.2, 0.2, 0.02) for name in ("slope_x", "slope_y")), ALL,
           _ground("slope_x", "slope_y"),
           "The ground rises: gravity pulls downhill, lower feet carry more, the body leans.",
           "Level the floor, or measure its slope."),
    _entry("ground_step", "support",
           (_number("height_m", "m", -0.03, 0.03, 0.005), _edge("x_m")), ALL,
           (Place("ground", "step_height_m"), _set("step_x_m")),
           "Beyond a line across the world's x the ground is higher: feet there carry more.",
           "Look for an edge in the floor."),
    _entry("com_offset", "support",
           tuple(_number(name, "m", -0.1, 0.1, 0.01) for name in ("x_m", "y_m")), ALL,
           _ground("com_x_m", "com_y_m"),
           "The centre of mass is not at the body's origin: loads shift towards it.",
           "Weigh the robot on three points; move the battery."),
    _entry("payload", "support",
           (_number("mass_kg", "kg", 0.0, 5.0, 0.5), _number("x_m", "m", -0.3, 0.3, 0.08),
            _number("y_m", "m", -0.3, 0.3, 0.08)), ALL,
           (Place("ground", "payloads", Combine.LIST),),
           "Something rides on the body: all loads grow, most where it sits.",
           "Take it off, or add its mass to the robot file."),
    _entry("chassis_twist", "support", (_number("rad_per_nm", "rad/(N m)", 0.0, 0.05, 0.004),), ALL,
           _ground("twist_rad_nm"),
           "The chassis gives in torsion: front and rear roll apart and share the loads more evenly.",
           "Brace the chassis, or give the simulator its torsional stiffness."),
)  # fmt: skip

FRICTION = (
    _entry("foot_friction", "friction", (_ratio(0.05, 4.0, 0.25),), LEG, _times("ground", "mu_ratio"),
           "One foot grips less or more than the others.",
           "Look at the rubber of this foot; clean it or change it."),
    _entry("friction_level", "friction", (_ratio(0.05, 4.0, 0.25),), ALL, _times("ground", "mu_ratio"),
           "All feet grip less or more than the robot file says.",
           "Measure friction by pulling the standing robot; correct mu."),
    _entry("friction_anisotropy", "friction",
           tuple(_number(name, "", -1.5, 1.5, 0.3) for name in ("w_x", "w_y")), BOTH, _ground("w_x", "w_y"),
           "Feet grip more along one direction of the body than across it.",
           "Look for ribs or wear on the feet; correct the anisotropy."),
    _entry("coulomb_friction", "friction", (), ALL, (_set("coulomb"),),
           "Friction does not grow with slip: feet stick, or slide at the full mu N.",
           "Use Coulomb's law in the simulator."),
    _entry("stiction", "friction",
           (
               _ratio(1.0, 3.0, 0.3, "static_ratio"),
               _place("speed_m_s", "m/s", 0.005, 0.002, 0.05, 0.005),
           ), ALL,
           (Place("ground", "static_ratio", Combine.MULTIPLY), _set("static_speed_m_s")),
           "A foot at rest grips more than a sliding one.",
           "Use a Stribeck law, or feet of another material."),
    _entry("friction_patch", "friction",
           (_ratio(0.1, 4.0, 0.25), _edge("x_m")), ALL,
           (Place("ground", "patch_ratio", Combine.MULTIPLY), _set("patch_x_m")),
           "Beyond a line across the world's x the ground is more or less slippery.",
           "Clean the floor, or look where its surface changes."),
    _entry("foot_rolling", "friction", (_number("radius_m", "m", 0.0, 0.05, 0.006),), ALL,
           _shaft("rolling_m"),
           "The foot is round and turns with its link: its surface rolls over the ground as the leg leans.",
           "Give the simulator the radius of the feet."),
    _entry("tilt_coupling", "friction", (), ALL, (_set("tilt_coupling"),),
           "On a tilted body the feet's vertical speed has a share along the ground.",
           "Switch the model's tilt coupling on."),
)  # fmt: skip

DYNAMICS = (
    _entry("inertia_lag", "dynamics", (_number("time_constant_s", "s", 0.0, 0.5, 0.03),), ALL,
           _ground("inertia_s"),
           "The body's velocity follows the balance of forces with a lag, because it has mass.",
           "Give the simulator inertia; a lag above 20 ms is more likely a delay or a filter."),
    _entry("tether_force", "external",
           tuple(_number(name, "N", -30.0, 30.0, 2.0) for name in ("x_n", "y_n")), ALL,
           _ground("tether_x_n", "tether_y_n"),
           "Something pulls at the body with a steady force in the world.",
           "Free the cable, or walk the other way to tell it from a slope."),
    _entry("drag", "external", (_number("n_s_per_m", "N s/m", 0.0, 2000.0, 130.0),), ALL,
           _ground("drag_n_s_m"),
           "A force against the body's velocity, such as a dragged cable.",
           "Lift the cable; look for something that rubs."),
)  # fmt: skip

SENSING = (
    _entry("force_gain", "sensing", (_ratio(0.3, 3.0, 0.1),), LEG, _times("sensor", "force_gain"),
           "A force-torque sensor reads more or less than the truth, on all its axes.",
           "Hang a known weight on this foot; check which calibration is loaded."),
    _entry("force_bias", "sensing",
           tuple(_number(name, "N", -20.0, 20.0, 1.0) for name in ("x_n", "y_n", "z_n")), LEG,
           _sensor("bias_x_n", "bias_y_n", "bias_z_n"),
           "A force-torque sensor reads something when nothing touches the foot.",
           "Tare it with the leg in the air."),
    _entry("force_drift", "sensing", (_number("n_per_s", "N/s", -1.0, 1.0, 0.02),), LEG,
           _sensor("drift_n_s"),
           "The zero of a sensor's vertical channel wanders with time, from heat for example.",
           "Let it warm up, and tare it between runs."),
    _entry("force_rotation", "sensing", (_number("yaw_rad", "rad", -0.8, 0.8, 0.06),), LEG,
           _sensor("force_yaw_rad"),
           "A transducer is mounted turned about the vertical: x and y are mixed.",
           "Correct the yaw of this transducer in the robot file."),
    _entry("force_delay", "sensing", (_number("delay_s", "s", 0.0, 0.4, 0.04),), ALL,
           _sensor("force_delay_s"),
           "The force stream comes later than it is stamped, by radio and buffers.",
           "Correct its time stamps; check the unit's rate and oversampling."),
    _entry("force_lowpass", "sensing", (_number("time_constant_s", "s", 0.0, 0.4, 0.04),), ALL,
           _sensor("force_lag_s"),
           "The force stream is smoothed by a filter of the sensor.",
           "Set the filter of the unit, or filter the simulator alike."),
    _entry("pose_delay", "sensing", (_number("delay_s", "s", -0.3, 0.3, 0.03),), ALL,
           _sensor("pose_delay_s"),
           "Motion capture comes later than it is stamped, body and foot markers together.",
           "Synchronise the clocks; correct the stamps by this time."),
    _entry("pose_yaw_offset", "sensing", (_number("yaw_rad", "rad", -0.5, 0.5, 0.04),), ALL,
           _sensor("pose_yaw_rad"),
           "The markers' frame is turned in the body: straight walking looks slanted.",
           "Align the markers' frame with the body's axes."),
    _entry("pose_origin_offset", "sensing",
           tuple(_number(name, "m", -0.1, 0.1, 0.01) for name in ("x_m", "y_m")), ALL,
           _sensor("pose_x_m", "pose_y_m"),
           "The markers' frame has its origin beside the body's.",
           "Measure where the markers' origin sits in the body."),
    _entry("clock_skew", "sensing", (_ratio(0.95, 1.05, 0.002),), ALL, _times("sensor", "clock_ratio"),
           "The motion-capture clock runs faster or slower than the controller's: its stream drifts away.",
           "Synchronise the clocks, or stamp all streams by one."),
    _entry("encoder_scale", "sensing", (_ratio(0.8, 1.25, 0.01),), LEG, _times("sensor", "encoder_ratio"),
           "The logged shaft angle is the true one times a factor.",
           "Check the encoder's counts a turn and the gear ratio in the conversion."),
)  # fmt: skip

CATALOGUE: tuple[Entry, ...] = (
    *ACTUATION, *KINEMATICS, *SUPPORT, *FRICTION, *DYNAMICS, *SENSING,
)  # fmt: skip
