"""Planar motion: the exponential of a body velocity, and whole trajectories from many of them.

A pose is (x, y, yaw), x and y in metres, yaw in radians. A trajectory is a prefix product. The paper makes
it one after the other and points to a parallel scan; in the plane it is two running sums.
"""

from typing import TypeVar

import numpy as np

from model.errors import ModelError
from model.values.arrays import FloatArray

Number = TypeVar("Number", float, FloatArray)


def sinc(angle: Number) -> Number:
    """sin(a) / a, and 1 at 0."""
    if isinstance(angle, float):  # of a tick: the same bits, without arithmetic on numpy's scalars
        return float(np.sin(angle)) / angle if angle != 0.0 else 1.0
    zero = angle == 0.0
    value: Number = (np.sin(angle) + zero) / (angle + zero)
    return value


def turned(x: Number, y: Number, angle: Number) -> tuple[Number, Number]:
    """Components of a vector turned by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    if isinstance(angle, float):
        c, s = float(c), float(s)
    return c * x - s * y, s * x + c * y


def arc(x: Number, y: Number, turn: Number) -> tuple[Number, Number]:
    """End of an arc seen from its beginning, x and y.

    Its chord is sinc(turn / 2) of its length, and points half the turn aside.

    Args:
        x: Length along the first axis [m].
        y: Along the second [m].
        turn: Angle turned on the way [rad].
    """
    half = 0.5 * turn
    chord = sinc(half)
    return turned(chord * x, chord * y, half)


def exponential(twist: FloatArray) -> FloatArray:
    """Displacement of a body that moves with a constant body velocity, exactly along its arc.

    Args:
        twist: Body velocity times duration: x, y [m], turn [rad], (..., 3).

    Returns:
        Pose after it, seen from the pose before, (..., 3).
    """
    pose = twist.copy()
    pose[..., 0], pose[..., 1] = arc(twist[..., 0], twist[..., 1], twist[..., 2])
    return pose


def compose(first: FloatArray, then: FloatArray) -> FloatArray:
    """Pose ``then``, given in the frame of pose ``first``, in the frame of ``first``'s parent.

    Args:
        first: (..., 3).
        then: (..., 3).

    Returns:
        (..., 3), yaw unwrapped.
    """
    pose = first + then
    x, y = turned(then[..., 0], then[..., 1], first[..., 2])
    pose[..., 0], pose[..., 1] = first[..., 0] + x, first[..., 1] + y
    return pose


def inverse(pose: FloatArray) -> FloatArray:
    """The parent's frame seen from a pose.

    Args:
        pose: (..., 3).

    Returns:
        (..., 3).
    """
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = pose[..., 0], pose[..., 1]
    return np.stack([-c * x - s * y, s * x - c * y, -pose[..., 2]], axis=-1)


def seen_from(pose: FloatArray, other: FloatArray) -> FloatArray:
    """Pose ``other`` in the frame of ``pose``, both given in one parent's; (..., 3) each."""
    return compose(inverse(pose), other)


def aligning(there: FloatArray, here: FloatArray) -> FloatArray:
    """The frame in which pose ``here`` is, seen from its parent, pose ``there``; (..., 3) each."""
    return compose(there, inverse(here))


def placed(pose: FloatArray, points_B: FloatArray) -> FloatArray:  # noqa: N803 - frame suffix
    """Points of a body, (..., 2), at its pose, (..., 3), in the frame of the pose."""
    x, y = turned(points_B[..., 0], points_B[..., 1], pose[..., 2])
    return np.stack([pose[..., 0] + x, pose[..., 1] + y], axis=-1)


def yaw_of(quaternion_xyzw: FloatArray) -> FloatArray:
    """Yaw of attitudes.

    Args:
        quaternion_xyzw: (..., 4). Where x and y are NaN only the yaw is known, and z and w are those of a
            turn about z.

    Returns:
        From -pi to pi, (...,) [rad]; NaN where it is not known.
    """
    x, y, z, w = np.moveaxis(quaternion_xyzw, -1, 0)
    level = np.isnan(x) & np.isnan(y)
    x, y = np.where(level, 0.0, x), np.where(level, 0.0, y)
    yaw: FloatArray = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return yaw


def heading_quaternion(yaw_rad: float) -> FloatArray:
    """Attitude of which only the yaw is known, (4,): x and y are NaN; ``yaw_of`` returns it."""
    return np.array([np.nan, np.nan, np.sin(yaw_rad / 2), np.cos(yaw_rad / 2)])


def quaternion_of(yaw_rad: float | FloatArray) -> FloatArray:
    """Rotations about z as quaternions x y z w, (..., 4), of yaws, (...,) [rad]."""
    half = np.asarray(yaw_rad) / 2
    quaternion = np.zeros((*half.shape, 4))
    quaternion[..., 2], quaternion[..., 3] = np.sin(half), np.cos(half)
    return quaternion


def products(steps: FloatArray, start: FloatArray | None = None) -> FloatArray:
    """All prefix products of poses, as two running sums.

    Turns add up; so do displacements, each turned by all turns before it.

    Args:
        steps: Displacements, (F, 3).
        start: Pose that all of them are composed with, (3,); the origin if None.

    Returns:
        (F + 1, 3): the start, and its composition with steps 0 to i.
    """
    poses = np.zeros((len(steps) + 1, 3))
    if start is not None:
        poses[0] = start
    poses[1:] = steps
    poses[:, 2] = np.cumsum(poses[:, 2])
    poses[1:, 0], poses[1:, 1] = turned(steps[:, 0], steps[:, 1], poses[:-1, 2])
    poses[:, :2] = np.cumsum(poses[:, :2], axis=0)
    return poses


def integrate(
    velocity_B: FloatArray,  # noqa: N803
    period_s: float | FloatArray,
    start: FloatArray | None = None,
) -> FloatArray:
    """Trajectory of a body with these body velocities, each held for a period.

    Args:
        velocity_B: vx, vy [m/s], yaw rate [rad/s], (F, 3).
        period_s: Duration of each, a number or (F,) [s].
        start: Pose at the beginning, (3,); the origin if None.

    Returns:
        Poses x, y [m], yaw [rad] at the beginning and after each period, (F + 1, 3). From the first
        velocity that is not a number on, poses are NaN.

    Raises:
        ModelError: Shapes do not fit.
    """
    if velocity_B.ndim != 2 or velocity_B.shape[1] != 3:
        raise ModelError(f"velocities must be (frames, 3), not {velocity_B.shape}")
    periods = np.asarray(period_s, dtype=np.float64)
    if periods.shape not in {(), (len(velocity_B),)}:
        raise ModelError(f"periods must be one or {len(velocity_B)} numbers, not {periods.shape}")
    return products(exponential(velocity_B * periods[..., None]), start)
