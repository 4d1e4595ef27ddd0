"""The realities there are by name, and others drawn from the same parts."""

import difflib
import math
import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from model.errors import ConfigError
from record.trial.header import TrialNoise
from sim_hw.plant.structure import ContactForm, GearSide, LoopKind, ServoLoop
from sim_hw.realities.reality import (
    Gears,
    LegForm,
    Reality,
    RobotNumbers,
    Sensing,
    Surface,
    Times,
    UnequalLegs,
)
from sim_hw.twin.days import DayScatter
from sim_hw.twin.sensing import HEALTHY_NOISE

SOFT_SERVO = ServoLoop(gain=0.45, speed_damping=0.05)
CASCADED = ServoLoop(kind=LoopKind.CASCADED, angle_gain=60.0)
CASCADED_AT_THE_SHAFT = ServoLoop(
    kind=LoopKind.CASCADED, angle_gain=15.0, speed_gain=0.15, speed_integral=1.0,
    feedback=GearSide.SHAFT,
)  # fmt: skip
PROFILED = ServoLoop(profile_speed=5.0, profile_acceleration=25.0)
AT_THE_SHAFT = ServoLoop(feedback=GearSide.SHAFT)
AT_THE_MOTOR = ServoLoop(encoder=GearSide.MOTOR)

SOFT_PYRAMID = ContactForm(
    elliptic=False, time_constant_s=0.012, solimp=(0.9, 0.95, 0.002, 0.5, 2.0), friction_ratio=60.0
)
BOUNCING = ContactForm(time_constant_s=0.004, damping_ratio=0.5)
REGULARISED = ContactForm(time_constant_s=0.004, friction_ratio=10.0)
STRIBECK = Surface(static_ratio=1.35, static_speed_m_s=0.02)
MAT = Surface(SOFT_PYRAMID, give_n_per_m=12000.0)

HEAVY_LEG = LegForm(foot_mass_kg=0.15, side_damping_ratio=0.2)
WHIPPY_LEG = LegForm(side=0.35, fore_aft=0.5, side_damping_ratio=0.2)
PROGRESSIVE_LEG = LegForm(hardening_per_m2=8000.0)

NO_FORCES = replace(HEALTHY_NOISE, force_n=math.nan)
NO_MARKERS = replace(HEALTHY_NOISE, foot_position_m=math.nan)
POSE_ONLY = TrialNoise(
    body_position_m=0.0005, body_angle_rad=0.001, shaft_rad=HEALTHY_NOISE.shaft_rad
)
ON_THE_SHANK = Sensing(marker_share=0.3, noise=replace(HEALTHY_NOISE, foot_position_m=0.0006))
COLOURED = Sensing(
    filter_s=0.015, wander_n=0.25, wander_s=0.8, noise=replace(HEALTHY_NOISE, force_n=0.12)
)
ONE_RESTLESS = DayScatter(legs=(1.0, 1.0, 3.0, 1.0, 1.0, 1.0), length_m=0.0002)
RESTLESS = DayScatter(
    mu=0.02, floor_mu=0.06, stiffness=0.03, zero_rad=0.004, force_zero_n=0.15, length_m=0.0002,
    legs=(0.5, 1.0, 0.7, 2.5, 1.0, 0.5),
)  # fmt: skip
BUILT_BY_HAND = UnequalLegs(stiffness=0.1, mu=0.08, length_m=0.0006, link_m=0.00025, mount_m=0.0015)

# A robot of two thirds the size: its file, as its lab would have written it.
SMALL: RobotNumbers = (
    ("body.mass", 2.8),
    ("body.inertia", (0.022, 0.03, 0.045)),
    ("legs.shaft_position", Times(0.7)),
    ("leg.crank", Times(0.7)),
    ("leg.ground_pivot", Times(0.7)),
    ("leg.coupler", Times(0.7)),
    ("leg.rocker", Times(0.7)),
    ("leg.foot", Times(0.7)),
    ("contact.stiffness", Times(0.75)),
    ("contact.mu", Times(1.25)),
    ("loop.rate", 50),
)
# And a heavier one, longer than wide, read twice as often.
LARGE: RobotNumbers = (
    ("body.mass", 9.5),
    ("body.inertia", (0.16, 0.34, 0.45)),
    ("legs.shaft_position", (
        (-0.24, 0.26, 0.0), (0.02, 0.29, 0.0), (0.28, 0.26, 0.0),
        (-0.24, -0.26, 0.0), (0.02, -0.29, 0.0), (0.28, -0.26, 0.0),
    )),
    ("contact.stiffness", Times(1.5)),
    ("contact.mu", Times(0.8)),
    ("loop.rate", 200),
)  # fmt: skip

USUAL = Reality("usual", "the usual twin: stiff loop on the motor's side, hard contact, light legs")
REALITIES = (
    USUAL,
    Reality(
        "soft_servo", "softer position loop with speed feedback; legs with mass",
        loop=SOFT_SERVO, leg=HEAVY_LEG,
    ),
    Reality(
        "cascaded", "speed loop inside the position loop; bouncing contact",
        loop=CASCADED, surface=Surface(BOUNCING),
    ),
    Reality(
        "profile", "trapezoidal profile inside the servo; marker on the shank",
        loop=PROFILED, sensing=ON_THE_SHANK,
    ),
    Reality(
        "play_inside", "gears with play, inside the loop: it closes on the shaft",
        loop=AT_THE_SHAFT, gears=Gears(backlash_rad=0.008),
    ),
    Reality(
        "play_outside", "gears with play and give, outside the loop and unseen by the encoder",
        loop=AT_THE_MOTOR, gears=Gears(backlash_rad=0.008, compliance_rad_per_nm=0.004),
    ),
    Reality(
        "loaded_gears", "gear friction that grows with load; feet of rubber (Stribeck)",
        gears=Gears(load=0.2, stribeck=0.5), surface=STRIBECK,
    ),
    Reality("mat", "soft contact with a pyramidal cone, on a mat that gives", surface=MAT),
    Reality(
        "creeping_feet", "regularised friction: feet creep before they slide",
        surface=Surface(REGULARISED),
    ),
    Reality(
        "whippy_legs", "legs that give sideways and ring; springs that get stiffer",
        leg=replace(WHIPPY_LEG, hardening_per_m2=PROGRESSIVE_LEG.hardening_per_m2),
    ),
    Reality(
        "flexible_chassis", "chassis that twists; marker on the shank",
        twist_rad_per_nm=0.0015, sensing=ON_THE_SHANK,
    ),
    Reality(
        "coloured_forces", "forces filtered, with coloured noise", sensing=COLOURED,
    ),
    Reality(
        "no_forces", "no force sensors; soles that roll",
        surface=Surface(rolling_m=0.008), sensing=Sensing(noise=NO_FORCES),
    ),
    Reality(
        "pose_only", "no force sensors and no foot markers: shafts and the body's pose",
        sensing=Sensing(noise=POSE_ONLY),
    ),
    Reality(
        "unequal_legs", "legs built by hand: stiffness, friction, length, links, mounts differ",
        unequal=BUILT_BY_HAND,
    ),
    Reality(
        "restless", "days that differ more, and not alike for all legs; one leg three times",
        days=RESTLESS,
    ),
    Reality(
        "small", "another hexapod, two thirds as large, at 50 Hz; softer loop, one restless leg",
        robot=SMALL, loop=ServoLoop(gain=0.7), days=ONE_RESTLESS,
    ),
    Reality(
        "large", "another hexapod, heavier and longer, at 200 Hz; no foot markers, heavy legs",
        robot=LARGE, leg=HEAVY_LEG, sensing=Sensing(noise=NO_MARKERS),
    ),
    Reality(
        "workshop", "all at once: cascaded loop, play inside, mat, heavy unequal legs, twist, days",
        loop=CASCADED_AT_THE_SHAFT, gears=Gears(backlash_rad=0.004, load=0.08),
        surface=replace(MAT, static_ratio=1.15), leg=HEAVY_LEG, twist_rad_per_nm=0.0008,
        unequal=BUILT_BY_HAND, days=RESTLESS, sensing=replace(COLOURED, marker_share=0.3),
    ),
)  # fmt: skip

SMALL_LEG = 0.3  # of the mass of a leg of the usual size: about the cube of 0.7
DRAWN = re.compile(r"drawn-(\d{1,9})")
_PARTS: Mapping[str, tuple[object, ...]] = {
    "loop": (
        ServoLoop(), SOFT_SERVO, CASCADED, PROFILED, AT_THE_SHAFT, AT_THE_MOTOR,
        CASCADED_AT_THE_SHAFT, replace(PROFILED, gain=0.7),
    ),
    "gears": (
        Gears(), Gears(backlash_rad=0.005), Gears(load=0.12), Gears(compliance_rad_per_nm=0.006),
        Gears(backlash_rad=0.008, load=0.06),
    ),
    "surface": (
        Surface(), Surface(BOUNCING), Surface(REGULARISED), Surface(SOFT_PYRAMID), MAT, STRIBECK,
        Surface(rolling_m=0.008),
    ),
    "leg": (LegForm(), HEAVY_LEG, WHIPPY_LEG, PROGRESSIVE_LEG),
    "twist_rad_per_nm": (0.0, 0.0, 0.001),
    "unequal": (UnequalLegs(), BUILT_BY_HAND, UnequalLegs(stiffness=0.15)),
    "days": (DayScatter(), ONE_RESTLESS, RESTLESS),
    "sensing": (
        Sensing(), ON_THE_SHANK, COLOURED, Sensing(noise=NO_FORCES), Sensing(noise=NO_MARKERS),
        Sensing(noise=POSE_ONLY),
    ),
    "robot": ((), (), SMALL, LARGE),
}  # fmt: skip


def drawn_reality(number: int) -> Reality:
    """Return a reality of which every part is drawn from those of the others; always the same one."""
    random = np.random.default_rng([number, 0x72])
    numbers = {key: int(random.integers(len(parts))) for key, parts in _PARTS.items()}
    chosen = {key: _PARTS[key][at] for key, at in numbers.items()}
    words = ", ".join(f"{key.split('_')[0]} {at + 1}" for key, at in numbers.items() if at)
    made: Reality = replace(Reality(f"drawn-{number}", f"drawn: {words or 'as usual'}"), **chosen)  # type: ignore[arg-type]
    # heavy legs of the usual size have more inertia than the whole small robot
    if made.robot is SMALL:
        made = replace(made, leg=replace(made.leg, foot_mass_kg=SMALL_LEG * made.leg.foot_mass_kg))
    return made


def find_reality(name: str) -> Reality:
    """Return a reality by its name, or ``drawn-N`` for any whole number N.

    Raises:
        ConfigError: There is none of that name.
    """
    for one in REALITIES:
        if one.name == name:
            return one
    if drawn := DRAWN.fullmatch(name):
        return drawn_reality(int(drawn[1]))
    if name == "all":
        raise ConfigError("--reality", "all is for bigant campaign make; a run is of one reality")
    names = [one.name for one in REALITIES]
    near = difflib.get_close_matches(name, names, n=1)
    hint = f"did you mean {near[0]}? " if near else ""
    raise ConfigError(
        "--reality",
        f"{name!r} is not known; {hint}known are {', '.join(names)}, drawn-N (and all, for a campaign)",
    )


def why_not_in(reality: Reality, effect: str) -> str:
    """Say why an effect cannot be in a reality, in words; empty if it can."""
    if effect.startswith("force_") and not reality.sensing.forces:
        return "it has no force sensors"
    if effect.startswith("marker_") and not reality.sensing.markers:
        return "it has no foot markers"
    if effect == "foot_rolling" and reality.surface.rolling_m > 0:
        return "its feet roll already"
    return ""
