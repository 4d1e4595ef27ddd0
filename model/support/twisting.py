"""Support of a body whose chassis twists: rows of legs that roll against its middle.

The chassis is a bar along x that gives evenly. Legs that push a row aside roll it, its feet rise or sink by
that, and so do their loads: angles of rows and loads are found together, frame by frame, by Broyden's
method. It starts from a slope that is never too small, as rows turn against the springs of their legs.
"""

from functools import cache

import numpy as np

from model.compiled import COUNT, NUMBER, compile_for, compiled, given, in_place, out
from model.support.frames import SupportSolutions, answers_for, check_support
from model.support.kernel import NO_CONVERGENCE, ROWS, support_kernel
from model.values.arrays import FloatArray, IntArray, readonly

STEPS = 40
CONVERGED_RAD = 1e-11
NEVER_MOVED = 1e-24


def twist_of_rows(shaft_x: FloatArray, twist_rad_nm: float) -> tuple[IntArray, FloatArray]:
    """Row of each leg, (N,), and how far rows roll against the middle for moments, (K, K) [rad/(N m)].

    What the chassis carries between two rows is the moment of all legs beyond. A moment on the front row
    and its opposite on the rear one roll them apart by ``twist_rad_nm`` for each N m.

    Args:
        shaft_x: Where legs are along the chassis, (N,) [m].
        twist_rad_nm: How far the front rolls against the rear.
    """
    places, row = np.unique(np.round(shaft_x, 3), return_inverse=True)
    away = places - (places[0] + places[-1]) / 2
    same_side = np.sign(away)[:, None] == np.sign(away)
    shared = np.where(same_side, np.minimum(np.abs(away)[:, None], np.abs(away)), 0.0)
    give: FloatArray = twist_rad_nm * shared / max(float(np.ptp(places)), 1e-9)
    return row, give


def solve_twisting_support(
    feet_m: FloatArray,
    ground_m: FloatArray,
    stiffness_n_m: FloatArray,
    weight_n: float,
    aside_m: FloatArray,
    twist: tuple[IntArray, FloatArray],
) -> tuple[SupportSolutions, FloatArray]:
    """Find the balance of each frame, and the angle by which each row rolls, (F, K) [rad].

    A chassis that rolls several times as far as its legs give may have no answer; its frames say so.

    Args:
        feet_m: Unloaded feet, seen from the centre of mass, (F, N, 3).
        ground_m: Height of the ground under each foot, (F or 1, N).
        stiffness_n_m: Leg springs, (N,), positive.
        weight_n: Weight carried, positive.
        aside_m: Distance of each foot from the axis that rows roll about, along y, (F, N).
        twist: Of ``twist_of_rows``.

    Raises:
        ModelError: Shapes do not fit, or a stiffness or the weight is not positive.
    """
    check_support(feet_m, ground_m, stiffness_n_m, weight_n)
    row, give = twist
    rows = np.arange(len(give))
    arm = np.where(row[None, :, None] == rows, aside_m[..., None], 0.0)
    turned = (stiffness_n_m[:, None] * arm**2).sum(axis=1)
    inverse = np.linalg.inv(np.eye(len(give)) + give * turned[:, None, :])
    answer = answers_for(*feet_m.shape[:2])
    angle = np.zeros((len(feet_m), len(give)))
    _prepare()
    read = (np.broadcast_to(ground_m, aside_m.shape), stiffness_n_m, aside_m, give)
    ground, stiffness, aside, give = (np.ascontiguousarray(each, np.float64) for each in read)
    moved = np.array(feet_m, np.float64, order="C")  # with the rows that roll
    _solve(moved, ground, stiffness, float(weight_n), aside, row, give, inverse, angle, *answer)
    for values in answer:
        readonly(values)
    return answer, angle


@compiled
def _solve(
    feet: FloatArray, ground: FloatArray, stiffness: FloatArray, weight: float,
    aside: FloatArray, row: IntArray, give: FloatArray, inverse: FloatArray, angle: FloatArray,
    pose: FloatArray, loads: FloatArray, switches: IntArray, reason: IntArray,
) -> None:  # fmt: skip
    frames, count = aside.shape
    rows = give.shape[0]
    work = np.empty((ROWS, count))
    new, step, change = np.empty(rows), np.empty(rows), np.empty((2, rows))
    for f in range(frames):
        at, slope = angle[f], inverse[f]
        for steps in range(STEPS + 1):
            status = support_kernel(feet[f], ground[f], stiffness, weight, pose[f], loads[f], work)
            switches[f], reason[f] = max(status, 0), max(-status, 0)
            for i in range(rows):
                new[i] = at[i]
            if status >= 0:
                for k in range(count):
                    for i in range(rows):
                        new[i] -= give[row[k], i] * aside[f, k] * loads[f, k]
            if steps > 0:
                _learn(slope, step, new, change)
            most = 0.0
            for i in range(rows):
                step[i] = 0.0
                for j in range(rows):
                    step[i] -= slope[i, j] * new[j]
                most = max(most, abs(step[i]))
            if not most > CONVERGED_RAD:
                break
            if steps == STEPS:
                reason[f] = -NO_CONVERGENCE
                break
            for i in range(rows):
                at[i] += step[i]
            for k in range(count):
                feet[f, k, 2] += aside[f, k] * step[row[k]]
        if reason[f] > 0:
            pose[f, :] = np.nan
            loads[f, :] = np.nan


@in_place
@compiled
def _learn(inverse: FloatArray, step: FloatArray, left: FloatArray, work: FloatArray) -> None:
    """Change an inverse slope so that it maps the change that a step made to that step."""
    rows = len(step)
    along, size = 0.0, 0.0
    for i in range(rows):
        work[0, i] = 0.0
        for j in range(rows):
            work[0, i] += inverse[i, j] * left[j]
        along += step[i] * work[0, i]
        size += step[i] ** 2
    if not abs(size + along) > NEVER_MOVED:
        return
    for j in range(rows):
        back = 0.0
        for i in range(rows):
            back += step[i] * inverse[i, j]
        work[1, j] = back / (size + along)
    for i in range(rows):
        for j in range(rows):
            inverse[i, j] -= work[0, i] * work[1, j]


@cache
def _prepare() -> None:
    """Compile for the arrays that are handed over above, and for nothing else after."""
    compile_for(
        _solve, *out(3), *given(2, 1), NUMBER, *given(2), *given(1, kind=COUNT), *given(2),
        *out(3, 2), *out(2, 2), *out(1, 1, kind=COUNT),
    )  # fmt: skip
