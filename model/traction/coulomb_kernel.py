"""The balance of one frame: feet that slide, creep or give, against what pushes and resists the body.

With the slip s = v + w S q + q' + C (F - F_before) / dt of each foot and A = [I, S q], the body's velocity
u = (v, w) is that at which forces and moments balance::

    sum A^T F + push - R u = 0

Coulomb's law is F = -c L z / sqrt(|z|^2 + rest^2), z = L s, c = mu N, L = I + w w^T. As ``rest`` vanishes
it is the exact law, under which feet at rest hold by any force in their cones. The balance is the saddle

    min over u, max over |y| <= c of  sum y . z + u R u / 2 - push u,      F = -L y,

and where nothing pushes a point and its duals y prove themselves: sum c |z| - y . z >= 0 is how far they
are from the least dissipation. The viscous ansatz F = -sigma c L s has no cones, only a scale sigma, which
follows the slips.

Method: primal-dual Newton steps on r y = c z, r = sqrt(|z|^2 + s^2), with s driven to ``rest`` (Andersen,
Christiansen, Conn, Overton, SIAM J. Sci. Comput. 22(1), 2000, doi:10.1137/S1064827598343954). Under the
exact law the duals start inside their cones and cannot leave them. Those of feet that creep may, on the
way; the slope is then that of the edge (Hintermueller and Kunisch, SIAM J. Appl. Math. 64(4), 2004,
doi:10.1137/S0036139903422784). Neither needs a line search.
"""

from typing import NamedTuple

import numpy as np

from model.compiled import compiled, in_place
from model.traction.kernel import CREEP_SPEED_M_S, coulomb_scale
from model.values.arrays import FloatArray

# Columns of the table of feet, (n, COLUMNS), all in units of the frame. Given: K [I, S q] in rows of three,
# with K = L under Coulomb's law and I under the viscous one; K times the slip at body velocity 0 and no
# force; c, positive, summing to 1; K C K / dt (xx, xy, yy); w. Found: y, z. Work: c at the present slip, a
# step, slips of a trial.
LEVER, OFFSET, LIMIT, GIVE, W, DUAL, SLIP, GRIP, STEP, NEW = 0, 6, 8, 9, 12, 14, 16, 18, 19, 21
COLUMNS = 23
# Rows of what else acts on the body, (5, 3): R in three rows, the push, and the velocity that is found.
PUSH, TWIST, BODY_ROWS = 3, 4, 5
# Rows of a linear system, (5, 3): the matrix in three rows, its right side, the solution.
RIGHT, SOLUTION, SYSTEM_ROWS = 3, 4, 5

GAP = 1e-13  # accepted distance from the least dissipation, share of the scale
SETTLED = 1e-11  # accepted change of a slip that creeps or gives, share of the largest
LOOSER = (
    1e3  # times that where sigma or Stribeck's grip follows the slips, which closes in linearly
)
AHEAD = 10.0  # the next change is taken to be that much larger than its estimate
STEPS = 80
FOLLOWING_STEPS = 400
STAY_INSIDE = 0.98  # share of the way to the edge of the cone taken by a step of the forces
RUNAWAY = 1e8  # slip in units of the frame from which on nothing balances the push
SMALL = 1e-300


class FootLaw(NamedTuple):
    """How feet answer slip; speeds in m/s, or in units of the frame.

    Attributes:
        coulomb: Coulomb's law, else the viscous ansatz.
        rest: Slip below which a foot under Coulomb's law creeps; 0 is the exact law, for stiff feet of a
            body that nothing pushes.
        static_ratio: Friction at rest over friction when sliding fast (Stribeck); not 1 needs a ``rest``.
        static_speed: Slip at which most of the difference is gone.
        creep: Slip below which a foot is taken to rest when the ansatz' forces are put on a scale.
    """

    coulomb: bool
    rest: float = 0.0
    static_ratio: float = 1.0
    static_speed: float = 1.0
    creep: float = CREEP_SPEED_M_S


@in_place
@compiled
def slips(feet: FloatArray, rows: FloatArray, row: int, column: int) -> None:
    """Slip of each foot that does not give, from the velocity in a row, into two columns."""
    for k in range(feet.shape[0]):
        for i in range(2):
            feet[k, column + i] = (
                feet[k, LEVER + 3 * i] * rows[row, 0]
                + feet[k, LEVER + 3 * i + 1] * rows[row, 1]
                + feet[k, LEVER + 3 * i + 2] * rows[row, 2]
                + feet[k, OFFSET + i]
            )


@in_place
@compiled
def solve3(system: FloatArray) -> bool:
    """Solve a 3 x 3 system by elimination with row exchanges; False, and no solution, if a pivot vanishes.

    Numbers of their own, not places in memory: then the compiler keeps them where it computes.
    """
    a0, a1, a2, a3 = system[0, 0], system[0, 1], system[0, 2], system[RIGHT, 0]
    b0, b1, b2, b3 = system[1, 0], system[1, 1], system[1, 2], system[RIGHT, 1]
    c0, c1, c2, c3 = system[2, 0], system[2, 1], system[2, 2], system[RIGHT, 2]
    if abs(b0) > abs(a0):
        if abs(c0) > abs(b0):
            a0, a1, a2, a3, c0, c1, c2, c3 = c0, c1, c2, c3, a0, a1, a2, a3
        else:
            a0, a1, a2, a3, b0, b1, b2, b3 = b0, b1, b2, b3, a0, a1, a2, a3
    elif abs(c0) > abs(a0):
        a0, a1, a2, a3, c0, c1, c2, c3 = c0, c1, c2, c3, a0, a1, a2, a3
    if not abs(a0) > SMALL:
        return False
    share = b0 / a0
    b1, b2, b3 = b1 - share * a1, b2 - share * a2, b3 - share * a3
    share = c0 / a0
    c1, c2, c3 = c1 - share * a1, c2 - share * a2, c3 - share * a3
    if abs(c1) > abs(b1):
        b1, b2, b3, c1, c2, c3 = c1, c2, c3, b1, b2, b3
    if not abs(b1) > SMALL:
        return False
    share = c1 / b1
    c2, c3 = c2 - share * b2, c3 - share * b3
    if not abs(c2) > SMALL:
        return False
    z = c3 / c2
    y = (b3 - b2 * z) / b1
    system[SOLUTION, 0] = (a3 - a1 * y - a2 * z) / a0
    system[SOLUTION, 1], system[SOLUTION, 2] = y, z
    return True


@in_place
@compiled
def _weaken(feet: FloatArray, law: FootLaw) -> None:
    """Set the grip of each foot: less the faster it slips (Stribeck)."""
    for k in range(feet.shape[0]):
        z0, z1 = feet[k, SLIP], feet[k, SLIP + 1]
        if law.coulomb:  # back from L slip
            w0, w1 = feet[k, W], feet[k, W + 1]
            along = (w0 * z0 + w1 * z1) / (1.0 + w0 * w0 + w1 * w1)
            z0, z1 = z0 - w0 * along, z1 - w1 * along
        more = np.exp(-(z0 * z0 + z1 * z1) / law.static_speed**2)
        feet[k, GRIP] = feet[k, LIMIT] * (1.0 + (law.static_ratio - 1.0) * more)


@in_place
@compiled
def _follow(feet: FloatArray, creep: float) -> float:
    """Scale sigma that brings the duals nearest to Coulomb's at the present slips."""
    scale = coulomb_scale(feet[:, SLIP : SLIP + 2], feet[:, DUAL : DUAL + 2], creep)
    return scale if scale > 0.0 else 1.0 / creep


@in_place
@compiled
def _answer(
    feet: FloatArray, k: int, coulomb: bool
) -> tuple[float, float, float, float, float, float]:
    """How a foot's dual follows its slip: the change of y is b + M (change of z); b and M.

    With h and bend in STEP: M = h I - bend y z^T, h = c / r under Coulomb's law, M = h L, h = sigma c else.
    """
    h, bend = feet[k, STEP], feet[k, STEP + 1]
    y0, y1, z0, z1 = feet[k, DUAL], feet[k, DUAL + 1], feet[k, SLIP], feet[k, SLIP + 1]
    if coulomb:
        v0, v1 = bend * y0, bend * y1
        return h * z0 - y0, h * z1 - y1, h - v0 * z0, -v0 * z1, -v1 * z0, h - v1 * z1
    w0, w1 = feet[k, W], feet[k, W + 1]
    m00, m01, m11 = h * (1.0 + w0 * w0), h * w0 * w1, h * (1.0 + w1 * w1)
    return m00 * z0 + m01 * z1 - y0, m01 * z0 + m11 * z1 - y1, m00, m01, m01, m11


@in_place
@compiled
def _yielding(
    feet: FloatArray, k: int, m00: float, m01: float, m10: float, m11: float
) -> tuple[float, float, float, float]:
    """(I + D M)^-1 of a foot that gives: the share of a rigid change of z that is left."""
    gxx, gxy, gyy = feet[k, GIVE], feet[k, GIVE + 1], feet[k, GIVE + 2]
    n00, n01 = 1.0 + gxx * m00 + gxy * m10, gxx * m01 + gxy * m11
    n10, n11 = gxy * m00 + gyy * m10, 1.0 + gxy * m01 + gyy * m11
    det = n00 * n11 - n01 * n10
    return n11 / det, -n01 / det, -n10 / det, n00 / det


@in_place
@compiled
def _lay_system(
    feet: FloatArray, body: FloatArray, coulomb: bool, elastic: bool, s: float, system: FloatArray
) -> None:
    """Matrix and right side of the step of the velocity; feet's STEP holds h and bend afterwards."""
    # sums in numbers of their own: what is written to memory between two feet has to be read again
    u0, u1, u2 = body[TWIST, 0], body[TWIST, 1], body[TWIST, 2]
    s00, s01, s02 = body[0, 0], body[0, 1], body[0, 2]
    s10, s11, s12 = body[1, 0], body[1, 1], body[1, 2]
    s20, s21, s22 = body[2, 0], body[2, 1], body[2, 2]
    push0 = body[PUSH, 0] - s00 * u0 - s01 * u1 - s02 * u2
    push1 = body[PUSH, 1] - s10 * u0 - s11 * u1 - s12 * u2
    push2 = body[PUSH, 2] - s20 * u0 - s21 * u1 - s22 * u2
    for k in range(feet.shape[0]):
        c = feet[k, GRIP]
        if coulomb:
            y0, y1 = feet[k, DUAL], feet[k, DUAL + 1]
            square = feet[k, SLIP] ** 2 + feet[k, SLIP + 1] ** 2 + s * s
            length = y0 * y0 + y1 * y1
            feet[k, STEP], feet[k, STEP + 1] = c / np.sqrt(square), 1.0 / square
            if length > c * c:
                feet[k, STEP + 1] *= c / np.sqrt(length)
        else:
            feet[k, STEP] = s * c  # s is sigma
        b0, b1, m00, m01, m10, m11 = _answer(feet, k, coulomb)
        y0, y1 = feet[k, DUAL] + b0, feet[k, DUAL + 1] + b1
        if elastic:
            e00, e01, e10, e11 = _yielding(feet, k, m00, m01, m10, m11)
            r0 = feet[k, GIVE] * b0 + feet[k, GIVE + 1] * b1
            r1 = feet[k, GIVE + 1] * b0 + feet[k, GIVE + 2] * b1
            m00, m01, m10, m11 = (
                m00 * e00 + m01 * e10, m00 * e01 + m01 * e11,
                m10 * e00 + m11 * e10, m10 * e01 + m11 * e11,
            )  # fmt: skip
            y0, y1 = y0 - m00 * r0 - m01 * r1, y1 - m10 * r0 - m11 * r1
        a0, a1, a2 = feet[k, LEVER], feet[k, LEVER + 1], feet[k, LEVER + 2]
        c0, c1, c2 = feet[k, LEVER + 3], feet[k, LEVER + 4], feet[k, LEVER + 5]
        push0, push1, push2 = (
            push0 - (a0 * y0 + c0 * y1), push1 - (a1 * y0 + c1 * y1), push2 - (a2 * y0 + c2 * y1)
        )  # fmt: skip
        left0, left1 = a0 * m00 + c0 * m10, a0 * m01 + c0 * m11
        s00, s01, s02 = (
            s00 + (left0 * a0 + left1 * c0), s01 + (left0 * a1 + left1 * c1),
            s02 + (left0 * a2 + left1 * c2),
        )  # fmt: skip
        left0, left1 = a1 * m00 + c1 * m10, a1 * m01 + c1 * m11
        s10, s11, s12 = (
            s10 + (left0 * a0 + left1 * c0), s11 + (left0 * a1 + left1 * c1),
            s12 + (left0 * a2 + left1 * c2),
        )  # fmt: skip
        left0, left1 = a2 * m00 + c2 * m10, a2 * m01 + c2 * m11
        s20, s21, s22 = (
            s20 + (left0 * a0 + left1 * c0), s21 + (left0 * a1 + left1 * c1),
            s22 + (left0 * a2 + left1 * c2),
        )  # fmt: skip
    system[0, 0], system[0, 1], system[0, 2] = s00, s01, s02
    system[1, 0], system[1, 1], system[1, 2] = s10, s11, s12
    system[2, 0], system[2, 1], system[2, 2] = s20, s21, s22
    system[RIGHT, 0], system[RIGHT, 1], system[RIGHT, 2] = push0, push1, push2


@in_place
@compiled
def _lay_steps(
    feet: FloatArray, coulomb: bool, elastic: bool, exact: bool, system: FloatArray
) -> float:
    """Steps of the duals for a step of the velocity; how much of them stays inside the cones."""
    inside = 1.0
    u0, u1, u2 = system[SOLUTION, 0], system[SOLUTION, 1], system[SOLUTION, 2]
    for k in range(feet.shape[0]):
        b0, b1, m00, m01, m10, m11 = _answer(feet, k, coulomb)
        d0 = feet[k, LEVER] * u0 + feet[k, LEVER + 1] * u1 + feet[k, LEVER + 2] * u2
        d1 = feet[k, LEVER + 3] * u0 + feet[k, LEVER + 4] * u1 + feet[k, LEVER + 5] * u2
        if elastic:
            e00, e01, e10, e11 = _yielding(feet, k, m00, m01, m10, m11)
            d0 -= feet[k, GIVE] * b0 + feet[k, GIVE + 1] * b1
            d1 -= feet[k, GIVE + 1] * b0 + feet[k, GIVE + 2] * b1
            d0, d1 = e00 * d0 + e01 * d1, e10 * d0 + e11 * d1
        w0, w1 = b0 + m00 * d0 + m01 * d1, b1 + m10 * d0 + m11 * d1
        feet[k, STEP], feet[k, STEP + 1] = w0, w1
        if exact:
            # |y + t w| = c: the positive root
            y0, y1 = feet[k, DUAL], feet[k, DUAL + 1]
            aa, bb = w0 * w0 + w1 * w1, y0 * w0 + y1 * w1
            cc = y0 * y0 + y1 * y1 - feet[k, GRIP] ** 2
            if aa > 0.0 and aa + 2.0 * bb + cc > 0.0:
                root = np.sqrt(max(bb * bb - aa * cc, 0.0))
                reach = (root - bb) / aa if bb <= 0.0 else -cc / (root + bb)
                inside = min(inside, STAY_INSIDE * max(reach, 0.0))
    return inside


@in_place
@compiled
def descend(
    feet: FloatArray, body: FloatArray, law: FootLaw, elastic: bool, start: float, system: FloatArray
) -> tuple[float, bool]:  # fmt: skip
    """Find the balance.

    Args:
        feet: The table of feet; columns DUAL, in: where the duals start, and SLIP are written.
        body: What else acts; row TWIST is the velocity, in: a start, out: the one found.
        law: How feet answer slip, in units of the frame.
        elastic: Whether feet give.
        start: Where s begins (``rest`` if that is more, the mean slip if that is less); of the viscous
            ansatz, where sigma begins.
        system: Work space, (SYSTEM_ROWS, 3).

    Returns:
        How far the answer is from the least dissipation (exact law), and whether it has settled.
    """
    coulomb, rest = law.coulomb, law.rest
    exact, weakens = coulomb and rest == 0.0, law.static_ratio != 1.0
    follows = weakens or not coulomb
    tolerance = SETTLED * (LOOSER if follows else 1.0)
    slips(feet, body, TWIST, SLIP)
    gap = 0.0
    for k in range(feet.shape[0]):
        y0, y1 = feet[k, DUAL], feet[k, DUAL + 1]
        if elastic:
            feet[k, SLIP] -= feet[k, GIVE] * y0 + feet[k, GIVE + 1] * y1
            feet[k, SLIP + 1] -= feet[k, GIVE + 1] * y0 + feet[k, GIVE + 2] * y1
        feet[k, GRIP] = feet[k, LIMIT]
        gap += feet[k, LIMIT] * np.sqrt(feet[k, SLIP] ** 2 + feet[k, SLIP + 1] ** 2)
    s = max(min(start, gap), rest) if coulomb else start if start > 0.0 else 1.0 / law.creep
    s_before, off_before = s, np.nan
    for _ in range(FOLLOWING_STEPS if follows else STEPS):
        if exact and gap <= GAP:
            return gap, True
        if weakens:
            _weaken(feet, law)
        _lay_system(feet, body, coulomb, elastic, s, system)
        if not solve3(system):
            return gap, False
        inside = _lay_steps(feet, coulomb, elastic, exact, system)
        for i in range(3):
            body[TWIST, i] += system[SOLUTION, i]
        gap, moved, size, left = 0.0, 0.0, 0.0, 0.0
        u0, u1, u2 = body[TWIST, 0], body[TWIST, 1], body[TWIST, 2]
        for k in range(feet.shape[0]):
            y0 = feet[k, DUAL] + inside * feet[k, STEP]
            y1 = feet[k, DUAL + 1] + inside * feet[k, STEP + 1]
            z0 = feet[k, OFFSET] + feet[k, LEVER] * u0
            z1 = feet[k, OFFSET + 1] + feet[k, LEVER + 3] * u0
            z0, z1 = z0 + feet[k, LEVER + 1] * u1, z1 + feet[k, LEVER + 4] * u1
            z0, z1 = z0 + feet[k, LEVER + 2] * u2, z1 + feet[k, LEVER + 5] * u2
            if elastic:
                z0 -= feet[k, GIVE] * y0 + feet[k, GIVE + 1] * y1
                z1 -= feet[k, GIVE + 1] * y0 + feet[k, GIVE + 2] * y1
            d0, d1 = abs(z0 - feet[k, SLIP]), abs(z1 - feet[k, SLIP + 1])
            moved = max(moved, d0, d1)
            # what Newton's next step would change, as a share: the square of this one's, over the length
            # in which the law bends
            left = max(left, (d0 * d0 + d1 * d1) / (z0 * z0 + z1 * z1 + s * s + SMALL))
            size = max(size, abs(z0), abs(z1))
            feet[k, DUAL], feet[k, DUAL + 1] = y0, y1
            feet[k, SLIP], feet[k, SLIP + 1] = z0, z1
            gap += feet[k, GRIP] * np.sqrt(z0 * z0 + z1 * z1) - y0 * z0 - y1 * z1
        if not (np.isfinite(gap) and size <= RUNAWAY):
            return gap, False
        if not coulomb:
            followed = _follow(feet, law.creep)
            moved = max(moved, size * abs(followed / s - 1.0))
            off, ahead = followed - s, followed
            if not weakens and off != off_before:  # secant: sigma is all that a step depends on
                secant = s - off * (s - s_before) / (off - off_before)
                if 0.5 * followed < secant < 2.0 * followed:
                    ahead = secant
            s_before, off_before, s = s, off, ahead
        if not exact and (s <= rest or not coulomb):
            settled = moved <= tolerance * (size + rest)
            if settled or (not follows and AHEAD * left <= tolerance):
                return gap, True
        if coulomb:
            # s follows the gap down: faster the more of the step was taken
            s = min(s, gap) * (0.1 if inside > 0.9 else 0.3 if inside > 0.5 else 0.8)
            s = max(s, rest, 1e-16)
    return gap, False
