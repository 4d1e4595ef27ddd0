"""The second part of a usual tick of a block, compiled: which forces are expected, and which count.

Between the parts filterpy predicts, and numpy multiplies, as they do for a tick by itself.
"""

import numpy as np

from model.compiled import COUNT, FLAG, NUMBER, compile_for, compiled, given, out
from model.estimator.block.places import (
    APART_SHARE,
    COLOUR,
    CONTACT,
    COVARIANCE_BEFORE,
    DOUBT,
    EXPECTED,
    FORCE_NS,
    GYRO_NS,
    HEARD,
    INNOVATION,
    KINDS,
    LAST,
    MEAN_BEFORE,
    MISFIT,
    NORMAL,
    PRODUCT,
    REJECTED,
    ROWS,
    SCALE,
    SHAKE,
    SHAKE_CHANGE,
    SHAKING,
    SHARE,
    SLIP,
    SOURCE_BIAS,
    SOURCE_DOF,
    SOURCE_NIS,
    SOURCE_NS,
    SWAY,
    T_NS,
    TURN,
    matrix,
    vector,
)
from model.estimator.block.predict import FRESH, USE, WHOLE
from model.estimator.gate_kernel import weigh_kernel
from model.estimator.kalman import symmetric_kernel
from model.estimator.measurements import doubt_kernel, feet_stack_kernel
from model.estimator.senses import expect_kernel
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.sources import places_needed
from model.estimator.tolerances import robots_beside
from model.estimator.vibration import MEMORY_S, change_kernel, variance_kernel
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.estimate import FIXED


@compiled
def expect_in_row_kernel(
    k: int, heard: int, predicted: FloatArray, real: FloatArray, whole: IntArray, flags: BoolArray,
    spare: FloatArray, at: IntArray, feet: FloatArray, feet_velocity: FloatArray, mu: FloatArray,
    nothing: FloatArray, least: float, settings: Record, innovation: FloatArray, rows: FloatArray,
    variance: FloatArray, gates: FloatArray, blocks: IntArray,
) -> tuple[int, int]:  # fmt: skip
    """Say what the feet of tick k should carry, and stack the forces where it is time to use some.

    Args:
        k: The tick; all that is known of it so far is in row k + 1.
        heard: Of ``predict_kernel``.
        predicted: Covariance as the filter predicts it, (n, n).
        real: Of ``StateRows``, as are the next three. Out: what is expected, and vibration.
        whole: Out: as before, where nothing is used.
        flags: Out: loaded feet.
        spare: Out: noise of the forces, and what vibration adds.
        at: Of ``Shapes``.
        feet: (T, N, 3) [m].
        feet_velocity: (T, N, 3) [m/s].
        mu: Of the robot file, (N,).
        nothing: Rows of ``Neighbourhood``, all NaN.
        least: Variance of the forces, below which a change is no kick.
        settings: Of ``record_of``.
        innovation: Out: of ``feet_stack_kernel``, as are the next four.
        rows: Out.
        variance: Out.
        gates: Out.
        blocks: Out.

    Returns:
        How many numbers were measured, and in how many blocks; 0 and 0 where none are used.
    """
    legs = mu.size
    size, before, now = FIXED + 2 * legs, real[k], real[k + 1]
    reals, wholes, spares, contact = at[0], at[1], at[3], at[2, CONTACT]
    t_ns, past = whole[k + 1, wholes[T_NS]], whole[k]
    dt_s = (t_ns - past[wholes[T_NS]]) * 1e-9
    covariance = matrix(now, reals[COVARIANCE_BEFORE], size, size)
    symmetric_kernel(predicted, covariance)
    measured = matrix(spare, spares[HEARD], legs, 3)
    answer = matrix(spare, spares[ROWS], 1 + 3 * legs, 6 + 3 * legs)
    expected, loaded = matrix(now, reals[EXPECTED], legs, 3), flags[k + 1, contact : contact + legs]
    standing_in = nothing if heard & WHOLE else answer
    expect_kernel(
        measured, standing_in, answer, flags[k, contact : contact + legs], settings, loaded, expected
    )  # fmt: skip
    for leg in range(legs):
        now[reals[SHARE] + leg] = measured[leg, 2] if heard & FRESH else before[reals[SHARE] + leg]
    _learn_vibration(
        before, now, reals, past, wholes, t_ns, feet[k], measured, heard, least, settings
    )
    turn, turn_change = now[reals[TURN]], now[reals[TURN] + 1]
    variance_kernel(
        feet[k], vector(now, reals[SHAKE], 3), vector(now, reals[SHAKE_CHANGE], 3), turn,
        turn_change, answer, matrix(spare, spares[SLIP], legs, 2), settings,
        vector(spare, spares[SHAKING], 3),
    )  # fmt: skip
    if not heard & USE:
        _nothing_used(before, now, reals, past, whole[k + 1], wholes, legs)
        return 0, 0
    doubt = matrix(spare, spares[DOUBT], legs, 3)
    doubt_kernel(
        expected, matrix(before, reals[EXPECTED], legs, 3), dt_s,
        matrix(spare, spares[APART_SHARE], robots_beside(legs), legs), settings, doubt,
    )  # fmt: skip
    for i in range(rows.shape[0]):
        for j in range(size):
            rows[i, j] = 0.0
    return feet_stack_kernel(
        vector(now, reals[MEAN_BEFORE], size), covariance, measured, feet[k], feet_velocity[k],
        loaded, answer, vector(spare, spares[SWAY], 2), mu, settings, doubt, innovation, rows,
        variance, gates, blocks,
    )  # fmt: skip


@compiled
def _learn_vibration(
    before: FloatArray, now: FloatArray, reals: IntArray, past: IntArray, wholes: IntArray,
    t_ns: int, feet: FloatArray, measured: FloatArray, heard: int, least: float, settings: Record,
) -> None:  # fmt: skip
    """Learn how forces change: ``model.estimator.vibration.learn`` without a gyro."""
    setting = settings[0]
    force, change = vector(now, reals[SHAKE], 3), vector(now, reals[SHAKE_CHANGE], 3)
    force_before = vector(before, reals[SHAKE], 3)
    change_before = vector(before, reals[SHAKE_CHANGE], 3)
    if setting["adaptive"] == 0.0:
        for i in range(3):
            force[i], change[i] = np.nan, 0.0
        now[reals[TURN]], now[reals[TURN] + 1] = np.nan, 0.0
        return
    stale_s, part_s = setting["stale_force_s"], (t_ns - past[wholes[T_NS]]) * 1e-9
    if heard & WHOLE:
        part = min(part_s / MEMORY_S, 1.0)
        change_kernel(feet, measured, force_before, change_before, part, least, force, change)
    else:
        known = not (t_ns - past[wholes[FORCE_NS]]) * 1e-9 > stale_s
        for i in range(3):
            force[i], change[i] = force_before[i] if known else np.nan, change_before[i]
    now[reals[TURN]], now[reals[TURN] + 1] = before[reals[TURN]], before[reals[TURN] + 1]
    if (t_ns - past[wholes[GYRO_NS]]) * 1e-9 > stale_s:
        now[reals[TURN]] = np.nan


@compiled
def _nothing_used(
    before: FloatArray, now: FloatArray, reals: IntArray, past: IntArray, present: IntArray,
    wholes: IntArray, legs: int,
) -> None:  # fmt: skip
    """What is known of the sources stays as it was."""
    for name in (PRODUCT, NORMAL, MISFIT, SCALE, COLOUR):
        for i in range(KINDS):
            now[reals[name] + i] = before[reals[name] + i]
    for name in (LAST, SOURCE_BIAS):
        for i in range(places_needed(legs)):
            now[reals[name] + i] = before[reals[name] + i]
    for i in range(KINDS):
        present[wholes[SOURCE_NS] + i] = past[wholes[SOURCE_NS] + i]
    for i in range(KINDS * legs):
        present[wholes[REJECTED] + i] = past[wholes[REJECTED] + i]


@compiled
def weigh_in_row_kernel(
    k: int, count: int, made: int, spread: FloatArray, left: FloatArray, noise: FloatArray,
    seen: FloatArray, room: IntArray, real: FloatArray, whole: IntArray, at: IntArray,
    innovation: FloatArray, rows: FloatArray, variance: FloatArray, gates: FloatArray,
    blocks: IntArray, settings: Record,
) -> tuple[int, int, float, float]:  # fmt: skip
    """Gate what was measured in tick k, and learn what its sources are worth.

    Args:
        k: The tick.
        count: How many numbers were measured.
        made: In how many blocks.
        spread: H P H', (count, count).
        left: Out: of ``weigh_kernel``, as are the next two, (count,).
        noise: Out: (count, count).
        seen: Out: (count, n).
        room: Work space, 3 m numbers.
        real: Of ``StateRows``, as is the next. Out: the memory of sources in row k + 1.
        whole: Out: rejections in a row.
        at: Of ``Shapes``.
        innovation: Of ``expect_in_row_kernel``, as are the next four.
        rows: (m, n).
        variance: (m,).
        gates: (B,).
        blocks: (B, 3).
        settings: Of ``record_of``.

    Returns:
        What ``gate_kernel`` returns.
    """
    reals, wholes, before, now = at[0], at[1], real[k], real[k + 1]
    past, present = whole[k], whole[k + 1]
    legs = (rows.shape[1] - FIXED) // 2
    places = places_needed(legs)
    return weigh_kernel(
        innovation[:count], rows[:count], variance[:count], gates[:made], blocks[:made], spread,
        present[wholes[T_NS]], settings, vector(past, wholes[SOURCE_NS], KINDS),
        vector(before, reals[PRODUCT], KINDS), vector(before, reals[NORMAL], KINDS),
        vector(before, reals[LAST], places), vector(before, reals[SOURCE_BIAS], places),
        vector(before, reals[MISFIT], KINDS), vector(before, reals[SCALE], KINDS),
        vector(before, reals[COLOUR], KINDS), matrix(past, wholes[REJECTED], KINDS, legs),
        vector(present, wholes[SOURCE_NS], KINDS), vector(now, reals[PRODUCT], KINDS),
        vector(now, reals[NORMAL], KINDS), vector(now, reals[LAST], places),
        vector(now, reals[SOURCE_BIAS], places), vector(now, reals[MISFIT], KINDS),
        vector(now, reals[SCALE], KINDS), vector(now, reals[COLOUR], KINDS),
        matrix(present, wholes[REJECTED], KINDS, legs), left, noise, seen,
        matrix(now, reals[INNOVATION], legs, 3), vector(now, reals[SOURCE_NIS], KINDS),
        vector(present, wholes[SOURCE_DOF], KINDS), matrix(room, 0, 3, count),
    )  # fmt: skip


def prepare() -> None:
    """Load or make the machine code now; that of the filter has to be there already."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        expect_in_row_kernel, COUNT, COUNT, *out(2, 2), *out(2, kind=COUNT), *out(2, kind=FLAG),
        *out(1), *given(2, kind=COUNT), *given(3, 3, 1), *out(2), NUMBER, settings, *out(1, 2, 1, 1),
        *out(2, kind=COUNT),
    )  # fmt: skip
    compile_for(
        weigh_in_row_kernel, COUNT, COUNT, COUNT, *out(2, 1, 2, 2), *out(1, kind=COUNT), *out(2),
        *out(2, kind=COUNT), *given(2, kind=COUNT), *out(1, 2, 1, 1), *out(2, kind=COUNT), settings,
    )  # fmt: skip
