"""Coulomb's law for one frame: the least dissipation, with feet that stick held exactly.

The power lost to friction, sum c_k |L_k (v + w S q_k + q'_k)| with c = mu N and L = I + a a^T, is a
convex function of the body velocity, and its minimum is the balance. Its dual variables y, |y_k| <= c_k,
sum A_k^T y_k = 0, are minus the foot forces: set-valued inside the cone for a foot at rest. A point and
its duals prove themselves: sum c |slip| - y . slip >= 0 is how far they are from the minimum.

Method: primal-dual Newton steps on sqrt(slip^2 + s^2) with s driven to 0 (Andersen, Christiansen, Conn,
Overton, SIAM J. Sci. Comput. 22(1), 2000, doi:10.1137/S1064827598343954), which starts inside both
feasible sets and cannot leave them; then the feet at rest are told from the sliding ones and the smooth
problem that remains is solved exactly (``model.traction.coulomb_polish``).
"""

import numpy as np

from model.compiled import compiled
from model.values.arrays import FloatArray

GAP = 1e-13  # accepted distance from the minimum, share of the scale
STEPS = 80
STAY_INSIDE = 0.98  # share of the way to the edge of the cone taken by a step of the forces
HALVINGS = 30
SMALL = 1e-300


@compiled
def slips(levers: FloatArray, offset: FloatArray, twist: FloatArray, out: FloatArray) -> None:
    """Slip of each foot, scaled: out = levers @ twist + offset; (N, 2, 3), (N, 2), (3,), (N, 2)."""
    for k in range(offset.shape[0]):
        for i in range(2):
            out[k, i] = (
                levers[k, i, 0] * twist[0]
                + levers[k, i, 1] * twist[1]
                + levers[k, i, 2] * twist[2]
                + offset[k, i]
            )


@compiled
def solve3(matrix: FloatArray, right: FloatArray, out: FloatArray) -> bool:
    """Solve a 3 x 3 system by elimination with row exchanges; matrix and right are overwritten."""
    for i in range(3):
        best = i
        for j in range(i + 1, 3):
            if abs(matrix[j, i]) > abs(matrix[best, i]):
                best = j
        if not abs(matrix[best, i]) > SMALL:
            return False
        if best != i:
            for j in range(3):
                matrix[i, j], matrix[best, j] = matrix[best, j], matrix[i, j]
            right[i], right[best] = right[best], right[i]
        for j in range(i + 1, 3):
            share = matrix[j, i] / matrix[i, i]
            for m in range(i, 3):
                matrix[j, m] -= share * matrix[i, m]
            right[j] -= share * right[i]
    for i in range(2, -1, -1):
        rest = right[i]
        for j in range(i + 1, 3):
            rest -= matrix[i, j] * out[j]
        out[i] = rest / matrix[i, i]
    return True


@compiled
def _smooth_power(limit: FloatArray, slip: FloatArray, s: float) -> float:
    power = 0.0
    for k in range(limit.size):
        power += limit[k] * np.sqrt(slip[k, 0] ** 2 + slip[k, 1] ** 2 + s * s)
    return power


@compiled
def descend(
    levers: FloatArray,
    offset: FloatArray,
    limit: FloatArray,
    twist: FloatArray,
    dual: FloatArray,
    slip: FloatArray,
    way: FloatArray,
    trial: FloatArray,
) -> tuple[float, int]:
    """Minimise the dissipation.

    Args:
        levers: A_k, (N, 2, 3), lengths in units of the spread.
        offset: Slip at twist 0, (N, 2), of order 1.
        limit: c_k, positive, summing to 1, (N,).
        twist: In: a start; out: the body velocity, scaled, (3,).
        dual: Out: y, (N, 2).
        slip: Out: (N, 2).
        way: Work space, (N, 2).
        trial: Work space, (N, 2).

    Returns:
        The gap that is left, and the steps taken.
    """
    count = limit.size
    matrix = np.empty((3, 3))
    right = np.empty(3)
    step = np.empty(3)
    for k in range(count):
        dual[k, 0] = dual[k, 1] = 0.0
    slips(levers, offset, twist, slip)
    s = 0.0
    for k in range(count):
        s += limit[k] * np.sqrt(slip[k, 0] ** 2 + slip[k, 1] ** 2)
    gap = s
    for iteration in range(STEPS):
        if gap <= GAP:
            return gap, iteration
        for i in range(3):
            right[i] = 0.0
            for j in range(3):
                matrix[i, j] = 0.0
        for k in range(count):
            v0, v1 = slip[k, 0], slip[k, 1]
            r = np.sqrt(v0 * v0 + v1 * v1 + s * s)
            c = limit[k] / r
            y0, y1 = dual[k, 0] / (r * r), dual[k, 1] / (r * r)
            m00 = c - y0 * v0
            m01 = -y0 * v1
            m10 = -y1 * v0
            m11 = c - y1 * v1
            for i in range(3):
                a0, a1 = levers[k, 0, i], levers[k, 1, i]
                right[i] -= c * (a0 * v0 + a1 * v1)
                left0 = a0 * m00 + a1 * m10
                left1 = a0 * m01 + a1 * m11
                for j in range(3):
                    matrix[i, j] += left0 * levers[k, 0, j] + left1 * levers[k, 1, j]
        fall = 0.0
        g0, g1, g2 = right[0], right[1], right[2]
        if not solve3(matrix, right, step):
            return gap, iteration
        fall = -(g0 * step[0] + g1 * step[1] + g2 * step[2])
        # the forces' step, and how much of it stays inside the cones
        inside = 1.0
        for k in range(count):
            v0, v1 = slip[k, 0], slip[k, 1]
            r = np.sqrt(v0 * v0 + v1 * v1 + s * s)
            d0 = levers[k, 0, 0] * step[0] + levers[k, 0, 1] * step[1] + levers[k, 0, 2] * step[2]
            d1 = levers[k, 1, 0] * step[0] + levers[k, 1, 1] * step[1] + levers[k, 1, 2] * step[2]
            turn = (v0 * d0 + v1 * d1) / (r * r)
            c = limit[k] / r
            w0 = c * (v0 + d0) - dual[k, 0] * turn - dual[k, 0]
            w1 = c * (v1 + d1) - dual[k, 1] * turn - dual[k, 1]
            way[k, 0], way[k, 1] = w0, w1
            trial[k, 0], trial[k, 1] = d0, d1
            # |y + t w| = c: the positive root
            aa = w0 * w0 + w1 * w1
            bb = dual[k, 0] * w0 + dual[k, 1] * w1
            cc = dual[k, 0] ** 2 + dual[k, 1] ** 2 - limit[k] ** 2
            if aa > 0.0 and aa + 2.0 * bb + cc > 0.0:
                root = np.sqrt(max(bb * bb - aa * cc, 0.0))
                reach = (root - bb) / aa if bb <= 0.0 else -cc / (root + bb)
                inside = min(inside, STAY_INSIDE * max(reach, 0.0))
        for k in range(count):
            dual[k, 0] += inside * way[k, 0]
            dual[k, 1] += inside * way[k, 1]
        # the velocity's step, shortened until the smoothed power falls
        power = _smooth_power(limit, slip, s)
        share = 1.0
        for _ in range(HALVINGS):
            new = 0.0
            for k in range(count):
                n0 = slip[k, 0] + share * trial[k, 0]
                n1 = slip[k, 1] + share * trial[k, 1]
                new += limit[k] * np.sqrt(n0 * n0 + n1 * n1 + s * s)
            if new <= power + 1e-4 * share * fall + 1e-15 * power:
                break
            share *= 0.5
        for i in range(3):
            twist[i] += share * step[i]
        slips(levers, offset, twist, slip)
        gap = 0.0
        for k in range(count):
            v0, v1 = slip[k, 0], slip[k, 1]
            gap += limit[k] * np.sqrt(v0 * v0 + v1 * v1) - dual[k, 0] * v0 - dual[k, 1] * v1
        # s follows the gap down: faster the more of both steps was taken
        done = min(inside, share)
        s = min(s, gap) * (0.1 if done > 0.9 else 0.3 if done > 0.5 else 0.8)
        s = max(s, 1e-16)
    return gap, STEPS
