"""Dead reckoning: integrate a body velocity exactly along the arc it describes in the plane."""

from math import isfinite

import numpy as np

from model.motion.se2 import arc, turned
from model.values.arrays import FloatArray, IntArray, readonly
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


def advance_rows(
    before: DeadReckoning,
    velocity_B: FloatArray,  # noqa: N803
    t_ns: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """Carry a planar pose forward over ticks in a row, all with a known velocity: as ``advance``.

    Args:
        before: Pose to start from.
        velocity_B: Of each tick, (T, 3).
        t_ns: Times of the ticks, (T,).

    Returns:
        Positions, (T, 2) [m], and yaws, (T,) [rad].
    """
    dt_s = np.diff(t_ns, prepend=before.t_ns) * 1e-9
    vx, vy, rate = velocity_B.T
    turn = rate * dt_s
    yaw_rad = np.add.accumulate([before.yaw_rad, *turn.tolist()])
    dx, dy = turned(*arc(vx * dt_s, vy * dt_s, turn), yaw_rad[:-1])
    x, y = before.position_m.tolist()
    places = np.add.accumulate([x, *dx.tolist()])[1:], np.add.accumulate([y, *dy.tolist()])[1:]
    return readonly(np.column_stack(places)), readonly(yaw_rad[1:])
