"""Support alone over many frames: the loads and the pose of the body on its leg springs."""

from dataclasses import dataclass

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, compiled, given, out
from model.errors import ModelError
from model.support.kernel import ROWS, support_kernel
from model.values.arrays import BoolArray, FloatArray, readonly


@dataclass(frozen=True, slots=True, eq=False)
class SupportSolutions:
    """F frames of N feet; NaN where ``valid`` is False (the robot tips, or a number is missing).

    Attributes:
        pose: slope_x, slope_y, height [m], (F, 3).
        load_n: Ground's vertical force on each foot, (F, N).
        valid: (F,).
    """

    pose: FloatArray
    load_n: FloatArray
    valid: BoolArray


def solve_support_frames(
    feet_m: FloatArray, ground_m: FloatArray, stiffness_n_m: FloatArray, weight_n: float
) -> SupportSolutions:
    """Find the balance of each frame.

    Args:
        feet_m: Unloaded feet, seen from the centre of mass, (F, N, 3).
        ground_m: Height of the ground under each foot, (F, N).
        stiffness_n_m: Leg springs, (N,), positive.
        weight_n: Weight carried, positive.

    Raises:
        ModelError: Shapes do not fit, or a stiffness or the weight is not positive.
    """
    frames, count, _ = feet_m.shape
    if ground_m.shape != (frames, count) or stiffness_n_m.shape != (count,):
        raise ModelError(f"{frames} frames of {count} feet do not fit ground or stiffness")
    if not (weight_n > 0 and (stiffness_n_m > 0).all()):
        raise ModelError("weight and stiffness must be positive")
    out = SupportSolutions(
        np.empty((frames, 3)), np.empty((frames, count)), np.zeros(frames, dtype=np.bool_)
    )
    prepare()
    _solve(
        np.ascontiguousarray(feet_m, dtype=np.float64),
        np.ascontiguousarray(ground_m, dtype=np.float64),
        np.ascontiguousarray(stiffness_n_m, dtype=np.float64),
        float(weight_n),
        out.pose,
        out.load_n,
        out.valid,
    )
    for name in SupportSolutions.__slots__:
        readonly(getattr(out, name))
    return out


@compiled
def _solve(
    feet: FloatArray, ground: FloatArray, stiffness: FloatArray, weight: float,
    pose: FloatArray, loads: FloatArray, valid: BoolArray,
) -> None:  # fmt: skip
    work = np.empty((ROWS, feet.shape[1]))
    for f in range(feet.shape[0]):
        found = support_kernel(feet[f], ground[f], stiffness, weight, pose[f], loads[f], work)
        valid[f] = found >= 0
        if found < 0:
            pose[f, :] = np.nan
            loads[f, :] = np.nan


def prepare() -> None:
    """Compile for read-only inputs, which writable ones fit too, and for nothing else after."""
    compile_for(_solve, *given(3, 2, 1), NUMBER, *out(2, 2), *out(1, kind=FLAG))
