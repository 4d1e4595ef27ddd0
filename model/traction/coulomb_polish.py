"""From nearly to exactly: the smooth problem that remains once the feet at rest are known.

With no foot at rest it is Newton's method in three unknowns, with one a rotation about that foot, with
several nothing is left but the forces, of which infinitely many balance: the least ones (each measured
by its own cone) are taken if they lie inside the cones.
"""

import numpy as np

from model.compiled import compiled
from model.traction.coulomb_kernel import slips, solve3
from model.values.arrays import BoolArray, FloatArray

NEWTON_STEPS = 12
BALANCED = 1e-13  # sum of forces, share of the sum of the limits
FLAT = 1e-10  # curvature below this share: the velocity is one of many
RIGID = 1e-10  # slip of feet that are said to rest together
EDGE = 1e-9  # a force this near its cone, as a share, counts as on it
NOT_SOLVED = 0
SOLVED = 1
SOLVED_FLAT = 2  # solved, but the velocity is one of many


@compiled
def classify(limit: FloatArray, dual: FloatArray, slip: FloatArray, sticking: BoolArray) -> int:
    """Tell feet at rest from sliding ones; return how many rest.

    At a gap g either the slip is below g / (c - |y|) or the force within g / |slip| of its cone, so
    the two are compared with each other and no threshold is needed.
    """
    resting = 0
    for k in range(limit.size):
        speed = np.sqrt(slip[k, 0] ** 2 + slip[k, 1] ** 2)
        room = 1.0 - np.sqrt(dual[k, 0] ** 2 + dual[k, 1] ** 2) / limit[k]
        sticking[k] = speed < room
        resting += sticking[k]
    return resting


@compiled
def polish(
    levers: FloatArray,
    offset: FloatArray,
    limit: FloatArray,
    twist: FloatArray,
    dual: FloatArray,
    slip: FloatArray,
    sticking: BoolArray,
    resting: int,
) -> int:
    """Solve for given feet at rest; outputs are changed only where the answer proves right.

    Args:
        levers: As in ``model.traction.coulomb_kernel.descend``, with the next five.
        offset: (N, 2).
        limit: (N,).
        twist: In: start, out: body velocity, (3,).
        dual: In: any (used with several feet at rest), out: y, (N, 2).
        slip: Out: (N, 2), exactly 0 for feet at rest.
        sticking: Feet at rest, (N,).
        resting: How many they are.
    """
    if resting == 0:
        return _all_slide(levers, offset, limit, twist, dual, slip, sticking)
    if resting == 1:
        return _about_one_foot(levers, offset, limit, twist, dual, slip, sticking)
    return _several_rest(levers, offset, limit, twist, dual, slip, sticking)


@compiled
def _gradient(
    levers: FloatArray,
    limit: FloatArray,
    slip: FloatArray,
    sticking: BoolArray,
    matrix: FloatArray,
    gradient: FloatArray,
) -> bool:
    """Gradient and Hessian of the sliding feet's power; False if one of them does not slide."""
    for i in range(3):
        gradient[i] = 0.0
        for j in range(3):
            matrix[i, j] = 0.0
    for k in range(limit.size):
        if sticking[k]:
            continue
        speed = np.sqrt(slip[k, 0] ** 2 + slip[k, 1] ** 2)
        if speed <= 1e-12:
            return False
        e0, e1 = slip[k, 0] / speed, slip[k, 1] / speed
        bend = limit[k] / speed
        for i in range(3):
            gradient[i] += limit[k] * (levers[k, 0, i] * e0 + levers[k, 1, i] * e1)
            across_i = levers[k, 1, i] * e0 - levers[k, 0, i] * e1
            for j in range(3):
                across_j = levers[k, 1, j] * e0 - levers[k, 0, j] * e1
                matrix[i, j] += bend * across_i * across_j
    return True


@compiled
def _take(
    limit: FloatArray, slip: FloatArray, sticking: BoolArray, new: FloatArray, dual: FloatArray
) -> None:
    """Put slip and the forces of sliding feet in place; feet at rest have no slip at all."""
    for k in range(limit.size):
        if sticking[k]:
            slip[k, 0] = slip[k, 1] = 0.0
        else:
            slip[k, 0], slip[k, 1] = new[k, 0], new[k, 1]
            speed = np.sqrt(new[k, 0] ** 2 + new[k, 1] ** 2)
            dual[k, 0] = limit[k] * new[k, 0] / speed
            dual[k, 1] = limit[k] * new[k, 1] / speed


@compiled
def _all_slide(
    levers: FloatArray, offset: FloatArray, limit: FloatArray, twist: FloatArray, dual: FloatArray,
    slip: FloatArray, none: BoolArray,
) -> int:  # fmt: skip
    room = np.empty((6, 3))
    matrix, gradient, step, at = room[:3], room[3], room[4], room[5]
    new = np.empty((limit.size, 2))
    at[0], at[1], at[2] = twist[0], twist[1], twist[2]
    for _ in range(NEWTON_STEPS):
        slips(levers, offset, at, new)
        if not _gradient(levers, limit, new, none, matrix, gradient):
            return NOT_SOLVED
        size = max(abs(gradient[0]), abs(gradient[1]), abs(gradient[2]))
        if size <= 0.01 * BALANCED:
            break
        if _smallest_pivot(matrix) <= FLAT:
            # a way to move that changes no force: stay where the interior method put us on it
            top = max(matrix[0, 0], matrix[1, 1], matrix[2, 2])
            for i in range(3):
                matrix[i, i] += 1e3 * FLAT * top
        for i in range(3):
            gradient[i] = -gradient[i]
        if not solve3(matrix, gradient, step):
            return NOT_SOLVED
        for i in range(3):
            at[i] += step[i]
    slips(levers, offset, at, new)
    if not _gradient(levers, limit, new, none, matrix, gradient):
        return NOT_SOLVED
    if not max(abs(gradient[0]), abs(gradient[1]), abs(gradient[2])) <= BALANCED:
        return NOT_SOLVED
    flat = _smallest_pivot(matrix) <= FLAT
    twist[0], twist[1], twist[2] = at[0], at[1], at[2]
    _take(limit, slip, none, new, dual)
    return SOLVED_FLAT if flat else SOLVED


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


@compiled
def _about_one_foot(
    levers: FloatArray, offset: FloatArray, limit: FloatArray, twist: FloatArray, dual: FloatArray,
    slip: FloatArray, sticking: BoolArray,
) -> int:  # fmt: skip
    count = limit.size
    foot = 0
    for k in range(count):
        if sticking[k]:
            foot = k
    # L (v + w e + q') = 0 with A = L [I, e]: v follows from w
    a, b = levers[foot, 0, 0], levers[foot, 0, 1]
    c, d = levers[foot, 1, 0], levers[foot, 1, 1]
    det = a * d - b * c
    e0 = (d * levers[foot, 0, 2] - b * levers[foot, 1, 2]) / det
    e1 = (a * levers[foot, 1, 2] - c * levers[foot, 0, 2]) / det
    h0 = (d * offset[foot, 0] - b * offset[foot, 1]) / det
    h1 = (a * offset[foot, 1] - c * offset[foot, 0]) / det
    room = np.empty((5, 3))
    matrix, gradient, at = room[:3], room[3], room[4]
    new = np.empty((count, 2))
    turn = twist[2]
    curvature = 0.0
    flat = False
    for _ in range(NEWTON_STEPS):
        at[0], at[1], at[2] = -h0 - turn * e0, -h1 - turn * e1, turn
        slips(levers, offset, at, new)
        if not _gradient(levers, limit, new, sticking, matrix, gradient):
            return NOT_SOLVED
        # along (-e0, -e1, 1)
        slope = gradient[2] - e0 * gradient[0] - e1 * gradient[1]
        curvature = (
            matrix[2, 2]
            + e0 * (e0 * matrix[0, 0] + 2.0 * e1 * matrix[0, 1] - 2.0 * matrix[0, 2])
            + e1 * (e1 * matrix[1, 1] - 2.0 * matrix[1, 2])
        )
        if abs(slope) <= 0.01 * BALANCED:
            break
        flat = curvature <= FLAT
        if flat:
            break
        turn -= slope / curvature
    at[0], at[1], at[2] = -h0 - turn * e0, -h1 - turn * e1, turn
    slips(levers, offset, at, new)
    if not _gradient(levers, limit, new, sticking, matrix, gradient):
        return NOT_SOLVED
    slope = gradient[2] - e0 * gradient[0] - e1 * gradient[1]
    # its force balances the others: A^T y = -gradient, of which the first two rows are L^T y
    y0 = -(d * gradient[0] - c * gradient[1]) / det
    y1 = -(a * gradient[1] - b * gradient[0]) / det
    if not (abs(slope) <= BALANCED and y0 * y0 + y1 * y1 <= limit[foot] ** 2):
        return NOT_SOLVED
    twist[0], twist[1], twist[2] = at[0], at[1], at[2]
    _take(limit, slip, sticking, new, dual)
    dual[foot, 0], dual[foot, 1] = y0, y1
    return SOLVED_FLAT if flat or curvature <= FLAT else SOLVED


@compiled
def _several_rest(
    levers: FloatArray, offset: FloatArray, limit: FloatArray, twist: FloatArray, dual: FloatArray,
    slip: FloatArray, sticking: BoolArray,
) -> int:  # fmt: skip
    count = limit.size
    matrix = np.zeros((3, 3))
    right = np.zeros(3)
    at = np.empty(3)
    new = np.empty((count, 2))
    for k in range(count):
        if sticking[k]:
            for i in range(3):
                for m in range(2):
                    right[i] -= limit[k] * levers[k, m, i] * offset[k, m]
                    for j in range(3):
                        matrix[i, j] += limit[k] * levers[k, m, i] * levers[k, m, j]
    if not solve3(matrix, right, at):
        return NOT_SOLVED
    slips(levers, offset, at, new)
    for k in range(count):
        if sticking[k] and max(abs(new[k, 0]), abs(new[k, 1])) > RIGID:
            return NOT_SOLVED
    hessian = np.empty((3, 3))
    load = np.empty(3)
    if not _gradient(levers, limit, new, sticking, hessian, load):
        return NOT_SOLVED
    if _least_forces(levers, limit, sticking, load, dual, False, new) or _least_forces(
        levers, limit, sticking, load, dual, True, new
    ):
        twist[0], twist[1], twist[2] = at[0], at[1], at[2]
        for k in range(count):
            if sticking[k]:
                dual[k, 0], dual[k, 1] = new[k, 0], new[k, 1]
        slips(levers, offset, at, new)
        _take(limit, slip, sticking, new, dual)
        return SOLVED
    return NOT_SOLVED


@compiled
def _least_forces(
    levers: FloatArray, limit: FloatArray, sticking: BoolArray, load: FloatArray, dual: FloatArray,
    near: bool, out: FloatArray,
) -> bool:  # fmt: skip
    """Forces of the feet at rest that balance ``load``; True if all lie in their cones.

    The least in sum |y|^2 / c^2, or with ``near`` the least change from ``dual``. Only rows of feet
    at rest are written, to ``out``, which keeps the slips of the others.
    """
    count = limit.size
    matrix = np.zeros((3, 3))
    rest = np.empty(3)
    give = np.empty(3)
    for i in range(3):
        rest[i] = -load[i]
    for k in range(count):
        if sticking[k]:
            for i in range(3):
                for m in range(2):
                    if near:
                        rest[i] -= levers[k, m, i] * dual[k, m]
                    for j in range(3):
                        matrix[i, j] += limit[k] ** 2 * levers[k, m, i] * levers[k, m, j]
    if not solve3(matrix, rest, give):
        return False
    for k in range(count):
        if sticking[k]:
            for m in range(2):
                y = dual[k, m] if near else 0.0
                for j in range(3):
                    y += limit[k] ** 2 * levers[k, m, j] * give[j]
                out[k, m] = y
            if out[k, 0] ** 2 + out[k, 1] ** 2 > limit[k] ** 2:
                return False
    return True


@compiled
def forces_unique(limit: FloatArray, dual: FloatArray, sticking: BoolArray) -> bool:
    """Whether the balance leaves no freedom to the feet that could push either way."""
    free = 0
    for k in range(limit.size):
        size = np.sqrt(dual[k, 0] ** 2 + dual[k, 1] ** 2)
        if sticking[k] and size < limit[k] * (1.0 - EDGE):
            free += 2
    return free <= 3
