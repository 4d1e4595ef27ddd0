"""Support alone over many frames: the loads and the pose of the body on its leg springs."""

from typing import NamedTuple

import numpy as np

from model.compiled import COUNT, NUMBER, compile_for, compiled, given, out
from model.errors import ModelError
from model.support.kernel import ROWS, support_kernel
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly


class SupportSolutions(NamedTuple):
    """F frames of N feet; NaN where there is no answer (the robot tips, or a number is missing).

    Attributes:
        pose: slope_x, slope_y, height [m], (F, 3).
        load_n: Ground's vertical force on each foot, (F, N).
        switches: Steps of the contact search, (F,).
        reason: ``model.quasistatic.frames.Reason`` of each frame, (F,).
    """

    pose: FloatArray
    load_n: FloatArray
    switches: IntArray
    reason: IntArray

    @property
    def valid(self) -> BoolArray:
        """(F,) whether the frame has an answer."""
        fine: BoolArray = self.reason == 0
        return fine


def solve_support_frames(
    feet_m: FloatArray,
    ground_m: FloatArray,
    stiffness_n_m: FloatArray,
    weight_n: float,
    out: SupportSolutions | None = None,
) -> SupportSolutions:
    """Find the balance of each frame.

    Args:
        feet_m: Unloaded feet, seen from the centre of mass, (F, N, 3).
        ground_m: Height of the ground under each foot, (F or 1, N).
        stiffness_n_m: Leg springs, (N,), positive.
        weight_n: Weight carried, positive.
        out: Arrays at hand to write the answer into.

    Raises:
        ModelError: Shapes do not fit, or a stiffness or the weight is not positive.
    """
    frames, count, _ = feet_m.shape
    if ground_m.shape not in {(frames, count), (1, count)} or stiffness_n_m.shape != (count,):
        raise ModelError(
            f"the ground must be ({frames} or 1, {count}) and stiffness ({count},), not "
            f"{ground_m.shape} and {stiffness_n_m.shape}"
        )
    if not (weight_n > 0 and (stiffness_n_m > 0).all()):
        raise ModelError("weight and stiffness must be positive")
    answer = out
    if answer is None:
        per_frame = np.zeros((2, frames), dtype=np.int64)
        answer = SupportSolutions(np.empty((frames, 3)), np.empty((frames, count)), *per_frame)
    prepare()
    feet, ground, stiffness = (
        np.ascontiguousarray(values, np.float64) for values in (feet_m, ground_m, stiffness_n_m)
    )
    _solve(feet, ground, stiffness, float(weight_n), *answer)
    if out is None:
        for values in answer:
            readonly(values)
    return answer


@compiled
def _solve(
    feet: FloatArray, ground: FloatArray, stiffness: FloatArray, weight: float,
    pose: FloatArray, loads: FloatArray, switches: IntArray, reason: IntArray,
) -> None:  # fmt: skip
    work = np.empty((ROWS, feet.shape[1]))
    for f in range(feet.shape[0]):
        level = ground[f if ground.shape[0] > 1 else 0]
        status = support_kernel(feet[f], level, stiffness, weight, pose[f], loads[f], work)
        switches[f], reason[f] = max(status, 0), max(-status, 0)
        if status < 0:
            pose[f, :] = np.nan
            loads[f, :] = np.nan


def prepare() -> None:
    """Compile for read-only inputs, which writable ones fit too, and for nothing else after."""
    compile_for(_solve, *given(3, 2, 1), NUMBER, *out(2, 2), *out(1, 1, kind=COUNT))
