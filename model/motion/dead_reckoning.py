"""Dead reckoning: integrate a body velocity exactly along the arc it describes in the plane."""

from math import isfinite

import numpy as np

from model.motion.se2 import arc, turned
from model.values.arrays import FloatArray, readonly
from model.values.tick import DeadReckoning


def advance(before: DeadReckoning, velocity_B: FloatArray, t_ns: int) -> DeadReckoning:  # noqa: N803
    """Carry a planar pose forward with a constant body velocity.

    Args:
        before: Pose to start from.
        velocity_B: vx, vy [m/s] and yaw rate [rad/s] in body axes, (3,); NaN while unknown.
        t_ns: Time to carry it to.

    Returns:
        The pose at ``t_ns``. While the velocity is unknown the pose stands still, ``valid`` False.
    """
    vx, vy, rate = velocity_B.tolist()
    if not isfinite(vx + vy + rate):
        nan = readonly(np.full(3, np.nan))
        return DeadReckoning(t_ns, before.position_m, before.yaw_rad, nan, valid=False)
    dt_s = (t_ns - before.t_ns) * 1e-9
    dx, dy = turned(*arc(vx * dt_s, vy * dt_s, rate * dt_s), before.yaw_rad)
    x, y = before.position_m.tolist()
    position, yaw_rad = readonly(np.array([x + dx, y + dy])), before.yaw_rad + rate * dt_s
    return DeadReckoning(t_ns, position, yaw_rad, readonly(velocity_B.copy()), valid=True)
