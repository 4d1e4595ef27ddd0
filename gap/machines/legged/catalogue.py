"""The legged simulator's catalogue of effects, in words for a person: what happens, and what to do.

Their numbers, and what they do to the chain, are in ``model.effects``.
"""

from types import MappingProxyType

from gap.interfaces import Effect
from model.effects.catalogue import EFFECTS

WORDS = MappingProxyType({
    "command_delay": (
        "A command acts later than it is logged: the whole shaft motion is shifted in time.",
        "Check buffers, bus retries and the time at which commands are stamped."),
    "servo_lag": (
        "The shaft follows its command like a first-order low pass.",
        "Raise the servo's position gain, or give the simulator its servo loop."),
    "servo_speed_limit": (
        "The shaft cannot turn faster than this; it falls behind in the fast return.",
        "Check supply voltage and the servo's profile velocity, or walk slower."),
    "servo_compliance": (
        "The shaft gives under the torque of its load, and its encoder sees it.",
        "Raise the servo's position gain or add integral action."),
    "gear_backlash": (
        "The shaft lies against one or the other flank of the play, whichever way its load pushes.",
        "Replace the gears or the horn of this servo."),
    "shaft_zero_offset": (
        "The crank sits on its shaft turned by an angle that the encoder does not see.",
        "Refit the horn, or calibrate the zero of this servo."),
    "link_length": (
        "Links of the four-bar are longer or shorter than drawn: the foot's path changes its shape.",
        "Measure the links between pin centres."),
    "hip_mount_offset": (
        "The crank shaft is not where the drawing has it in the body frame.",
        "Measure where this leg is mounted."),
    "leg_flex": (
        "Feet give sideways and fore-aft under friction, and spring back when it goes.",
        "Stiffen legs and bearings, or give the simulator their stiffness."),
    "leg_stiffness": (
        "The spring of a leg is softer or stiffer: it carries less or more when several legs share.",
        "Look for a cracked or replaced leg spring; measure its rate."),
    "ground_stiffness": (
        "Soft ground in series with the legs: feet sink in, and their markers do not see it.",
        "Walk on firm ground, or give the simulator the ground's stiffness."),
    "leg_length": (
        "A leg is longer or shorter below its linkage: it takes load earlier or later than the others.",
        "Check foot tip and clamping of this leg."),
    "ground_slope": (
        "The ground rises: gravity pulls downhill, lower feet carry more, the body leans.",
        "Level the floor, or measure its slope."),
    "ground_step": (
        "Beyond a line across the world's x the ground is higher: feet there carry more.",
        "Look for an edge in the floor."),
    "com_offset": (
        "The centre of mass is not at the body's origin: loads shift towards it.",
        "Weigh the robot on three points; move the battery."),
    "payload": (
        "Something rides on the body: all loads grow, most where it sits.",
        "Take it off, or add its mass to the robot file."),
    "chassis_twist": (
        "The chassis gives in torsion: front and rear roll apart and share the loads more evenly.",
        "Brace the chassis, or give the simulator its torsional stiffness."),
    "foot_friction": (
        "One foot grips less or more than the others.",
        "Look at the rubber of this foot; clean it or change it."),
    "friction_level": (
        "All feet grip less or more than the robot file says.",
        "Measure friction by pulling the standing robot; correct mu."),
    "friction_anisotropy": (
        "Feet grip more along one direction of the body than across it.",
        "Look for ribs or wear on the feet; correct the anisotropy."),
    "coulomb_friction": (
        "Friction does not grow with slip: feet stick, or slide at the full mu N.",
        "Use Coulomb's law in the simulator."),
    "stiction": (
        "A foot at rest grips more than a sliding one.",
        "Use a Stribeck law, or feet of another material."),
    "friction_patch": (
        "Beyond a line across the world's x the ground is more or less slippery.",
        "Clean the floor, or look where its surface changes."),
    "foot_rolling": (
        "The foot is round and turns with its link: its surface rolls over the ground as the leg leans.",
        "Give the simulator the radius of the feet."),
    "tilt_coupling": (
        "On a tilted body the feet's vertical speed has a share along the ground.",
        "Switch the model's tilt coupling on."),
    "inertia_lag": (
        "The body's velocity follows the balance of forces with a lag, because it has mass.",
        "Give the simulator inertia; a lag above 20 ms is more likely a delay or a filter."),
    "tether_force": (
        "Something pulls at the body with a steady force in the world.",
        "Free the cable, or walk the other way to tell it from a slope."),
    "drag": (
        "A force against the body's velocity, such as a dragged cable.",
        "Lift the cable; look for something that rubs."),
    "force_gain": (
        "A force-torque sensor reads more or less than the truth, on all its axes.",
        "Hang a known weight on this foot; check which calibration is loaded."),
    "force_bias": (
        "A force-torque sensor reads something when nothing touches the foot.",
        "Tare it with the leg in the air."),
    "force_drift": (
        "The zero of a sensor's vertical channel wanders with time, from heat for example.",
        "Let it warm up, and tare it between runs."),
    "force_rotation": (
        "A transducer is mounted turned about the vertical: x and y are mixed.",
        "Correct the yaw of this transducer in the robot file."),
    "force_delay": (
        "The force stream comes later than it is stamped, by radio and buffers.",
        "Correct its time stamps; check the unit's rate and oversampling."),
    "force_lowpass": (
        "The force stream is smoothed by a filter of the sensor.",
        "Set the filter of the unit, or filter the simulator alike."),
    "pose_delay": (
        "Motion capture comes later than it is stamped, body and foot markers together.",
        "Synchronise the clocks; correct the stamps by this time."),
    "pose_yaw_offset": (
        "The markers' frame is turned in the body: straight walking looks slanted.",
        "Align the markers' frame with the body's axes."),
    "pose_origin_offset": (
        "The markers' frame has its origin beside the body's.",
        "Measure where the markers' origin sits in the body."),
    "clock_skew": (
        "The motion-capture clock runs faster or slower than the controller's: its stream drifts away.",
        "Synchronise the clocks, or stamp all streams by one."),
    "encoder_scale": (
        "The logged shaft angle is the true one times a factor.",
        "Check the encoder's counts a turn and the gear ratio in the conversion."),
})  # fmt: skip
CATALOGUE = tuple(
    Effect(one.name, one.stage, one.parameters, one.scopes, *WORDS[one.name])
    for one in EFFECTS.values()
)
