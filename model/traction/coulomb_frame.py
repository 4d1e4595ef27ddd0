"""One frame under Coulomb's law, from feet and loads to velocity and forces, compiled.

Scales the problem (slips by their size, lengths by the feet's spread, forces by the sum of mu N), tries
the feet that rested in the frame before, and otherwise minimises the dissipation from scratch.
"""

import numpy as np

from model.compiled import compiled
from model.support.kernel import DRAG, SPEED_X, SPEED_Y, W_X, W_Y, X, Y
from model.traction.coulomb_kernel import descend
from model.traction.coulomb_polish import (
    NOT_SOLVED,
    SOLVED_FLAT,
    classify,
    forces_unique,
    polish,
)
from model.traction.kernel import FINE, traction_kernel
from model.values.arrays import BoolArray, FloatArray

NO_CONVERGENCE = 4
REST = 1e-13  # slip over foot speed that is rounding
LOOSE = 1e-9  # gap at which an unpolished answer is still taken for one


@compiled
def coulomb_frame(
    work: FloatArray,
    loads: FloatArray,
    mu: FloatArray,
    warm: bool,
    velocity: FloatArray,
    slip: FloatArray,
    force: FloatArray,
    sticking: BoolArray,
) -> tuple[int, bool]:
    """Balance of one frame.

    Args:
        work: As in ``traction_kernel``. The law is F = -mu N L (L slip) / |L slip|, L = I + w w^T,
            which has the paper's traction along and across w and, unlike its formula, is the
            gradient of a power.
        loads: (N,) [N].
        mu: (N,).
        warm: Whether ``velocity`` and ``sticking`` hold the frame before.
        velocity: Out: vx, vy [m/s], yaw rate [rad/s], (3,).
        slip: Out: (N, 2) [m/s], exactly 0 for feet at rest.
        force: Out: (N, 2) [N].
        sticking: Out: loaded feet at rest, (N,).

    Returns:
        A reason (0 is fine), and whether velocity and forces are the only ones that balance.
    """
    count = loads.size
    before0, before1, before2 = velocity[0], velocity[1], velocity[2]
    reason = traction_kernel(work, loads, mu, velocity, slip, force)
    if reason != FINE:
        for k in range(count):
            sticking[k] = False
        return reason, False
    total = 0.0
    cx, cy = 0.0, 0.0
    loaded = 0
    for k in range(count):
        c = work[DRAG, k]
        if c > 0:
            total += c
            cx += c * work[X, k]
            cy += c * work[Y, k]
            loaded += 1
    cx /= total
    cy /= total
    spread = 0.0
    top = 0.0
    fastest = 0.0
    for k in range(count):
        if work[DRAG, k] > 0:
            spread = max(spread, abs(work[X, k] - cx), abs(work[Y, k] - cy))
            top = max(top, abs(slip[k, 0]), abs(slip[k, 1]))
            fastest = max(fastest, abs(work[SPEED_X, k]), abs(work[SPEED_Y, k]))
    if top <= REST * fastest or top < 1e-150:  # all rest: any balanced forces will do, so none
        for k in range(count):
            force[k, 0] = force[k, 1] = 0.0
            sticking[k] = work[DRAG, k] > 0
            if sticking[k]:
                slip[k, 0] = slip[k, 1] = 0.0
        return FINE, False
    # few pieces of memory: each costs as much as a dozen sums
    levers = np.empty((loaded, 2, 3))
    room = np.zeros((5, loaded, 2))
    offset, dual, gone, way, trial = room[0], room[1], room[2], room[3], room[4]
    limit = np.empty(loaded)
    twist = np.zeros(3)
    rest = np.zeros(loaded, dtype=np.bool_)
    resting = 0
    i = 0
    for k in range(count):
        c = work[DRAG, k]
        if c <= 0:
            sticking[k] = False
            continue
        ax, ay = work[W_X, k], work[W_Y, k]
        gx, gy = -(work[Y, k] - cy) / spread, (work[X, k] - cx) / spread
        lxx, lxy, lyy = 1.0 + ax * ax, ax * ay, 1.0 + ay * ay
        levers[i, 0, 0], levers[i, 0, 1], levers[i, 0, 2] = lxx, lxy, lxx * gx + lxy * gy
        levers[i, 1, 0], levers[i, 1, 1], levers[i, 1, 2] = lxy, lyy, lxy * gx + lyy * gy
        offset[i, 0] = (lxx * slip[k, 0] + lxy * slip[k, 1]) / top
        offset[i, 1] = (lxy * slip[k, 0] + lyy * slip[k, 1]) / top
        limit[i] = c / total
        rest[i] = sticking[k]
        resting += sticking[k]
        i += 1
    # from the drag's centre and the viscous answer, in units of top and spread
    v0, v1, w = velocity[0], velocity[1], velocity[2]
    state = NOT_SOLVED
    for attempt in range(2):
        if attempt == 0:
            if not warm or not np.isfinite(before2):
                continue
            dw = before2 - w
            twist[0] = (before0 - v0 - dw * cy) / top
            twist[1] = (before1 - v1 + dw * cx) / top
            twist[2] = dw * spread / top
            gap = np.inf
        else:
            twist[0], twist[1], twist[2] = 0.0, 0.0, 0.0
            gap, _ = descend(levers, offset, limit, twist, dual, gone, way, trial)
            resting = classify(limit, dual, gone, rest)
        state = polish(levers, offset, limit, twist, dual, gone, rest, resting)
        if state != NOT_SOLVED:
            break
        if attempt == 1 and not gap <= LOOSE:
            for k in range(count):
                sticking[k] = False
            return NO_CONVERGENCE, False
    unique = state != SOLVED_FLAT and forces_unique(limit, dual, rest)
    rate = twist[2] * top / spread
    velocity[0] = v0 + twist[0] * top + rate * cy
    velocity[1] = v1 + twist[1] * top - rate * cx
    velocity[2] = w + rate
    i = 0
    for k in range(count):
        if work[DRAG, k] > 0:
            ax, ay = work[W_X, k], work[W_Y, k]
            along = ax * dual[i, 0] + ay * dual[i, 1]
            force[k, 0] = -total * (dual[i, 0] + ax * along)
            force[k, 1] = -total * (dual[i, 1] + ay * along)
            sticking[k] = rest[i]
            # back from L slip; the sum velocity + speed would lose the digits of a small slip
            along = (ax * gone[i, 0] + ay * gone[i, 1]) / (1.0 + ax * ax + ay * ay)
            slip[k, 0] = 0.0 if rest[i] else top * (gone[i, 0] - ax * along)
            slip[k, 1] = 0.0 if rest[i] else top * (gone[i, 1] - ay * along)
            i += 1
        else:
            force[k, 0] = force[k, 1] = 0.0
            slip[k, 0] = velocity[0] - velocity[2] * work[Y, k] + work[SPEED_X, k]
            slip[k, 1] = velocity[1] + velocity[2] * work[X, k] + work[SPEED_Y, k]
    return FINE, unique
