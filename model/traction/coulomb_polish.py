"""From nearly to exactly: the smooth problem that remains once the feet at rest are known.

With no foot at rest it is Newton's method in three unknowns, with one a rotation about that foot. With
several nothing is left but the forces, of which infinitely many balance: those are taken that feet have
which creep ever more slowly, the limit of the law with a ``rest`` (``model.traction.coulomb_kernel``). They
maximise sum sqrt(c^2 - y^2), so they keep away from the edges of the cones and change smoothly with the
loads.
"""

import numpy as np

from model.compiled import compiled, in_place
from model.traction.coulomb_kernel import (
    BODY_ROWS,
    COLUMNS,
    DUAL,
    LEVER,
    LIMIT,
    NEW,
    OFFSET,
    PUSH,
    RIGHT,
    SLIP,
    SOLUTION,
    TWIST,
    FootLaw,
    descend,
    slips,
    solve3,
)
from model.values.arrays import BoolArray, FloatArray

NEWTON_STEPS = 12
BALANCED = 1e-13  # sum of forces, share of the sum of the limits
ROUNDED = 1e-15  # a step in velocity that is rounding, share of the largest slip
NEARLY = 1e-9  # sum of forces beyond which not even that counts as balanced
FLAT = 1e-10  # curvature below this share: the velocity is one of many
RIGID = 1e-10  # slip of feet that are said to rest together
EDGE = 1e-9  # a force this near its cone, as a share, counts as on it
NOT_SOLVED = 0
SOLVED = 1
SOLVED_FLAT = 2  # solved, but the velocity is one of many


@in_place
@compiled
def classify(feet: FloatArray, sticking: BoolArray) -> int:
    """Tell feet at rest from sliding ones; return how many rest.

    At a gap g either the slip is below g / (c - |y|) or the force within g / |slip| of its cone, so
    the two are compared with each other and no threshold is needed.
    """
    resting = 0
    for k in range(feet.shape[0]):
        speed = np.sqrt(feet[k, SLIP] ** 2 + feet[k, SLIP + 1] ** 2)
        room = 1.0 - np.sqrt(feet[k, DUAL] ** 2 + feet[k, DUAL + 1] ** 2) / feet[k, LIMIT]
        sticking[k] = speed < room
        resting += sticking[k]
    return resting


@in_place
@compiled
def polish(
    feet: FloatArray, body: FloatArray, sticking: BoolArray, resting: int, creep: bool,
    system: FloatArray, at: FloatArray,
) -> int:  # fmt: skip
    """Solve for given feet at rest; the answer is put in place only where it proves right.

    Args:
        feet: The table of feet of ``model.traction.coulomb_kernel``: DUAL and SLIP are written, the slip of
            feet at rest is exactly 0.
        body: Row TWIST is where the search starts, and the answer.
        sticking: Feet at rest, (n,).
        resting: How many they are.
        creep: Whether several feet at rest get the forces of feet that creep, else any that hold them.
        system: Work space, (SYSTEM_ROWS, 3).
        at: Work space, (1, 3).

    Returns:
        NOT_SOLVED, SOLVED or SOLVED_FLAT.
    """
    if resting == 0:
        return _all_slide(feet, body, sticking, system, at)
    if resting == 1:
        return _about_one_foot(feet, body, sticking, system, at)
    return _several_rest(feet, body, sticking, creep, system, at)


@in_place
@compiled
def _gradient(feet: FloatArray, at: FloatArray, sticking: BoolArray, system: FloatArray) -> bool:
    """Hessian and gradient of the power but for feet at rest; False if another foot does not slide.

    ``at`` holds the velocity in row 0, ``system`` gets both; NEW are the slips. Sums are kept in numbers of
    their own: what is written to memory between two feet, the compiler has to read again.
    """
    v0, v1, v2 = at[0, 0], at[0, 1], at[0, 2]
    r0, r1, r2 = 0.0, 0.0, 0.0
    s00, s01, s02, s10, s11, s12, s20, s21, s22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    slide = True
    for k in range(feet.shape[0]):
        x0, x1, x2 = feet[k, LEVER], feet[k, LEVER + 1], feet[k, LEVER + 2]
        y0, y1, y2 = feet[k, LEVER + 3], feet[k, LEVER + 4], feet[k, LEVER + 5]
        z0 = x0 * v0 + x1 * v1 + x2 * v2 + feet[k, OFFSET]
        z1 = y0 * v0 + y1 * v1 + y2 * v2 + feet[k, OFFSET + 1]
        feet[k, NEW], feet[k, NEW + 1] = z0, z1
        if sticking[k]:
            continue
        speed = np.sqrt(z0 * z0 + z1 * z1)
        if speed <= 1e-12:
            slide = False
            continue
        e0, e1 = z0 / speed, z1 / speed
        c = feet[k, LIMIT]
        bend = c / speed
        r0, r1, r2 = (
            r0 + c * (x0 * e0 + y0 * e1), r1 + c * (x1 * e0 + y1 * e1), r2 + c * (x2 * e0 + y2 * e1)
        )  # fmt: skip
        t0, t1, t2 = y0 * e0 - x0 * e1, y1 * e0 - x1 * e1, y2 * e0 - x2 * e1
        across = bend * t0
        s00, s01, s02 = s00 + across * t0, s01 + across * t1, s02 + across * t2
        across = bend * t1
        s10, s11, s12 = s10 + across * t0, s11 + across * t1, s12 + across * t2
        across = bend * t2
        s20, s21, s22 = s20 + across * t0, s21 + across * t1, s22 + across * t2
    system[0, 0], system[0, 1], system[0, 2] = s00, s01, s02
    system[1, 0], system[1, 1], system[1, 2] = s10, s11, s12
    system[2, 0], system[2, 1], system[2, 2] = s20, s21, s22
    system[RIGHT, 0], system[RIGHT, 1], system[RIGHT, 2] = r0, r1, r2
    return slide


@in_place
@compiled
def _take(feet: FloatArray, body: FloatArray, at: FloatArray, sticking: BoolArray) -> None:
    """Put velocity, slips and the forces of sliding feet in place; feet at rest have no slip at all."""
    for i in range(3):
        body[TWIST, i] = at[0, i]
    for k in range(feet.shape[0]):
        if sticking[k]:
            feet[k, SLIP] = feet[k, SLIP + 1] = 0.0
        else:
            z0, z1 = feet[k, NEW], feet[k, NEW + 1]
            h = feet[k, LIMIT] / np.sqrt(z0 * z0 + z1 * z1)
            feet[k, SLIP], feet[k, SLIP + 1] = z0, z1
            feet[k, DUAL], feet[k, DUAL + 1] = h * z0, h * z1


@in_place
@compiled
def _largest(system: FloatArray, row: int) -> float:
    size: float = max(abs(system[row, 0]), abs(system[row, 1]), abs(system[row, 2]))
    return size


@in_place
@compiled
def _balanced(rest: float, step: float) -> bool:
    """Whether what is left of the forces is rounding, given the last step of Newton's method.

    The direction of a slow foot's slip has fewer digits than the slips, and so has its force.
    """
    return rest <= BALANCED or (step <= ROUNDED and rest <= NEARLY)


@in_place
@compiled
def _all_slide(
    feet: FloatArray, body: FloatArray, none: BoolArray, system: FloatArray, at: FloatArray
) -> int:
    for i in range(3):
        at[0, i] = body[TWIST, i]
    step = np.inf
    for last in range(NEWTON_STEPS + 1):
        if not _gradient(feet, at, none, system):
            return NOT_SOLVED
        if last == NEWTON_STEPS or _largest(system, RIGHT) <= 0.01 * BALANCED or step <= ROUNDED:
            break
        if _smallest_pivot(system) <= FLAT:
            # a way to move that changes no force: stay where the interior method put us on it
            top = max(system[0, 0], system[1, 1], system[2, 2])
            for i in range(3):
                system[i, i] += 1e3 * FLAT * top
        if not solve3(system):
            return NOT_SOLVED
        for i in range(3):
            at[0, i] -= system[SOLUTION, i]
        step = _largest(system, SOLUTION)
    if not _balanced(_largest(system, RIGHT), step):
        return NOT_SOLVED
    flat = _smallest_pivot(system) <= FLAT
    _take(feet, body, at, none)
    return SOLVED_FLAT if flat else SOLVED


@in_place
@compiled
def _smallest_pivot(matrix: FloatArray) -> float:
    """Smallest pivot of the symmetric elimination, over the largest entry of the diagonal."""
    top = max(matrix[0, 0], matrix[1, 1], matrix[2, 2])
    if top <= 0.0:
        return 0.0
    # eigenvalues would be cleaner; the determinant over the product bounds the smallest one
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    determinant = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    minors = max(a * d - b * b, a * f - c * c, d * f - e * e)
    if minors <= 0.0:
        return 0.0
    smallest: float = max(determinant / minors / top, 0.0)
    return smallest


@in_place
@compiled
def _about_one_foot(
    feet: FloatArray, body: FloatArray, sticking: BoolArray, system: FloatArray, at: FloatArray
) -> int:
    foot = 0
    for k in range(sticking.size):
        if sticking[k]:
            foot = k
    # L (v + w e + q') = 0 with A = L [I, e]: v follows from w
    a, b, along = feet[foot, LEVER], feet[foot, LEVER + 1], feet[foot, LEVER + 2]
    c, d, across = feet[foot, LEVER + 3], feet[foot, LEVER + 4], feet[foot, LEVER + 5]
    o0, o1 = feet[foot, OFFSET], feet[foot, OFFSET + 1]
    det = a * d - b * c
    e0, e1 = (d * along - b * across) / det, (a * across - c * along) / det
    h0, h1 = (d * o0 - b * o1) / det, (a * o1 - c * o0) / det
    turn = body[TWIST, 2]
    slope, step, flat = 0.0, np.inf, False
    for last in range(NEWTON_STEPS + 1):
        at[0, 0], at[0, 1], at[0, 2] = -h0 - turn * e0, -h1 - turn * e1, turn
        if not _gradient(feet, at, sticking, system):
            return NOT_SOLVED
        # along (-e0, -e1, 1)
        slope = system[RIGHT, 2] - e0 * system[RIGHT, 0] - e1 * system[RIGHT, 1]
        curvature = (
            system[2, 2]
            + e0 * (e0 * system[0, 0] + 2.0 * e1 * system[0, 1] - 2.0 * system[0, 2])
            + e1 * (e1 * system[1, 1] - 2.0 * system[1, 2])
        )
        flat = curvature <= FLAT
        if last == NEWTON_STEPS or abs(slope) <= 0.01 * BALANCED or step <= ROUNDED or flat:
            break
        step = abs(slope / curvature)
        turn -= slope / curvature
    # its force balances the others: A^T y = -gradient, of which the first two rows are L^T y
    y0 = -(d * system[RIGHT, 0] - c * system[RIGHT, 1]) / det
    y1 = -(a * system[RIGHT, 1] - b * system[RIGHT, 0]) / det
    if not (_balanced(abs(slope), step) and y0 * y0 + y1 * y1 <= feet[foot, LIMIT] ** 2):
        return NOT_SOLVED
    _take(feet, body, at, sticking)
    feet[foot, DUAL], feet[foot, DUAL + 1] = y0, y1
    return SOLVED_FLAT if flat else SOLVED


@in_place
@compiled
def _lay_resting(feet: FloatArray, sticking: BoolArray, system: FloatArray) -> None:
    """Least squares of the slips of the feet at rest, each by its limit, for a velocity."""
    system[:, :] = 0.0
    for k in range(sticking.size):
        if sticking[k]:
            for m in range(2):
                for i in range(3):
                    lever = feet[k, LIMIT] * feet[k, LEVER + 3 * m + i]
                    system[RIGHT, i] -= lever * feet[k, OFFSET + m]
                    for j in range(3):
                        system[i, j] += lever * feet[k, LEVER + 3 * m + j]


@in_place
@compiled
def _hold(feet: FloatArray, load: FloatArray, sticking: BoolArray, system: FloatArray) -> bool:
    """Whether the least forces (by their cones) hold the feet at rest; then they are the duals."""
    _lay_resting(feet, sticking, system)
    for i in range(3):
        system[RIGHT, i] = load[PUSH, i]
    if not solve3(system):
        return False
    # all of them first: what does not hold must leave the duals as they were
    for write in range(2):
        for k in range(sticking.size):
            if sticking[k]:
                square = 0.0
                for m in range(2):
                    share = 0.0
                    for i in range(3):
                        share += feet[k, LEVER + 3 * m + i] * system[SOLUTION, i]
                    square += share * share
                    if write == 1:
                        feet[k, DUAL + m] = feet[k, LIMIT] * share
                if not square <= 1.0:
                    return False
    return True


@compiled
def _several_rest(
    feet: FloatArray, body: FloatArray, sticking: BoolArray, creep: bool, system: FloatArray,
    at: FloatArray,
) -> int:  # fmt: skip
    count = sticking.size
    _lay_resting(feet, sticking, system)
    if not solve3(system):
        return NOT_SOLVED
    for i in range(3):
        at[0, i] = system[SOLUTION, i]
    slips(feet, at, 0, NEW)
    for k in range(count):
        if sticking[k] and max(abs(feet[k, NEW]), abs(feet[k, NEW + 1])) > RIGID:
            return NOT_SOLVED
    if not _gradient(feet, at, sticking, system):
        return NOT_SOLVED
    load = np.zeros((BODY_ROWS, 3))  # what the others leave to them
    for i in range(3):
        load[PUSH, i] = -system[RIGHT, i]
    if not creep and _hold(feet, load, sticking, system):
        _take(feet, body, at, sticking)
        return SOLVED
    creeping = np.zeros((count, COLUMNS))
    for k in range(count):
        if sticking[k]:
            creeping[k, LIMIT] = feet[k, LIMIT]
            for i in range(LEVER, OFFSET):
                creeping[k, i] = feet[k, i]
    untouched = count < 0
    _, settled = descend(
        creeping, load, FootLaw(not untouched, 1.0, 1.0, 1.0, 1.0), untouched, 0.0, system
    )
    if not settled:
        return NOT_SOLVED
    _take(feet, body, at, sticking)
    for k in range(count):
        if sticking[k]:
            feet[k, DUAL], feet[k, DUAL + 1] = creeping[k, DUAL], creeping[k, DUAL + 1]
    return SOLVED


@in_place
@compiled
def forces_unique(feet: FloatArray, sticking: BoolArray) -> bool:
    """Whether the balance leaves no freedom to the feet that could push either way."""
    free = 0
    for k in range(feet.shape[0]):
        size = np.sqrt(feet[k, DUAL] ** 2 + feet[k, DUAL + 1] ** 2)
        if sticking[k] and size < feet[k, LIMIT] * (1.0 - EDGE):
            free += 2
    return free <= 3
