"""The slip that feet force on each other: what no motion of one rigid body can take away.

With foot velocities q' relative to the body, each standing foot slips by ``v + w S q + q'``. The body
velocity (v, w) that makes the sum of squared slips least leaves a residual: feet whose velocities belong to
one rigid motion leave none. Friction does not enter.
"""

from typing import NamedTuple

import numpy as np

from model.values.arrays import BoolArray, FloatArray

LEAST_FEET = 2  # with fewer, turning is not determined


class ForcedSlip(NamedTuple):
    """The best rigid motion of F frames of N feet; NaN where fewer than two feet stand.

    Attributes:
        velocity_B: vx, vy [m/s], yaw rate [rad/s], (F, 3).
        slip_m_s: Slip that is left at each standing foot, (F, N, 2); NaN in the air.
        rms_m_s: Root mean square of its magnitude over the standing feet, (F,).
    """

    velocity_B: FloatArray  # noqa: N815 - frame suffix
    slip_m_s: FloatArray
    rms_m_s: FloatArray


def forced_slip(feet_m: FloatArray, feet_m_s: FloatArray, down: BoolArray) -> ForcedSlip:
    """Fit a rigid motion to the standing feet of each frame.

    Args:
        feet_m: Feet in the body frame, (F, N, 2) [m].
        feet_m_s: Their velocities relative to the body, (F, N, 2) [m/s].
        down: Which of them stand, (F, N).
    """
    weight = down.astype(np.float64)
    known = weight.sum(axis=1) >= LEAST_FEET
    number = np.where(known, weight.sum(axis=1), 1.0)
    centre = (weight[..., None] * feet_m).sum(axis=1) / number[:, None]
    arm = feet_m - centre[:, None]
    turning = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)  # S q
    inertia = (weight * (arm**2).sum(-1)).sum(axis=1)
    mean = (weight[..., None] * feet_m_s).sum(axis=1) / number[:, None]
    moment = (weight * (turning * feet_m_s).sum(-1)).sum(axis=1)
    yaw_rate = -np.divide(moment, inertia, out=np.zeros_like(moment), where=inertia > 0)
    slip = feet_m_s - mean[:, None] + yaw_rate[:, None, None] * turning
    # the mean is that of the centre; the body frame's origin moves with the turning too
    origin = -mean + yaw_rate[:, None] * np.stack([centre[:, 1], -centre[:, 0]], axis=-1)
    velocity = np.concatenate([origin, yaw_rate[:, None]], axis=1)
    rms = np.sqrt((weight * (slip**2).sum(-1)).sum(axis=1) / number)
    velocity[~known], rms[~known] = np.nan, np.nan
    slip[~down | ~known[:, None]] = np.nan
    return ForcedSlip(velocity, slip, rms)
