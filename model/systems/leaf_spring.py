"""Legs that are leaf springs: what motion tracking sees of them, and the unloaded foot behind it.

The model wants the foot where it would be without load. A tracked foot of a leaf-spring leg is
deflected while it stands, so the paper takes its place relative to the rigid segment that holds the
spring from frames in which the leg hangs free, and carries it over to the frames in which it stands.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """The rigid segment behind each leg's spring.

    Attributes:
        position_B: Origin in the body frame, (F, N, 3) [m].
        rotation: From segment to body axes, (F, N, 3, 3).
    """

    position_B: FloatArray  # noqa: N815 - frame suffix
    rotation: FloatArray


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
