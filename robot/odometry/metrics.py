"""How far a dead-reckoned trajectory is from the truth: the figures of merit of legged odometry."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from model.motion.se2 import seen_from
from model.values.arrays import FloatArray, root_mean_square

LENGTHS_M = (0.25, 0.5, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class TrackErrors:
    """Errors of one way of dead reckoning against the truth; NaN where it cannot be told.

    Attributes:
        name: Of the way.
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
    left out.

    Args:
        pose: x, y, yaw, (T, 3).
        truth: The same.
        length_m: Length of the pieces.
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


def track_errors(
    name: str,
    pose: FloatArray,
    velocity: FloatArray,
    force: FloatArray,
    truth: tuple[FloatArray, FloatArray, FloatArray],
) -> TrackErrors:
    """Judge a trajectory that begins at the true pose.

    Args:
        name: Of the way of dead reckoning.
        pose: (T, 3).
        velocity: Body velocity, (T, 3); NaN where unknown.
        force: Predicted forces, (T, N, 3); NaN where there are none.
        truth: The same of the truth.
    """
    true_pose, true_velocity, true_force = truth
    length = float(path_length(true_pose)[-1])
    last = pose[-1] - true_pose[-1]
    return TrackErrors(
        name=name,
        rpe_percent=np.array([relative_error(pose, true_pose, d) for d in LENGTHS_M]),
        end_percent=float(100 * np.hypot(last[0], last[1]) / length) if length > 0 else np.nan,
        yaw_deg_m=float(np.degrees(last[2]) / length) if length > 0 else np.nan,
        velocity_rmse=root_mean_square(velocity - true_velocity),
        force_rmse_n=root_mean_square(force - true_force),
    )


def nees(error: FloatArray, covariance: FloatArray) -> FloatArray:
    """Normalised estimation error squared of each tick, (T,); its mean should be the dimension.

    Args:
        error: (T, d).
        covariance: (T, d, d); where it is not positive definite the result is NaN.
    """
    sound = np.linalg.eigvalsh(covariance)[:, 0] > 0
    solved = np.linalg.solve(covariance[sound], error[sound, :, None])[..., 0]
    found = np.full(len(error), np.nan)
    found[sound] = np.einsum("ti,ti->t", error[sound], solved)
    return found


def in_band(values: FloatArray, freedom: float, runs: int = 1) -> float:
    """Share of values (means over ``runs`` runs) in the 95 % band of chi-squared."""
    low, high = (float(chi2.ppf(share, freedom * runs)) / runs for share in (0.025, 0.975))
    known = values[np.isfinite(values)]
    return float(((known >= low) & (known <= high)).mean()) if len(known) else np.nan
