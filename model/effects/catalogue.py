"""The catalogue of effects of a legged robot: names, stages, numbers, and how two causes act together.

Names, parameters and conventions are those that robot files and diagnoses from anywhere share. ``spread``
is one standard deviation of what a builder of such machines would expect.
"""

import operator
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType

from model.effects.causes import Effect, Parameter, Scope, Shaking
from model.values.machine_names import MachineNames

STAGES = ("actuation", "kinematics", "support", "friction", "dynamics", "external", "sensing")
# What acts through forces, by its stage or by itself.
FORCE_STAGES = frozenset({"support", "friction", "dynamics", "external"})
MOVED_BY_FORCES = frozenset({
    "servo_compliance", "gear_backlash", "joint_friction", "leg_flex",
    # readings of forces, which are held against forces of a model
    "force_gain", "force_bias", "force_drift", "force_rotation", "force_cross_talk", "force_delay",
    "force_lowpass",
})  # fmt: skip
CHANGES_WITH_TIME = frozenset({"force_drift", "clock_skew"})
MAY_WEAR = frozenset({
    "servo_lag", "servo_compliance", "joint_friction", "shaft_zero_offset", "leg_length", "leg_stiffness",
    "ground_stiffness", "friction_level", "foot_friction",
})  # fmt: skip
# How roughly forms are known, 0 to 1: how a servo gives, rubs and plays depends on its loop and gears; mass
# is pulled along by whatever law feet have, so that forces follow the modelled lag only nearly.
ROUGHLY = {"servo_compliance": 1.0, "gear_backlash": 1.0, "joint_friction": 1.0, "inertia_lag": 0.6}
NO_LIMIT_RAD_S = 10.0  # twice what the servos can do: no limit
ALL, LEG, BOTH = (Scope.ALL,), (Scope.JOINT,), (Scope.ALL, Scope.JOINT)


class Combine(Enum):
    """What two causes of one effect do to a number together."""

    ADD = "add"
    MULTIPLY = "multiply"
    LEAST = "least"
    SET = "set"  # where or how fast; it means nothing while the other numbers are neutral
    APART = "apart"  # each cause acts for itself, all its parameters together


TOGETHER: MappingProxyType[Combine, Callable[[float, float], float]] = MappingProxyType({
    Combine.ADD: operator.add,
    Combine.MULTIPLY: operator.mul,
    Combine.LEAST: min,
    Combine.SET: lambda _, new: new,
    Combine.APART: lambda _, new: new,
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class ChainEffect(Effect):
    """An effect of the chain, and how each of its parameters combines with that of another cause."""

    combine: tuple[Combine, ...]

    @property
    def apart(self) -> bool:
        """Whether each of its causes acts for itself."""
        return Combine.APART in self.combine


Numbers = tuple[tuple[Parameter, Combine], ...]


def _numbers(
    names: str, unit: str, lower: float, upper: float, spread: float, how: Combine = Combine.ADD
) -> Numbers:
    """Numbers that are neutral at 0, of the names that are given with spaces between."""
    return tuple((Parameter(n, unit, 0.0, lower, upper, spread), how) for n in names.split())


def _ratio(lower: float, upper: float, spread: float, name: str = "ratio") -> Numbers:
    return ((Parameter(name, "", 1.0, lower, upper, spread), Combine.MULTIPLY),)


def _effect(
    stage: str,
    name: str,
    scopes: tuple[Scope, ...],
    numbers: Numbers,
    physics: str,
    remedy: str,
    form_of: str = "",
) -> ChainEffect:
    parameters, combine = tuple(p for p, _ in numbers), tuple(how for _, how in numbers)
    family = form_of or name
    by_forces = stage in FORCE_STAGES or family in MOVED_BY_FORCES
    return ChainEffect(
        name, stage, parameters, scopes, physics, remedy, combine,
        by_forces=by_forces, form_of=form_of, in_time=name in CHANGES_WITH_TIME,
        wears=name in MAY_WEAR, rough=ROUGHLY.get(family, 0.0),
    )  # fmt: skip


_LIMIT = (
    (Parameter("limit_rad_s", "rad/s", NO_LIMIT_RAD_S, 0.2, NO_LIMIT_RAD_S, 8.0), Combine.LEAST),
)
_SLIP = ((Parameter("speed_m_s", "m/s", 0.005, 0.002, 0.05, 0.005), Combine.SET),)
# A place along the world's x from which the ground is another.
_EDGE = ((Parameter("x_m", "m", 0.2, -1.0, 10.0, 0.5, located=True), Combine.SET),)
_APART = Combine.APART
# In spreads of a share of 0.5: springs that are stiffer than drawn, or get stiffer under load, give a
# quarter less, which is as if markers showed less of it.
SPRINGS_DIFFER = 0.5
# In spreads of 1 mm: for parts of 30 to 120 mm ISO 2768-1 (medium) allows 0.3 mm.
LINKS_DIFFER = 0.3

_STICK_SLIP = Shaking(
    ("force_x", "force_y"),
    calm=(("force_z",), ("shaft_error",)),
    steady=("friction_level", "friction_patch"),
)

CATALOGUE = (
    _effect("actuation", "command_delay", ALL, _numbers("delay_s", "s", 0.0, 0.3, 0.04),
        "A command acts later than it is logged: the whole shaft motion is shifted in time.",
        "Check buffers, bus retries and the time at which commands are stamped."),
    _effect("actuation", "servo_lag", BOTH, _numbers("time_constant_s", "s", 0.0, 0.5, 0.05, _APART),
        "The shaft follows its command like a first-order low pass.",
        "Raise the servo's position gain, or give the simulator its servo loop."),
    _effect("actuation", "servo_speed_limit", BOTH, _LIMIT,
        "The shaft cannot turn faster than this; it falls behind in the fast return.",
        "Check supply voltage and the servo's profile velocity, or walk slower."),
    _effect("actuation", "servo_compliance", BOTH, _numbers("rad_per_nm", "rad/(N m)", 0.0, 0.2, 0.02),
        "The shaft gives under the torque of its load, and its encoder sees it.",
        "Raise the servo's position gain or add integral action."),
    _effect("actuation", "servo_compliance_beyond_encoder", BOTH,
        _numbers("rad_per_nm", "rad/(N m)", 0.0, 0.2, 0.02),
        "The crank gives under the torque of its load beyond the encoder, which does not see it.",
        "Stiffen gear and horn between this servo's encoder and its crank; no gain of its loop helps.",
        form_of="servo_compliance"),
    replace(_effect("actuation", "gear_backlash", LEG, _numbers("width_rad", "rad", 0.0, 0.5, 0.02),
        "The shaft lies against one or the other flank of the play, whichever way its load pushes.",
        "Replace the gears or the horn of this servo."), curved=True),
    replace(_effect("actuation", "gear_backlash_in_loop", LEG,
        _numbers("width_rad", "rad", 0.0, 0.5, 0.02),
        "The shaft falls from flank to flank of the play, and the loop on its encoder takes that back.",
        "Replace the gears or the horn of this servo; a lower position gain stops its hunting in the air.",
        form_of="gear_backlash"), curved=True, hunts="shaft_error"),
    replace(_effect("actuation", "gear_backlash_dragged", LEG,
        _numbers("width_rad", "rad", 0.0, 0.5, 0.02),
        "Under load the shaft lies against either flank of the play; in the air bearings hold it back.",
        "Replace the gears or the horn of this servo.",
        form_of="gear_backlash"), curved=True),
    replace(_effect("actuation", "gear_backlash_beyond_encoder", LEG,
        _numbers("width_rad", "rad", 0.0, 0.5, 0.02),
        "The crank lies against either flank of a play beyond the encoder, which does not see it.",
        "Replace the horn or the gears between this servo's encoder and its crank.",
        form_of="gear_backlash"), curved=True),
    _effect("actuation", "joint_friction", BOTH, _numbers("behind_rad", "rad", 0.0, 0.3, 0.02),
        "Dry friction at the joint: the shaft follows its set point only once it is this far behind.",
        "Look for a tight bearing or a rubbing link; raise the position gain or add integral action."),
    _effect("actuation", "shaft_zero_offset", LEG, _numbers("offset_rad", "rad", -0.6, 0.6, 0.05),
        "The crank sits on its shaft turned by an angle that the encoder does not see.",
        "Refit the horn, or calibrate the zero of this servo."),
    replace(_effect("kinematics", "link_length", BOTH,
        _numbers("crank_m coupler_m rocker_m", "m", -0.01, 0.01, 0.001),
        "Links of the four-bar are longer or shorter than drawn: the foot's path changes its shape.",
        "Measure the links between pin centres."), least_size=LINKS_DIFFER),
    _effect("kinematics", "hip_mount_offset", LEG, _numbers("x_m y_m", "m", -0.05, 0.05, 0.005),
        "The crank shaft is not where the drawing has it in the body frame.",
        "Measure where this leg is mounted."),
    _effect("kinematics", "leg_flex", ALL,
        _numbers("lateral_m_per_n longitudinal_m_per_n", "m/N", 0.0, 2e-3, 5e-5),
        "Feet give sideways and fore-aft under friction, and spring back when it goes.",
        "Stiffen legs and bearings, or give the simulator their stiffness."),
    _effect("support", "leg_stiffness", LEG, _ratio(0.1, 5.0, 0.2),
        "The spring of a leg is softer or stiffer: it carries less or more when several legs share.",
        "Look for a cracked or replaced leg spring; measure its rate."),
    _effect("support", "ground_stiffness", ALL, _ratio(0.05, 1.0, 0.2),
        "Soft ground in series with the legs: feet sink in, and their markers do not see it.",
        "Walk on firm ground, or give the simulator the ground's stiffness."),
    _effect("support", "leg_length", LEG, _numbers("offset_m", "m", -0.03, 0.03, 0.003),
        "A leg is longer or shorter below its linkage: it takes load earlier or later than the others.",
        "Check foot tip and clamping of this leg, and its spring for play, half of which looks like this."),
    _effect("support", "ground_slope", ALL, _numbers("slope_x slope_y", "", -0.2, 0.2, 0.02),
        "The ground rises: gravity pulls downhill, lower feet carry more, the body leans.",
        "Level the floor, or measure its slope."),
    _effect("support", "ground_step", ALL, _numbers("height_m", "m", -0.03, 0.03, 0.005) + _EDGE,
        "Beyond a line across the world's x the ground is higher: feet there carry more.",
        "Look for an edge in the floor."),
    _effect("support", "com_offset", ALL, _numbers("x_m y_m", "m", -0.1, 0.1, 0.01),
        "The centre of mass is not at the body's origin: loads shift towards it.",
        "Weigh the robot on three points; move the battery."),
    _effect("support", "payload", ALL, _numbers("mass_kg", "kg", 0.0, 5.0, 0.5, _APART)
        + _numbers("x_m y_m", "m", -0.45, 0.45, 0.08, _APART),
        "Something rides on the body: all loads grow, most where it sits.",
        "Take it off, or add its mass to the robot file."),
    _effect("support", "chassis_twist", ALL, _numbers("rad_per_nm", "rad/(N m)", 0.0, 0.05, 0.004),
        "The chassis gives in torsion: opposite moments on front and rear roll them apart, by so much a N "
        "m, against its middle, where its pose is measured.",
        "Brace the chassis, or give the simulator its torsional stiffness."),
    _effect("friction", "foot_friction", LEG, _ratio(0.05, 4.0, 0.25),
        "One foot grips less or more than the others.",
        "Look at the rubber of this foot; clean it or change it."),
    _effect("friction", "friction_level", ALL, _ratio(0.05, 4.0, 0.25),
        "All feet grip less or more than the robot file says.",
        "Measure friction by pulling the standing robot; correct mu."),
    replace(_effect("friction", "friction_anisotropy", BOTH, _numbers("w_x w_y", "", -1.5, 1.5, 0.3),
        "Feet grip more along one direction of the body than across it.",
        "Look for ribs or wear on the feet; correct the anisotropy."), even=True),
    _effect("friction", "coulomb_friction", ALL, (),
        "Friction does not grow with slip: feet stick, or slide at the full mu N.",
        "Use Coulomb's law in the simulator."),
    _effect("friction", "stiction", ALL, _ratio(1.0, 3.0, 0.3, "static_ratio") + _SLIP,
        "A foot at rest grips more than a sliding one.",
        "Use a Stribeck law, or feet of another material."),
    replace(_effect("friction", "stick_slip", ALL, _ratio(1.0, 3.0, 0.3, "static_ratio"),
        "Feet stick and slip in turn, faster than the frames: they grip more in the mean, and vibrate.",
        "Feet of another material; a simulator needs a Stribeck law and steps of a millisecond.",
        form_of="stiction"), shaking=_STICK_SLIP),
    _effect("friction", "friction_patch", ALL, _ratio(0.1, 4.0, 0.25) + _EDGE,
        "Beyond a line across the world's x the ground is more or less slippery.",
        "Clean the floor, or look where its surface changes."),
    _effect("friction", "foot_rolling", ALL, _numbers("radius_m", "m", 0.0, 0.05, 0.006),
        "The foot is round and turns with its link: its surface rolls over the ground as the leg leans.",
        "Give the simulator the radius of the feet."),
    _effect("friction", "tilt_coupling", ALL, (),
        "On a tilted body the feet's vertical speed has a share along the ground.",
        "Switch the model's tilt coupling on."),
    _effect("dynamics", "inertia_lag", ALL, _numbers("time_constant_s", "s", 0.0, 0.5, 0.03),
        "The body's velocity follows the balance of forces with a lag, because it has mass.",
        "Give the simulator inertia; a lag above 20 ms is more likely a delay or a filter."),
    _effect("external", "tether_force", ALL, _numbers("x_n y_n", "N", -30.0, 30.0, 2.0),
        "Something pulls at the body with a steady force in the world.",
        "Free the cable, or walk the other way to tell it from a slope."),
    _effect("external", "drag", ALL, _numbers("n_s_per_m", "N s/m", 0.0, 2000.0, 130.0),
        "A force against the body's velocity, such as a dragged cable.",
        "Lift the cable; look for something that rubs."),
    _effect("sensing", "force_gain", LEG, _ratio(0.3, 3.0, 0.1),
        "A force-torque sensor reads more or less than the truth, on all its axes.",
        "Hang a known weight on this foot; check which calibration is loaded."),
    _effect("sensing", "force_bias", LEG, _numbers("x_n y_n z_n", "N", -20.0, 20.0, 1.0),
        "A force-torque sensor reads something when nothing touches the foot.",
        "Tare it with the leg in the air."),
    _effect("sensing", "force_drift", LEG, _numbers("n_per_s", "N/s", -1.0, 1.0, 0.02),
        "The zero of a sensor's vertical channel wanders with time, from heat for example.",
        "Let it warm up, and tare it between runs."),
    _effect("sensing", "force_rotation", LEG, _numbers("yaw_rad", "rad", -0.8, 0.8, 0.06),
        "A transducer is mounted turned about the vertical: x and y are mixed.",
        "Correct the yaw of this transducer in the robot file."),
    _effect("sensing", "force_cross_talk", LEG, _numbers("x_share y_share", "", -0.5, 0.5, 0.05),
        "A share of the vertical load appears on a transducer's horizontal axes.",
        "Load this leg vertically only; calibrate the transducer again (bigant force calibrate)."),
    _effect("sensing", "force_delay", ALL, _numbers("delay_s", "s", 0.0, 0.4, 0.04),
        "The force stream comes later than it is stamped, by radio and buffers.",
        "Correct its time stamps; check the unit's rate and oversampling."),
    _effect("sensing", "force_lowpass", ALL, _numbers("time_constant_s", "s", 0.0, 0.4, 0.04),
        "The force stream is smoothed by a filter of the sensor.",
        "Set the filter of the unit, or filter the simulator alike."),
    _effect("sensing", "pose_delay", ALL, _numbers("delay_s", "s", -0.3, 0.3, 0.03),
        "Motion capture comes later than it is stamped, body and foot markers together.",
        "Synchronise the clocks; correct the stamps by this time."),
    _effect("sensing", "pose_yaw_offset", ALL, _numbers("yaw_rad", "rad", -0.5, 0.5, 0.04),
        "The markers' frame is turned in the body: straight walking looks slanted.",
        "Align the markers' frame with the body's axes."),
    _effect("sensing", "pose_origin_offset", ALL, _numbers("x_m y_m", "m", -0.1, 0.1, 0.01),
        "The markers' frame has its origin beside the body's.",
        "Measure where the markers' origin sits in the body."),
    replace(_effect("sensing", "marker_on_shank", ALL, _ratio(-0.5, 1.0, 0.5, "share"),
        "Foot markers sit above springs of their legs: they show this share of what legs give under load.",
        "Put the markers on the feet, or measure how far they move when a leg is loaded."),
        least_size=SPRINGS_DIFFER),
    _effect("sensing", "clock_skew", ALL, _ratio(0.95, 1.05, 0.002),
        "The motion-capture clock runs faster or slower than the controller's: its stream drifts away.",
        "Synchronise the clocks, or stamp all streams by one."),
    _effect("sensing", "encoder_scale", LEG, _ratio(0.8, 1.25, 0.01),
        "The logged shaft angle is the true one times a factor.",
        "Check the encoder's counts a turn and the gear ratio in the conversion."),
)  # fmt: skip
EFFECTS = MappingProxyType({effect.name: effect for effect in CATALOGUE})
READS_SHAFTS = "encoder_scale"  # of the sensing stage, all else of which is about feet and body


def touches_shafts(effect: Effect) -> bool:
    """Whether an effect of single places is one of joints; others are of legs."""
    return effect.stage == "actuation" or effect.name == READS_SHAFTS


def places_of(effect: Effect, names: MachineNames) -> tuple[str, ...]:
    """Return what an effect of single places can touch, by name."""
    return names.joints if touches_shafts(effect) else names.legs
