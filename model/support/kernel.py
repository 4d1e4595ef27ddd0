"""The contact search of one frame, written for the compiler: slopes, height and loads at balance.

The energy E(s) = sum K/2 min(p, 0)^2 + load z is convex and piecewise quadratic; each step goes to the
balance of the feet now in contact, which three unknowns need no linear algebra library for. Where E falls
by that, the contact changes between need not be looked at one by one; where it does not, the line is
followed from change to change to its lowest point. Slopes are scaled by the feet's spread, energies by the
load, so that tolerances are pure numbers. Tests compare it with ``tests/model/oracles/support.py``.
"""

import numpy as np

from model.compiled import compiled, compiled_sums, in_place
from model.values.arrays import FloatArray

BALANCE = 1e-12  # imbalance accepted, share of the load
RANK = 1e-11  # pivots below this share of the largest leave the body free to tilt
ROUNDING = 1e-13
EPSILON = 1e-15
# Rows of the work space: levers in units of the feet's spread, height of the unloaded foot over the
# ground at pose 0, K / load, height now, its change along a line, the foot's place
LEVER_X, LEVER_Y, ABOVE, SPRING, HEIGHT, CHANGE, X, Y = 0, 1, 2, 3, 4, 5, 6, 7
# and what traction needs: foot speed, w, mu N
SPEED_X, SPEED_Y, W_X, W_Y, DRAG = 8, 9, 10, 11, 12
ROWS = 13
STEPS_PER_FOOT = 20
ENOUGH = 1e-4  # share of the promised fall of E that a full step must bring
FAR = 1e-9  # rounding of the balance at poses out of all proportion: E falls for ever
NOT_A_NUMBER = -1
TIPS = -3
NO_CONVERGENCE = -4


@in_place
@compiled_sums
def _lay_out(
    feet: FloatArray, ground: FloatArray, stiffness: FloatArray, load: float, work: FloatArray
) -> float:
    """Fill rows of the work space, where numbers lie side by side for fast sums; return the lever.

    The lever is the feet's root mean square distance from the body's origin; NaN if anything is.
    """
    count = feet.shape[0]
    share = 1.0 / load
    for k in range(count):
        work[X, k] = feet[k, 0]
        work[Y, k] = feet[k, 1]
        work[ABOVE, k] = feet[k, 2] - ground[k]
    total = 0.0
    for k in range(count):
        x, y = work[X, k], work[Y, k]
        work[SPRING, k] = stiffness[k] * share
        total += x * x + y * y + 0.0 * work[ABOVE, k]
    lever: float = np.sqrt(total / count)
    scale = 1.0 / lever if lever > 0.0 else 0.0
    for k in range(count):
        work[LEVER_X, k] = -work[X, k] * scale
        work[LEVER_Y, k] = work[Y, k] * scale
    return lever


@in_place
@compiled_sums
def _level_height(work: FloatArray) -> float:
    """Height at which all feet together would carry the level body: a start that has contact."""
    total = 0.0
    moment = 0.0
    for k in range(work.shape[1]):
        total += work[SPRING, k]
        moment += work[SPRING, k] * work[ABOVE, k]
    return -(1.0 + moment) / total


@in_place
@compiled_sums
def _sums(
    work: FloatArray, a: float, b: float, z: float
) -> tuple[
    float, float, float, float, float, float, float, float, float, float, float
]:  # fmt: skip
    """Energy, its gradient and Hessian of the feet in contact, and the size of what was added."""
    e, g0, g1, g2 = 0.0, 0.0, 0.0, 0.0
    h00, h01, h02, h11, h12, h22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    rough = 0.0
    for k in range(work.shape[1]):
        x, y = work[LEVER_X, k], work[LEVER_Y, k]
        p = x * a + y * b + (z + work[ABOVE, k])
        work[HEIGHT, k] = p
        c = work[SPRING, k] if p < 0.0 else 0.0
        f = c * p
        e += f * p
        g0 += f * x
        g1 += f * y
        g2 += f
        cx = c * x
        cy = c * y
        h00 += cx * x
        h01 += cx * y
        h02 += cx
        h11 += cy * y
        h12 += cy
        h22 += c
        rough += c * abs(work[ABOVE, k])
    return 0.5 * e + z, g0, g1, g2 + 1.0, h00, h01, h02, h11, h12, h22, rough


@in_place
@compiled
def support_kernel(
    feet: FloatArray,
    ground: FloatArray,
    stiffness: FloatArray,
    load: float,
    pose: FloatArray,
    loads: FloatArray,
    work: FloatArray,
) -> int:
    """Find pose and loads of one frame; stiffness and load must be positive.

    Args:
        feet: Unloaded feet, body frame, (N, 3) [m].
        ground: Height of the ground under each foot, (N,) [m].
        stiffness: (N,) [N/m].
        load: [N].
        pose: Out: slope_x, slope_y, height [m], (3,).
        loads: Out: (N,) [N].
        work: Work space, (ROWS, N); rows X and Y hold the feet afterwards.

    Returns:
        Contact changes taken, or NOT_A_NUMBER, TIPS or NO_CONVERGENCE.
    """
    count = feet.shape[0]
    lever = _lay_out(feet, ground, stiffness, load, work)
    if not np.isfinite(lever):
        return NOT_A_NUMBER
    a = 0.0
    b = 0.0
    z = _level_height(work)
    e, g0, g1, g2, h00, h01, h02, h11, h12, h22, rough = _sums(work, a, b, z)
    for step_number in range(STEPS_PER_FOOT * count):
        rounding = EPSILON * (rough + abs(z) * h22)
        if not rounding < FAR:
            return TIPS
        if max(abs(g0), abs(g1), abs(g2)) <= BALANCE + rounding:
            pose[0] = a / lever if lever > 0.0 else 0.0
            pose[1] = b / lever if lever > 0.0 else 0.0
            pose[2] = z
            for k in range(count):
                loads[k] = -stiffness[k] * work[HEIGHT, k] if work[HEIGHT, k] < 0.0 else 0.0
            return step_number
        d0, d1, d2, newton = _direction(h00, h01, h02, h11, h12, h22, g0, g1, g2)
        if newton:
            old = e
            gain = g0 * d0 + g1 * d1 + g2 * d2
            at, bt, zt = a + d0, b + d1, z + d2
            e, g0, g1, g2, h00, h01, h02, h11, h12, h22, rough = _sums(work, at, bt, zt)
            if e <= old + ENOUGH * gain:
                a, b, z = at, bt, zt
                continue
        step = _line_minimum(work, a, b, z, d0, d1, d2)
        if not np.isfinite(step):
            return TIPS
        a += step * d0
        b += step * d1
        z += step * d2
        e, g0, g1, g2, h00, h01, h02, h11, h12, h22, rough = _sums(work, a, b, z)
    return NO_CONVERGENCE


@in_place
@compiled
def _direction(
    h00: float, h01: float, h02: float, h11: float, h12: float, h22: float,
    g0: float, g1: float, g2: float,
) -> tuple[float, float, float, bool]:  # fmt: skip
    """Step to the balance of the feet in contact (True), or how the body tilts where they leave it free.

    Elimination of the height first (its pivot is the sum of stiffness, never small), then of the
    slopes, larger pivot first. A vanishing pivot is a motion that changes no foot's load.
    """
    if h22 <= 0.0:  # nothing touches: fall
        return 0.0, 0.0, -1.0, False
    m0 = h02 / h22
    m1 = h12 / h22
    s00 = h00 - m0 * h02
    s01 = h01 - m0 * h12
    s11 = h11 - m1 * h12
    r0 = -(g0 - m0 * g2)
    r1 = -(g1 - m1 * g2)
    limit = RANK * max(h00, h11, h22)
    swap = s11 > s00
    if swap:
        s00, s11 = s11, s00
        r0, r1 = r1, r0
    e0 = 0.0
    e1 = 0.0
    if s00 <= limit:  # the feet in contact stand in one point
        if max(abs(r0), abs(r1)) > BALANCE:
            e0, e1 = r0, r1
            size = np.sqrt(e0 * e0 + e1 * e1)
            e0 /= size
            e1 /= size
            if swap:
                e0, e1 = e1, e0
            return e0, e1, -(m0 * e0 + m1 * e1), False
    else:
        m = s01 / s00
        pivot = s11 - m * s01
        rest = r1 - m * r0
        if pivot <= limit:  # the feet in contact stand in a line
            if abs(rest) > BALANCE:
                e1 = 1.0 if rest > 0 else -1.0
                e0 = -m * e1
                if swap:
                    e0, e1 = e1, e0
                return e0, e1, -(m0 * e0 + m1 * e1), False
            e0 = r0 / s00
        else:
            e1 = rest / pivot
            e0 = (r0 - s01 * e1) / s00
    if swap:
        e0, e1 = e1, e0
    return e0, e1, (-g2 - h02 * e0 - h12 * e1) / h22, True


@in_place
@compiled
def _line_minimum(
    work: FloatArray, a: float, b: float, z: float, d0: float, d1: float, d2: float
) -> float:
    """Go along a line until E no longer falls; return how far (infinite: it falls for ever).

    E's slope along the line rises, linearly from contact change to contact change. Which feet are in
    contact beyond a change is told by the order of the changes, never by a rounded height.
    """
    count = work.shape[1]
    size = max(abs(d0), abs(d1), abs(d2))
    for k in range(count):
        work[HEIGHT, k] = work[LEVER_X, k] * a + work[LEVER_Y, k] * b + (z + work[ABOVE, k])
        change = work[LEVER_X, k] * d0 + work[LEVER_Y, k] * d1 + d2
        work[CHANGE, k] = 0.0 if abs(change) < ROUNDING * size else change
    t = 0.0
    for _ in range(count + 1):
        slope = d2
        bend = 0.0
        nearest = np.inf
        for k in range(count):
            height, change = work[HEIGHT, k], work[CHANGE, k]
            kink = -height / change if change != 0.0 else np.inf
            if change < 0:
                down = kink <= t
            elif change > 0:
                down = kink > t
            else:
                down = height < 0
            if down:
                c = work[SPRING, k] * change
                slope += c * (height + t * change)
                bend += c * change
            if t < kink < nearest:
                nearest = kink
        if slope >= 0:  # E turned exactly at a contact change
            return t
        if bend > 0 and t - slope / bend <= nearest:
            return t - slope / bend
        if nearest == np.inf:
            return np.inf
        t = nearest
    return np.inf
