"""Multipods: 6 to 12 leaf-spring legs in pairs, moved by a wave that runs along the body.

Each contralateral pair turns as one rigid segment with two degrees of freedom, yaw and roll, on a
rigid backbone. Rolling puts one foot of the pair down and lifts the other; yawing in quadrature moves
the foot that is down backward.

The paper gives K = 1, mu = 1 and a weight of N without units. With its motion tracking in
millimetres that is 1 N/mm, which is what we take: 1 N/m would sink the robot by a metre.

The model wants each foot where it would be without load. A tracked foot of a leaf-spring leg is deflected
while it stands, so the paper takes its place relative to the rigid segment that holds the spring from
frames in which the leg hangs free, and carries it over to the frames in which it stands.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.systems.system import System, box, equal_contacts, even_times
from model.systems.two_axis import rotations, swing
from model.values.arrays import BoolArray, FloatArray

LEG_COUNTS = (6, 8, 10, 12)
FREQUENCY_HZ = 0.3
PHASE_OFFSET_RAD = 1.35 * np.pi  # of each pair ahead of the pair in front of it
STIFFNESS_N_M, MU = 1000.0, 1.0
# Assumed.
SPACING_M = 0.16  # pair to pair
HALF_WIDTH_M, HEIGHT_M = 0.20, 0.10
YAW_AMPLITUDE_RAD, ROLL_AMPLITUDE_RAD = 0.35, 0.12


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """The rigid segment behind each leg's spring.

    Attributes:
        position_B: Origin in the body frame, (F, N, 3) [m].
        rotation: From segment to body axes, (F, N, 3, 3).
    """

    position_B: FloatArray  # noqa: N815 - frame suffix
    rotation: FloatArray


def multipod(legs: int = 6, *, cycles: float = 4.0) -> System:
    """A multipod with an undulation gait.

    Args:
        legs: 6, 8, 10 or 12. Foot order: left then right of each pair, hind pair first.
        cycles: Length of the motion.

    Raises:
        ModelError: Another number of legs.
    """
    time_s = even_times(cycles / FREQUENCY_HZ)
    pivot, joints, rates = _joints(legs, time_s)
    arm = np.tile([[0.0, HALF_WIDTH_M, -HEIGHT_M], [0.0, -HALF_WIDTH_M, -HEIGHT_M]], (legs // 2, 1))
    return System(
        name="multipod",
        description=f"multipod with {legs} leaf-spring legs, {FREQUENCY_HZ:g} Hz, "
        f"phase offset {PHASE_OFFSET_RAD / np.pi:.2f} pi",
        time_s=time_s,
        feet=swing(pivot, arm, joints, rates),
        contact=equal_contacts(legs, STIFFNESS_N_M, MU),
        weight_n=float(legs),
        outline_B=box(SPACING_M * (legs // 2 - 0.4), 0.25 * HALF_WIDTH_M),
        hips_B=pivot[:, :2],
    )


def multipod_segments(legs: int, time_s: FloatArray) -> Segments:
    """The rigid segment behind each leg spring of ``multipod``, as motion tracking would see it.

    Args:
        legs: 6, 8, 10 or 12.
        time_s: (F,) [s].
    """
    pivot, joints, _ = _joints(legs, time_s)
    return Segments(np.broadcast_to(pivot, (len(time_s), *pivot.shape)), rotations(joints))


def _joints(legs: int, time_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pivots, (N, 3) [m], and yaw, roll and slide of every leg with their rates, (F, N, 3)."""
    if legs not in LEG_COUNTS:
        raise ModelError(f"a multipod has 6, 8, 10 or 12 legs, not {legs}")
    pair = np.arange(legs) // 2
    still = np.zeros(legs)
    pivot = np.column_stack([SPACING_M * (pair - (legs // 2 - 1) / 2), still, still])
    omega = 2 * np.pi * FREQUENCY_HZ
    theta = omega * time_s[:, None] - PHASE_OFFSET_RAD * pair
    # the left foot is down while the yaw grows, which moves it backward
    size = np.array([YAW_AMPLITUDE_RAD, -ROLL_AMPLITUDE_RAD, 0.0])
    sine, cosine = np.sin(theta), np.cos(theta)
    joints = size * np.stack([sine, cosine, 0 * theta], axis=-1)
    rates = omega * size * np.stack([cosine, -sine, 0 * theta], axis=-1)
    return pivot, joints, rates


def deflect(feet_B: FloatArray, load_n: FloatArray, stiffness: FloatArray) -> FloatArray:  # noqa: N803
    """Feet as they are seen under load: each spring gives way upwards by load over stiffness.

    Args:
        feet_B: Unloaded feet, (F, N, 3) [m].
        load_n: Vertical force on each foot, (F, N) [N]; 0 in the air.
        stiffness: (N,) [N/m].

    Returns:
        Loaded feet in the body frame, (F, N, 3) [m].
    """
    seen = feet_B.copy()
    seen[..., 2] += load_n / stiffness
    return seen


def extrapolate_unloaded(
    feet_B: FloatArray,  # noqa: N803
    loaded: BoolArray,
    segments: Segments,
) -> FloatArray:
    """Where the feet would be without load, from the frames in which they have none.

    The place of a foot in its segment is the median over its unloaded frames, so that a marker that
    jumps once in a while does no harm.

    Args:
        feet_B: Feet as seen, (F, N, 3) [m]; frames with NaN are passed over.
        loaded: Which feet carry load, (F, N).
        segments: The segment behind each leg.

    Returns:
        Unloaded feet in the body frame, (F, N, 3) [m]; NaN for a leg that is never seen unloaded.

    Raises:
        ModelError: Shapes do not fit.
    """
    frames, legs = loaded.shape
    if feet_B.shape != (frames, legs, 3) or segments.rotation.shape != (frames, legs, 3, 3):
        raise ModelError("feet, loads and segments must have the same frames and legs")
    # R^T (foot - origin)
    in_segment = np.einsum("fnji,fnj->fni", segments.rotation, feet_B - segments.position_B)
    arm = np.full((legs, 3), np.nan)
    usable = ~loaded & np.isfinite(in_segment).all(axis=2)
    for leg in np.flatnonzero(usable.any(axis=0)):
        arm[leg] = np.median(in_segment[usable[:, leg], leg], axis=0)
    unloaded: FloatArray = segments.position_B + np.einsum("fnij,nj->fni", segments.rotation, arm)
    return unloaded
