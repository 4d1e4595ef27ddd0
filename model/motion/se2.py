"""Planar motion: the exponential of a body velocity, and whole trajectories from many of them.

A pose is (x, y, yaw). Poses compose associatively, so a trajectory is a prefix product: one after the
other, or as a scan in which the number of rounds is the logarithm of the length (the paper claims the
second and runs the first).
"""

import numpy as np

from model.errors import ModelError
from model.values.arrays import FloatArray

# Below this turn the series of sin(a)/a and (1 - cos(a))/a is exact to rounding.
SMALL_TURN_RAD = 1e-4


def exponential(twist: FloatArray) -> FloatArray:
    """Displacement of a body that moves with a constant body velocity, exactly along its arc.

    Args:
        twist: Body velocity times duration: x, y [m], turn [rad], (..., 3).

    Returns:
        Pose after it, seen from the pose before, (..., 3).
    """
    turn = twist[..., 2]
    small = np.abs(turn) < SMALL_TURN_RAD
    safe = np.where(small, 1.0, turn)
    ahead = np.where(small, 1.0 - turn**2 / 6.0, np.sin(safe) / safe)
    # (1 - cos a) / a without the loss of digits of 1 - cos a
    aside = np.where(small, turn / 2.0 - turn**3 / 24.0, 2.0 * np.sin(safe / 2.0) ** 2 / safe)
    x, y = twist[..., 0], twist[..., 1]
    return np.stack([ahead * x - aside * y, aside * x + ahead * y, turn], axis=-1)


def compose(first: FloatArray, then: FloatArray) -> FloatArray:
    """Pose ``then``, given in the frame of pose ``first``, in the frame of ``first``'s parent.

    Args:
        first: (..., 3).
        then: (..., 3).

    Returns:
        (..., 3), yaw unwrapped.
    """
    c, s = np.cos(first[..., 2]), np.sin(first[..., 2])
    x, y = then[..., 0], then[..., 1]
    return np.stack(
        [
            first[..., 0] + c * x - s * y,
            first[..., 1] + s * x + c * y,
            first[..., 2] + then[..., 2],
        ],
        axis=-1,
    )


def seen_from(pose: FloatArray, other: FloatArray) -> FloatArray:
    """Pose ``other`` in the frame of ``pose``, both given in the same frame.

    Args:
        pose: (..., 3).
        other: (..., 3).

    Returns:
        (..., 3).
    """
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    x, y = other[..., 0] - pose[..., 0], other[..., 1] - pose[..., 1]
    return np.stack([c * x + s * y, c * y - s * x, other[..., 2] - pose[..., 2]], axis=-1)


def scan(steps: FloatArray) -> FloatArray:
    """All prefix products of poses in a logarithmic number of vectorised rounds.

    Work-efficient: pairs are composed, the half-length problem is solved the same way, and the places
    in between are filled in; 2 log2 F rounds, 2 F compositions.

    Args:
        steps: Displacements, (F, 3).

    Returns:
        (F, 3): row i is the composition of steps 0 to i.
    """
    count = len(steps)
    if count < 2:
        return steps.copy()
    pairs = compose(steps[0 : count - 1 : 2], steps[1::2])
    even = scan(pairs)
    out = np.empty_like(steps)
    out[0] = steps[0]
    out[1::2] = even
    inner = steps[2::2]
    out[2::2] = compose(even[: len(inner)], inner)
    return out


def product(steps: FloatArray) -> FloatArray:
    """The same as ``scan``, one after the other.

    Args:
        steps: (F, 3).

    Returns:
        (F, 3).
    """
    out = np.empty_like(steps)
    pose = np.zeros(3)
    for i, step in enumerate(steps):
        pose = compose(pose, step)
        out[i] = pose
    return out


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
    steps = exponential(velocity_B * periods[..., None])
    origin = np.zeros(3) if start is None else np.asarray(start, dtype=np.float64)
    return compose(origin, np.concatenate([np.zeros((1, 3)), scan(steps)]))
