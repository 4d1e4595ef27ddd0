"""Coulomb's law the paper's way, kept to compare with: a root search on a smoothed law.

The law is H = -mu N (eps + v) / (eps + v^2) (eqn:h2), smooth for eps > 0 and Coulomb's for eps -> 0. The
search begins at eps = 1e-5 and each answer starts the next, ten times sharper, until two answers in a row
differ by less than a thousandth. It can fail to converge (the paper: 0.12 % of frames), and says so.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import root

from model.values.arrays import FloatArray, readonly

FIRST_EPSILON = 1e-5
SHARPER = 0.1  # the paper does not state its factor
ENOUGH = 1e-3  # relative change of the body velocity between two answers
SEARCHES = 12


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceSolution:
    """Answer of the paper's method for one frame.

    Attributes:
        converged: Whether every root search succeeded and the answers settled.
        velocity_B: vx, vy [m/s], yaw rate [rad/s], (3,); the last answer, whatever it is worth.
        imbalance: Largest of force [N] and moment over arm [N] that is left, over the sum of mu N.
        searches: Root searches made.
    """

    converged: bool
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    imbalance: float
    searches: int


def solve_coulomb_reference(
    feet_xy_B: FloatArray,  # noqa: N803
    speed_xy_B: FloatArray,  # noqa: N803
    load_n: FloatArray,
    mu: FloatArray,
    start: FloatArray,
) -> ReferenceSolution:
    """Balance by scipy's Levenberg-Marquardt root search with continuation in eps.

    Args:
        feet_xy_B: (N, 2) [m].
        speed_xy_B: Foot velocities in the body, (N, 2) [m/s].
        load_n: (N,) [N].
        mu: (N,).
        start: Velocity to start from: that of the frame before, (3,).
    """
    arm = max(float(np.sqrt((feet_xy_B**2).sum(axis=1).mean())), 1e-9)  # [m]
    limit = mu * load_n
    limit = limit / limit.sum()

    def imbalance(velocity: FloatArray, epsilon: float) -> FloatArray:
        slip_x = velocity[0] - velocity[2] * feet_xy_B[:, 1] + speed_xy_B[:, 0]
        slip_y = velocity[1] + velocity[2] * feet_xy_B[:, 0] + speed_xy_B[:, 1]
        v = np.hypot(slip_x, slip_y)
        drag = -limit * (epsilon + v) / (epsilon + v**2)
        force_x, force_y = drag * slip_x, drag * slip_y
        moment = (feet_xy_B[:, 0] * force_y - feet_xy_B[:, 1] * force_x) / arm
        return np.array([force_x.sum(), force_y.sum(), moment.sum()])

    epsilon, before, searches = FIRST_EPSILON, np.asarray(start, dtype=np.float64), 0
    settled = fine = False
    while searches < SEARCHES:
        found = root(imbalance, before, args=(epsilon,), method="lm")
        searches += 1
        fine = bool(found.success) and float(np.abs(found.fun).max()) < 1e-6
        change = float(np.linalg.norm(found.x - before))
        settled = searches > 1 and change < ENOUGH * float(np.linalg.norm(found.x))
        before = found.x
        if settled or not fine:
            break
        epsilon *= SHARPER
    return ReferenceSolution(
        converged=fine and settled,
        velocity_B=readonly(np.array(before)),
        imbalance=float(np.abs(imbalance(before, epsilon)).max()),
        searches=searches,
    )
