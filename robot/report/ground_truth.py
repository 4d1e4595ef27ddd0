"""What a log knows of the true motion, for every command alike: motion capture's or the plant's pose.

A pose alone is ground truth. Velocities that were not recorded with it are its slope.
"""

import numpy as np

from model.motion.differentiate import centred_rate
from model.motion.se2 import aligning, compose, turned, yaw_of
from model.values.arrays import BoolArray, FloatArray
from record.log.recording import Recording

# Poses on either side that give the true velocity [s]: at 100 Hz, 1 mm of noise becomes 10 mm/s.
HALF_WINDOW_S = 0.05


def unwrap_known(yaw: FloatArray) -> FloatArray:
    """Return a copy of angles without jumps of a turn; NaN stays."""
    yaw = yaw.copy()
    known = np.isfinite(yaw)
    yaw[known] = np.unwrap(yaw[known])
    return yaw


def true_pose(log: Recording) -> FloatArray:
    """Return true x, y [m] and yaw [rad, unwrapped], (T, 3); NaN where it is not known."""
    yaw = unwrap_known(yaw_of(log.truth_quaternion_xyzw))
    return np.column_stack([log.truth_position_W[:, :2], yaw])


def aligned_to_truth(log: Recording, own: FloatArray) -> FloatArray:
    """Return poses begun where the truth begins, so that both can be compared; (T, 3)."""
    known = np.flatnonzero(np.isfinite(log.truth_position_W[:, 0]))
    if len(known) == 0:
        return own
    return compose(aligning(true_pose(log)[known[0]], own[known[0]]), own)


def true_velocity(log: Recording) -> FloatArray:
    """Return true vx, vy [m/s], yaw rate [rad/s] in body axes, (T, 3): as recorded, or of the poses."""
    recorded = log.truth_velocity_B
    pose = true_pose(log)
    wanted: BoolArray = np.asarray(np.isfinite(pose).all(axis=1) & np.isnan(recorded).any(axis=1))
    if not wanted.any():
        return recorded
    t_ns = np.round(log.t_s * 1e9).astype(np.int64)
    # in a log that was thinned for pictures, and of slow cameras, samples lie farther apart
    apart_s = float(np.median(np.diff(log.t_s[wanted]))) if wanted.sum() > 1 else 0.0
    rate = centred_rate(t_ns, pose, round(max(HALF_WINDOW_S, 1.5 * apart_s) * 1e9))
    own = np.column_stack([*turned(rate[:, 0], rate[:, 1], -pose[:, 2]), rate[:, 2]])
    return np.where(wanted[:, None], own, recorded)


def true_slip(log: Recording) -> FloatArray:
    """Return the true velocity of the feet over the ground in the body's heading, (T, N, 2) [m/s]."""
    yaw = yaw_of(log.truth_quaternion_xyzw)[:, None]
    x, y = log.truth_foot_velocity_W[..., 0], log.truth_foot_velocity_W[..., 1]
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def true_forward_slip(log: Recording) -> FloatArray:
    """Return the true forward slip of loaded feet, (T, N) [m/s]; NaN in the air."""
    return np.where(log.truth_contact, true_slip(log)[..., 0], np.nan)
