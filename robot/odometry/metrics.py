"""How far a dead-reckoned trajectory is from the truth: the figures of merit of legged odometry."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import special

from model.motion.se2 import seen_from, turned
from model.values.arrays import FloatArray, IntArray, root_mean_square

LENGTHS_M = (0.25, 0.5, 1.0)


class Motion(NamedTuple):
    """A motion over T ticks, that of a method of dead reckoning or the true one; NaN where unknown.

    Pose x, y [m], yaw [rad], (T, 3); body velocity vx, vy [m/s], yaw rate [rad/s], (T, 3); foot forces,
    (T, N, 3) [N].
    """

    name: str
    pose: FloatArray
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    force_B: FloatArray  # noqa: N815


@dataclass(frozen=True, slots=True, eq=False)
class TrackErrors:
    """Errors of one method of dead reckoning against the truth; NaN where it is unknown.

    Attributes:
        name: Of the method.
        rpe_percent: Mean relative pose error over path lengths ``LENGTHS_M``, (3,) [% of length].
        end_percent: Distance between the ends over the path's length [%].
        yaw_deg_m: Error of the yaw at the end over the path's length [deg/m].
        velocity_rmse: Of vx, vy [m/s], yaw rate [rad/s], (3,).
        force_rmse_n: Of each foot's force, (N, 3) [N], over ticks where it is known.
    """

    name: str
    rpe_percent: FloatArray
    end_percent: float
    yaw_deg_m: float
    velocity_rmse: FloatArray
    force_rmse_n: FloatArray


def path_length(pose: FloatArray) -> FloatArray:
    """Length of the path up to each pose, (T,) [m]; across poses that are not known it is straight."""
    along = np.zeros(len(pose))
    known = np.flatnonzero(np.isfinite(pose[:, :2]).all(axis=1))
    steps = np.hypot(*np.diff(pose[known, :2], axis=0).T)
    along[known[1:]] = steps
    return np.cumsum(along)


def relative_error(pose: FloatArray, truth: FloatArray, length_m: float) -> float:
    """Mean error of where a piece of path ends seen from where it begins, over its length [%].

    All pieces whose true length is ``length_m``, from every tick; those that end beyond the log are
    left out. Poses are x, y [m], yaw [rad], (T, 3); a piece of which an end is not known is left out.
    """
    known = np.isfinite(truth).all(axis=1)
    pose, truth = pose[known], truth[known]
    along = path_length(truth)
    ends = np.searchsorted(along, along + length_m)
    begins = np.flatnonzero(ends < len(truth))
    ends = ends[begins]
    if not len(begins):
        return np.nan
    error = (
        seen_from(pose[begins], pose[ends])[:, :2] - seen_from(truth[begins], truth[ends])[:, :2]
    )
    return float(100 * np.hypot(*error.T).mean() / length_m)


def track_errors(path: Motion, truth: Motion) -> TrackErrors:
    """Judge a motion that begins at the true pose.

    Where the true yaw is not known at all, the truth is turned about its beginning until it fits the path
    best; errors that need a heading are then NaN.
    """
    known = np.flatnonzero(np.isfinite(truth.pose[:, :2]).all(axis=1))
    if not np.isfinite(truth.pose[:, 2]).any():
        truth = truth._replace(pose=turned_to_fit(truth.pose, path.pose))
    length = float(path_length(truth.pose)[-1])
    last = path.pose[known[-1]] - truth.pose[known[-1]] if len(known) else np.full(3, np.nan)
    return TrackErrors(
        name=path.name,
        rpe_percent=np.array([relative_error(path.pose, truth.pose, d) for d in LENGTHS_M]),
        end_percent=float(100 * np.hypot(last[0], last[1]) / length) if length > 0 else np.nan,
        yaw_deg_m=float(np.degrees(last[2]) / length) if length > 0 else np.nan,
        velocity_rmse=root_mean_square(path.velocity_B - truth.velocity_B),
        force_rmse_n=root_mean_square(path.force_B - truth.force_B),
    )


def turned_to_fit(truth: FloatArray, path: FloatArray) -> FloatArray:
    """Turn places about the first known one so that they lie as near as possible to those of a path.

    Poses are x, y [m], yaw [rad], (T, 3); the turn is that of Procrustes' problem in the plane.
    """
    known = np.flatnonzero(np.isfinite(truth[:, :2]).all(axis=1))
    if not len(known):
        return truth
    start = known[0]
    (x, y), (u, v) = ((pose[known] - pose[start])[:, :2].T for pose in (truth, path))
    angle = float(np.arctan2(np.sum(x * v - y * u), np.sum(x * u + y * v)))
    fitted = truth.copy()
    dx, dy = turned(truth[:, 0] - truth[start, 0], truth[:, 1] - truth[start, 1], angle)
    fitted[:, 0], fitted[:, 1] = path[start, 0] + dx, path[start, 1] + dy
    return fitted


def nees(error: FloatArray, covariance: FloatArray) -> FloatArray:
    """Normalised estimation error squared of each tick, (T,); its mean should be the dimension.

    Args:
        error: (T, d).
        covariance: (T, d, d); where it is not positive definite, or an error not known, the result is NaN.
    """
    sound = np.linalg.eigvalsh(covariance)[:, 0] > 0
    sound &= np.isfinite(error).all(axis=1)
    solved = np.linalg.solve(covariance[sound], error[sound, :, None])[..., 0]
    squared = np.full(len(error), np.nan)
    squared[sound] = np.einsum("ti,ti->t", error[sound], solved)
    return squared


def chi_squared_quantile(share: float, freedom: FloatArray | IntArray | float) -> FloatArray:
    """Value below which a share of chi-squared lies; ``scipy.stats`` takes half a second to load."""
    return np.asarray(2.0 * special.gammaincinv(0.5 * freedom, share))


def in_band(values: FloatArray, freedom: float, runs: int = 1) -> float:
    """Share of values (means over ``runs`` runs) in the 95 % band of chi-squared."""
    low, high = (
        float(chi_squared_quantile(share, freedom * runs)) / runs for share in (0.025, 0.975)
    )
    known = values[np.isfinite(values)]
    return float(((known >= low) & (known <= high)).mean()) if len(known) else np.nan
