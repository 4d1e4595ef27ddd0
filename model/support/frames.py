"""Support alone over many frames: loads and pose on the leg springs, and how they change with stiffness.

Loads are smooth in K as long as the contact set stays, and continuous where it changes, so the derivative
is that of the balance of the feet in contact. With rows A_k = (-q_x, q_y, 1), F = -K p, p = A s + q_z and
H = A^T K A over the feet in contact, differentiating A^T F = const by theta = log K gives

    ds / dtheta_j = H^-1 A_j^T F_j,      dF / dtheta = (I - K A H^-1 A^T) diag(F)
"""

from dataclasses import dataclass
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
    check_support(feet_m, ground_m, stiffness_n_m, weight_n)
    answer = answers_for(*feet_m.shape[:2]) if out is None else out
    prepare()
    feet, ground, stiffness = (
        np.ascontiguousarray(values, np.float64) for values in (feet_m, ground_m, stiffness_n_m)
    )
    _solve(feet, ground, stiffness, float(weight_n), *answer)
    if out is None:
        for values in answer:
            readonly(values)
    return answer


def check_support(
    feet_m: FloatArray, ground_m: FloatArray, stiffness_n_m: FloatArray, weight_n: float
) -> None:
    """Check what ``solve_support_frames`` is given.

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


def answers_for(frames: int, count: int) -> SupportSolutions:
    """Return room for the answers of so many frames of so many feet."""
    per_frame = np.zeros((2, frames), dtype=np.int64)
    return SupportSolutions(np.empty((frames, 3)), np.empty((frames, count)), *per_frame)


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


@dataclass(frozen=True, slots=True, eq=False)
class LoadDerivatives:
    """Loads and poses of F frames, and how they change with log K.

    Attributes:
        solved: The model's answer.
        load_slope: d load_k / d log K_j, (F, N, N) [N].
        pose_slope: d (slope_x, slope_y, height) / d log K_j, (F, 3, N) [rad, rad, m].
    """

    solved: SupportSolutions
    load_slope: FloatArray
    pose_slope: FloatArray


def load_derivatives(
    feet_B: FloatArray,  # noqa: N803
    stiffness: FloatArray,
    weight_n: float,
) -> LoadDerivatives:
    """Solve the support of every frame and differentiate it by the logarithms of the stiffnesses.

    Args:
        feet_B: Unloaded feet in the body frame, (F, N, 3) [m].
        stiffness: (N,) [N/m].
        weight_n: Weight carried [N].

    Returns:
        Loads and their derivatives at the contact set that the model finds; where only feet in a row
        carry the body, the derivative along the balance alone.
    """
    frames, legs = feet_B.shape[:2]
    solved = solve_support_frames(feet_B, np.zeros((1, legs)), stiffness, weight_n)
    load = np.nan_to_num(solved.load_n)
    rows = np.stack([-feet_B[..., 0], feet_B[..., 1], np.ones((frames, legs))], axis=2)
    rows = np.where(np.isfinite(rows), rows, 0.0)
    pressed = np.where(load > 0, stiffness, 0.0)[:, :, None] * rows  # K A, (F, N, 3)
    lever = max(float(np.abs(rows[..., :2]).max(initial=0.0)), 1e-9)
    unit = np.array([1 / lever, 1 / lever, 1.0])  # balances the units before the inverse
    balance = (rows.transpose(0, 2, 1) @ pressed) * unit[:, None] * unit
    inverse = np.linalg.pinv(balance, rcond=1e-12, hermitian=True) * unit[:, None] * unit
    pose_slope = inverse @ (rows * load[:, :, None]).transpose(0, 2, 1)
    load_slope = load[:, :, None] * np.eye(legs) - pressed @ pose_slope
    return LoadDerivatives(solved, load_slope, pose_slope)
