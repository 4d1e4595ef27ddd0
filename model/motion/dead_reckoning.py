"""Dead reckoning: integrate a body velocity exactly along the arc it describes in the plane."""

import numpy as np

from model.values.arrays import FloatArray, readonly
from model.values.tick import DeadReckoning

SMALL_TURN_RAD = 1e-6


def advance(before: DeadReckoning, velocity_B: FloatArray, t_ns: int) -> DeadReckoning:  # noqa: N803
    """Carry a planar pose forward with a constant body velocity (the exponential map of SE(2)).

    Args:
        before: Pose to start from.
        velocity_B: vx, vy [m/s] and yaw rate [rad/s] in body axes, (3,); NaN while unknown.
        t_ns: Time to carry it to.

    Returns:
        The pose at ``t_ns``. While the velocity is unknown the pose stands still, ``valid`` False.
    """
    if not np.isfinite(velocity_B).all():
        nan = readonly(np.full(3, np.nan))
        return DeadReckoning(t_ns, before.position_m, before.yaw_rad, nan, valid=False)
    dt = (t_ns - before.t_ns) * 1e-9  # [s]
    vx, vy, rate = velocity_B.tolist()
    turn = rate * dt  # [rad]
    # sin(a)/a and (1 - cos(a))/a
    if abs(turn) > SMALL_TURN_RAD:
        ahead, aside = float(np.sin(turn)) / turn, (1 - float(np.cos(turn))) / turn
    else:
        ahead, aside = 1 - turn**2 / 6, turn / 2
    x, y = vx * dt, vy * dt
    dx, dy = ahead * x - aside * y, aside * x + ahead * y
    c, s = float(np.cos(before.yaw_rad)), float(np.sin(before.yaw_rad))
    px, py = before.position_m.tolist()
    position = np.array([px + (c * dx - s * dy), py + (s * dx + c * dy)])
    return DeadReckoning(
        t_ns, readonly(position), before.yaw_rad + turn, readonly(velocity_B.copy()), valid=True
    )
