"""How far a dead-reckoned trajectory is from the truth: the figures of merit of legged odometry."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

from model.motion.se2 import seen_from
from model.values.arrays import FloatArray, root_mean_square

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
    """Length of the path up to each pose, (T,) [m]."""
    steps = np.hypot(*np.diff(pose[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def relative_error(pose: FloatArray, truth: FloatArray, length_m: float) -> float:
    """Mean error of where a piece of path ends seen from where it begins, over its length [%].

    All pieces whose true length is ``length_m``, from every tick; those that end beyond the log are
    left out. Poses are x, y [m], yaw [rad], (T, 3).
    """
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
    """Judge a motion that begins at the true pose."""
    length = float(path_length(truth.pose)[-1])
    last = path.pose[-1] - truth.pose[-1]
    return TrackErrors(
        name=path.name,
        rpe_percent=np.array([relative_error(path.pose, truth.pose, d) for d in LENGTHS_M]),
        end_percent=float(100 * np.hypot(last[0], last[1]) / length) if length > 0 else np.nan,
        yaw_deg_m=float(np.degrees(last[2]) / length) if length > 0 else np.nan,
        velocity_rmse=root_mean_square(path.velocity_B - truth.velocity_B),
        force_rmse_n=root_mean_square(path.force_B - truth.force_B),
    )


def nees(error: FloatArray, covariance: FloatArray) -> FloatArray:
    """Normalised estimation error squared of each tick, (T,); its mean should be the dimension.

    Args:
        error: (T, d).
        covariance: (T, d, d); where it is not positive definite the result is NaN.
    """
    sound = np.linalg.eigvalsh(covariance)[:, 0] > 0
    solved = np.linalg.solve(covariance[sound], error[sound, :, None])[..., 0]
    squared = np.full(len(error), np.nan)
    squared[sound] = np.einsum("ti,ti->t", error[sound], solved)
    return squared


def in_band(values: FloatArray, freedom: float, runs: int = 1) -> float:
    """Share of values (means over ``runs`` runs) in the 95 % band of chi-squared."""
    low, high = (float(chi2.ppf(share, freedom * runs)) / runs for share in (0.025, 0.975))
    known = values[np.isfinite(values)]
    return float(((known >= low) & (known <= high)).mean()) if len(known) else np.nan
