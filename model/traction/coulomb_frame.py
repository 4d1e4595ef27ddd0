"""One frame of feet with given loads: velocity and forces at which friction balances what acts on the body.

Scales the problem (slips by their size, lengths by the feet's spread, forces by the sum of mu N), tries
the feet that rested in the frame before, and otherwise minimises the dissipation from scratch.
"""

from typing import NamedTuple

import numpy as np

from model.compiled import compiled, in_place
from model.support.kernel import DRAG, SPEED_X, SPEED_Y, W_X, W_Y, X, Y
from model.traction.coulomb_kernel import (
    BODY_ROWS,
    COLUMNS,
    DUAL,
    GIVE,
    LEVER,
    LIMIT,
    OFFSET,
    PUSH,
    SLIP,
    SYSTEM_ROWS,
    TWIST,
    FootLaw,
    W,
    descend,
)
from model.traction.coulomb_polish import (
    NOT_SOLVED,
    SOLVED_FLAT,
    classify,
    forces_unique,
    polish,
)
from model.traction.kernel import CREEP_SPEED_M_S, FINE, coulomb_scale, traction_kernel
from model.values.arrays import BoolArray, FloatArray

NO_CONVERGENCE = 4
REST = 1e-13  # slip over foot speed that is rounding
LOOSE = 1e-9  # gap at which an unpolished answer is still taken for one


class BalanceSpace(NamedTuple):
    """Work space of ``balance_frame``: a piece of memory costs as much as a dozen sums, so it is kept.

    Attributes:
        feet: Table of feet, (N, COLUMNS).
        rest: Which of them rest, (N,).
        body: What else acts, (BODY_ROWS, 3).
        system: (SYSTEM_ROWS, 3).
        at: (1, 3).
    """

    feet: FloatArray
    rest: BoolArray
    body: FloatArray
    system: FloatArray
    at: FloatArray


@compiled
def balance_space(count: int) -> BalanceSpace:
    """Work space for N feet."""
    return BalanceSpace(
        np.empty((count, COLUMNS)), np.empty(count, dtype=np.bool_), np.empty((BODY_ROWS, 3)),
        np.empty((SYSTEM_ROWS, 3)), np.empty((1, 3)),
    )  # fmt: skip


@in_place
@compiled
def balance_frame(
    work: FloatArray, loads: FloatArray, mu: FloatArray, law: FootLaw, outside: FloatArray,
    elastic: FloatArray, warm: bool, velocity: FloatArray, slip: FloatArray, force: FloatArray,
    sticking: BoolArray, creep: bool, space: BalanceSpace,
) -> tuple[int, bool]:  # fmt: skip
    """Balance of one frame.

    Args:
        work: As in ``traction_kernel``. Coulomb's law is F = -mu N L (L slip) / |L slip|, L = I + w w^T,
            which has the paper's traction along and across w and, unlike its formula, is the
            gradient of a power.
        loads: (N,) [N].
        mu: (N,).
        law: How feet answer slip, in m/s.
        outside: What acts besides friction, body axes: force x, y [N], moment about z through the origin
            [N m], resistance to the body's velocity along the ground [N s/m] and about z [N m s], (5,);
            empty where nothing does.
        elastic: How far feet give along body x and y, over the time step [m/(N s)], their horizontal
            forces one time step ago [N], and forces from which the search starts [N], (N, 6); no rows:
            they do not give.
        warm: Whether ``velocity`` and ``sticking`` hold the frame before.
        velocity: Out: vx, vy [m/s], yaw rate [rad/s], (3,).
        slip: Out: (N, 2) [m/s], exactly 0 for feet at rest.
        force: Out: (N, 2) [N].
        sticking: Out: loaded feet at rest under the exact law, (N,).
        creep: Whether several feet at rest get the forces of feet that creep; else any that hold them,
            which are found sooner.
        space: Work space, of ``balance_space``.

    Returns:
        A reason (0 is fine), and whether velocity and forces are the only ones that balance.
    """
    count = loads.size
    before0, before1, before2 = velocity[0], velocity[1], velocity[2]
    warm = warm and np.isfinite(before2)
    reason = traction_kernel(work, loads, mu, velocity, slip, force)
    if reason != FINE:
        for k in range(count):
            sticking[k] = False
        return reason, False
    gives = elastic.shape[0] > 0
    exact = law.coulomb and law.rest == 0.0
    pushed = False
    for i in range(outside.size):
        pushed = pushed or outside[i] != 0.0
    total, cx, cy, loaded = 0.0, 0.0, 0.0, 0
    for k in range(count):
        c = work[DRAG, k]
        if c > 0:
            total += c
            cx += c * work[X, k]
            cy += c * work[Y, k]
            loaded += 1
    cx /= total
    cy /= total
    spread, top, fastest = 0.0, 0.0, 0.0
    for k in range(count):
        if work[DRAG, k] > 0:
            spread = max(spread, abs(work[X, k] - cx), abs(work[Y, k] - cy))
            top = max(top, abs(slip[k, 0]), abs(slip[k, 1]))
            fastest = max(fastest, abs(work[SPEED_X, k]), abs(work[SPEED_Y, k]))
    if pushed or not exact:
        top = max(top, CREEP_SPEED_M_S)
    elif top <= REST * fastest or top < 1e-150:  # all rest: any balanced forces will do, so none
        for k in range(count):
            force[k, 0] = force[k, 1] = 0.0
            sticking[k] = work[DRAG, k] > 0
            if sticking[k]:
                slip[k, 0] = slip[k, 1] = 0.0
        return FINE, False
    feet, rest, body, system, at = space
    feet, rest = feet[:loaded], rest[:loaded]
    for i in range(loaded):
        for j in range(COLUMNS):
            feet[i, j] = 0.0
    for i in range(BODY_ROWS):
        for j in range(3):
            body[i, j] = 0.0
    resting = 0
    i = 0
    for k in range(count):
        c = work[DRAG, k]
        if c <= 0:
            sticking[k] = False
            continue
        ax, ay = work[W_X, k], work[W_Y, k]
        gx, gy = -(work[Y, k] - cy) / spread, (work[X, k] - cx) / spread
        lxx, lxy, lyy = 1.0, 0.0, 1.0
        if law.coulomb:
            lxx, lxy, lyy = 1.0 + ax * ax, ax * ay, 1.0 + ay * ay
        sx, sy = slip[k, 0], slip[k, 1]
        if gives:
            px, py = elastic[k, 0], elastic[k, 1]
            sx -= px * elastic[k, 2]
            sy -= py * elastic[k, 3]
            px, py = px * total / top, py * total / top
            feet[i, GIVE] = lxx * px * lxx + lxy * py * lxy
            feet[i, GIVE + 1] = lxx * px * lxy + lxy * py * lyy
            feet[i, GIVE + 2] = lxy * px * lxy + lyy * py * lyy
            if warm and law.coulomb:
                # a foot that gives answers much as it did a moment ago
                fx, fy = -elastic[k, 4] / total, -elastic[k, 5] / total
                along = (ax * fx + ay * fy) / (1.0 + ax * ax + ay * ay)
                fx, fy = fx - ax * along, fy - ay * along
                least = min(1.0, c / total / max(np.sqrt(fx * fx + fy * fy), 1e-300))
                feet[i, DUAL], feet[i, DUAL + 1] = least * fx, least * fy
        feet[i, LEVER], feet[i, LEVER + 1], feet[i, LEVER + 2] = lxx, lxy, lxx * gx + lxy * gy
        feet[i, LEVER + 3], feet[i, LEVER + 4], feet[i, LEVER + 5] = lxy, lyy, lxy * gx + lyy * gy
        feet[i, OFFSET] = (lxx * sx + lxy * sy) / top
        feet[i, OFFSET + 1] = (lxy * sx + lyy * sy) / top
        feet[i, LIMIT], feet[i, W], feet[i, W + 1] = c / total, ax, ay
        rest[i] = sticking[k]
        resting += sticking[k]
        i += 1
    # from the drag's centre and the viscous answer, in units of top and spread
    v0, v1, turn = velocity[0], velocity[1], velocity[2]
    if pushed:
        _lay_body(outside, velocity, cx / spread, cy / spread, spread, top, total, body)
    state = NOT_SOLVED
    if warm:
        dw = before2 - turn
        body[TWIST, 0] = (before0 - v0 - dw * cy) / top
        body[TWIST, 1] = (before1 - v1 + dw * cx) / top
        body[TWIST, 2] = dw * spread / top
        if exact:
            state = polish(feet, body, rest, resting, creep, system, at)
    if state == NOT_SOLVED:
        if exact or not warm:
            body[TWIST, 0] = body[TWIST, 1] = body[TWIST, 2] = 0.0
        for i in range(loaded if exact else 0):  # what polishing left there
            feet[i, DUAL] = feet[i, DUAL + 1] = 0.0
        start = 0.0 if warm and law.rest > 0.0 else np.inf
        if not law.coulomb:
            sigma = coulomb_scale(slip, force, CREEP_SPEED_M_S)
            # feet that move as one rigid body slip only once something pushes them
            start = (sigma if sigma > 0.0 else 1.0 / CREEP_SPEED_M_S) * top
        scaled = FootLaw(
            law.coulomb, law.rest / top, law.static_ratio, law.static_speed / top, law.creep / top
        )
        gap, _ = descend(feet, body, scaled, gives, start, system)
        if exact:
            resting = classify(feet, rest)
            state = polish(feet, body, rest, resting, creep, system, at)
            if state == NOT_SOLVED and not gap <= LOOSE:
                for k in range(count):
                    sticking[k] = False
                return NO_CONVERGENCE, False
    rate = body[TWIST, 2] * top / spread
    velocity[0] = v0 + body[TWIST, 0] * top + rate * cy
    velocity[1] = v1 + body[TWIST, 1] * top - rate * cx
    velocity[2] = turn + rate
    i = 0
    for k in range(count):
        if work[DRAG, k] > 0:
            ax, ay = work[W_X, k], work[W_Y, k]
            y0, y1, z0, z1 = feet[i, DUAL], feet[i, DUAL + 1], feet[i, SLIP], feet[i, SLIP + 1]
            if law.coulomb:
                along = ax * y0 + ay * y1
                y0, y1 = y0 + ax * along, y1 + ay * along
                # back from L slip; the sum velocity + speed would lose the digits of a small slip
                along = (ax * z0 + ay * z1) / (1.0 + ax * ax + ay * ay)
                z0, z1 = z0 - ax * along, z1 - ay * along
            force[k, 0], force[k, 1] = -total * y0, -total * y1
            sticking[k] = exact and rest[i]
            slip[k, 0] = 0.0 if sticking[k] else top * z0
            slip[k, 1] = 0.0 if sticking[k] else top * z1
            i += 1
        else:
            force[k, 0] = force[k, 1] = 0.0
            slip[k, 0] = velocity[0] - velocity[2] * work[Y, k] + work[SPEED_X, k]
            slip[k, 1] = velocity[1] + velocity[2] * work[X, k] + work[SPEED_Y, k]
    return FINE, not exact or (state != SOLVED_FLAT and forces_unique(feet, rest))


@in_place
@compiled
def _lay_body(
    outside: FloatArray, velocity: FloatArray, gx: float, gy: float, spread: float, top: float,
    total: float, body: FloatArray,
) -> None:  # fmt: skip
    """What acts at a velocity and how it changes, about (gx, gy) in units of the spread."""
    along = outside[3] * top / total
    px = (outside[0] - outside[3] * velocity[0]) / total
    py = (outside[1] - outside[3] * velocity[1]) / total
    moment = (outside[2] - outside[4] * velocity[2]) / (total * spread)
    body[PUSH, 0], body[PUSH, 1], body[PUSH, 2] = px, py, moment + gy * px - gx * py
    body[0, 0] = body[1, 1] = along
    body[0, 2] = body[2, 0] = along * gy
    body[1, 2] = body[2, 1] = -along * gx
    body[2, 2] = along * (gx * gx + gy * gy) + outside[4] * top / (total * spread * spread)
