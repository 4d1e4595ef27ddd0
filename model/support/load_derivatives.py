"""How the loads of the spring support change with the stiffness of each leg.

Loads are smooth in K as long as the contact set stays, and continuous where it changes, so the derivative
is that of the balance of the feet in contact. With rows A_k = (-q_x, q_y, 1), F = -K p, p = A s + q_z and
H = A^T K A over the feet in contact, differentiating A^T F = const by theta = log K gives

    ds / dtheta_j = H^-1 A_j^T F_j,      dF / dtheta = (I - K A H^-1 A^T) diag(F)
"""

from dataclasses import dataclass

import numpy as np

from model.support.frames import SupportSolutions, solve_support_frames
from model.values.arrays import FloatArray


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
