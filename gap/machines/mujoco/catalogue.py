"""The effects of an MJCF machine, made from its model: bounds by each joint's own torque and inertia.

What each joint has of its own is there twice: at one joint, and at every joint at once with numbers of its
own (``at_every_joint``), scaled to that joint.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.machines.mujoco.drive import DriveTable
from gap.machines.mujoco.effect_table import (
    BODY,
    DAMPED,
    JOINT_EFFECTS,
    LIMITED,
    LOAD,
    OF_INERTIA,
    OF_TORQUE,
    ONE,
    PER_TORQUE,
    PLAIN,
    SENSING,
    SPEEDS,
    TORQUES,
    WORLD,
    JointRow,
    MjcfEffect,
    ratio,
    share,
)
from model.effects.causes import Parameter, Scope, at_every_joint
from model.values.arrays import FloatArray

USUAL_RAD_S2 = 20.0  # what a joint's own inertia is held against where nothing hangs on it
TIMES_HELD = (
    5.0  # gravity and inertia together that a joint is made for, without a limit in the files
)
MASS_SPREAD, PLACE_SPREAD = 0.15, 0.15


@dataclass(frozen=True, slots=True)
class JointScales:
    """What is usual at each joint, (J,): torque [N m] and inertia [kg m2]."""

    torque_nm: FloatArray
    inertia_kg_m2: FloatArray


@dataclass(frozen=True, slots=True)
class BodyScales:
    """Names of bodies with mass [kg] and size [m], and of those that carry: ends of chains, a free base."""

    names: tuple[str, ...]
    mass_kg: FloatArray
    size_m: FloatArray
    carriers: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Askable:
    """What a machine's logs leave to be asked.

    Attributes:
        contact: Whether bodies touch.
        speeds: Whether logged speeds disagree with the angles.
        torques: Whether torque is compared.
    """

    contact: bool = False
    speeds: bool = False
    torques: bool = False


def usual_torque(
    held_nm: FloatArray, inertia_kg_m2: FloatArray, limit_nm: FloatArray
) -> FloatArray:
    """Return the torque that is usual at each joint, (J,): what it is made for, at most its limit."""
    made_for = TIMES_HELD * (held_nm + USUAL_RAD_S2 * inertia_kg_m2)
    return np.asarray(np.fmax(np.fmin(made_for, limit_nm), 1e-6))


def make_catalogue(
    drive: DriveTable,
    joints: Sequence[str],
    scales: JointScales,
    bodies: BodyScales,
    asked: Askable,
) -> tuple[MjcfEffect, ...]:
    """Make all effects that mean something for a machine."""
    there = {
        "": True,
        DAMPED: any(one.kd > 0 for one in drive.joints),
        LIMITED: any(math.isfinite(one.limit) for one in drive.joints),
        TORQUES: asked.torques,
        SPEEDS: asked.speeds,
    }
    rows = [row for row in JOINT_EFFECTS if drive.kind in row.kinds and there[row.needs]]
    return (
        *(_shared(row, scales) for row in rows),
        *(_each(row, scales, joints) for row in rows if row.each and len(joints) > 1),
        *_body_effects(bodies),
        *_world_effects(asked),
    )


def _factors(scales: JointScales) -> dict[str, FloatArray]:
    return {
        PLAIN: np.ones(len(scales.torque_nm)),
        OF_TORQUE: scales.torque_nm,
        OF_INERTIA: scales.inertia_kg_m2,
        PER_TORQUE: 1.0 / scales.torque_nm,
    }


def _times(p: Parameter, usual: float, most: float) -> Parameter:
    """A parameter that was a share of what is usual, and at most so much of the most."""
    return replace(p, lower=p.lower * usual, upper=p.upper * most, spread=p.spread * usual)


def _shared(row: JointRow, scales: JointScales) -> MjcfEffect:
    """An effect with bounds for any of the joints."""
    factors = _factors(scales)
    parameters = tuple(
        _times(p, math.exp(float(np.mean(np.log(factors[size])))), float(factors[size].max()))
        for p, size in zip(row.effect.parameters, row.sizes, strict=True)
    )
    return replace(row.effect, parameters=parameters)


def _each(row: JointRow, scales: JointScales, joints: Sequence[str]) -> MjcfEffect:
    """An effect at every joint, with each joint's own bounds."""
    whole, factors = at_every_joint(row.effect, joints), _factors(scales)
    assert isinstance(whole, MjcfEffect)
    size = len(row.sizes)
    parameters = tuple(
        _times(p, *[float(factors[row.sizes[at % size]][at // size])] * 2)
        for at, p in enumerate(whole.parameters)
    )
    return replace(whole, parameters=parameters)


def _body_effects(bodies: BodyScales) -> tuple[MjcfEffect, ...]:
    if not bodies.names:
        return ()
    size, mass = float(np.median(bodies.size_m)), float(np.median(bodies.mass_kg))
    axes = tuple(Parameter(f"{a}_m", "m", 0.0, -size, size, PLACE_SPREAD * size) for a in "xyz")
    return (
        MjcfEffect(
            "body_mass", LOAD, ratio(0.2, 4.0, MASS_SPREAD), ONE,
            "A body is heavier or lighter than the file says, and its inertia with it.", "Weigh it.",
            BODY, (("mass_ratio", "*"),), parts=bodies.names,
        ),
        MjcfEffect(
            "body_centre", LOAD, axes, ONE,
            "A body's centre of mass lies elsewhere in it.", "Balance it on an edge.",
            BODY, (("x_m", "+"), ("y_m", "+"), ("z_m", "+")), parts=bodies.names,
        ),
        MjcfEffect(
            "payload", LOAD, (share("mass_kg", "kg", 0.3 * mass, 10.0 * mass), *axes), ONE,
            "A weight is fixed to a body. x, y, z count along its axes from its far end: the point that is "
            "twice as far from its origin as its centre of mass.",
            "Weigh it, and measure where it hangs.",
            BODY, (("payload_kg", "+"), *((f"payload_{a}_m", "+") for a in "xyz")), parts=bodies.carriers,
        ),
    )  # fmt: skip


def _world_effects(asked: Askable) -> tuple[MjcfEffect, ...]:
    tilt = tuple(Parameter(f"{n}_rad", "rad", 0.0, -1.6, 1.6, 0.05) for n in ("roll", "pitch"))
    late = Parameter("delay_s", "s", 0.0, -0.1, 0.1, 0.005)
    whole = (Scope.ALL,)
    effects = (
        MjcfEffect(
            "gravity_direction", LOAD, tilt, whole,
            "The base does not stand level, so gravity pulls from another side.",
            "Put a level on the base.", WORLD, (("roll_rad", "+"), ("pitch_rad", "+")),
        ),
        MjcfEffect(
            "stamp_delay", SENSING, (late,), whole,
            "Readings are stamped later than they were taken.",
            "Stamp them where they are read.", WORLD, (("stamp_delay_s", "+"),),
        ),
        MjcfEffect(
            "clock_ratio", SENSING, ratio(0.9, 1.1, 0.001), whole,
            "The clock of the readings runs faster or slower than that of the commands.",
            "Use one clock for both.", WORLD, (("clock_ratio", "*"),),
        ),
        MjcfEffect(
            "contact_friction", LOAD, ratio(0.05, 5.0, 0.3), whole,
            "Feet grip more or less than the file says.", "Pull a foot with a spring balance.",
            WORLD, (("contact_friction", "*"),), by_forces=True,
        ),
    )  # fmt: skip
    return effects if asked.contact else effects[:-1]
