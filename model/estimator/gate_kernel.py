"""Which numbers of a measurement are used, compiled: gates, noise, and how well what is used fits.

Each block of numbers passes a gate of its own, or not, as a whole. What passes is laid out over its
standard deviation: then S is a matrix of correlations, which has an inverse whatever the units.
"""

import numpy as np

from model.compiled import COUNT, compile_for, compiled, given, in_place, out
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.sources import FORCE, LOAD, NO_SOURCE, learn_kernel, place_kernel
from model.values.arrays import FloatArray, IntArray

MOST_AT_A_GATE = 4.0  # variance over that of the settings
FARTHEST = 1e100  # normalised innovation squared of what no noise explains


@compiled
def weigh_kernel(
    innovation: FloatArray, rows: FloatArray, variance: FloatArray, gates: FloatArray,
    blocks: IntArray, spread: FloatArray, t_ns: int, settings: Record, heard_before: IntArray,
    product_before: FloatArray, normal_before: FloatArray, last_before: FloatArray,
    bias_before: FloatArray, misfit_before: FloatArray, scale_before: FloatArray,
    colour_before: FloatArray, streak_before: IntArray, heard_ns: IntArray, product: FloatArray,
    mean_normal: FloatArray, last: FloatArray, bias: FloatArray, misfit: FloatArray,
    scale: FloatArray, colour: FloatArray, streak: IntArray, left: FloatArray, noise: FloatArray,
    seen: FloatArray, normal: FloatArray, nis: FloatArray, dof: IntArray, spare: IntArray,
) -> tuple[int, int, float, float]:  # fmt: skip
    """Gate a measurement, and learn what its sources are worth: what comes before an update, in one call.

    Args:
        innovation: Of ``gate_kernel``, as are the next five.
        rows: (m, n).
        variance: (m,).
        gates: (B,).
        blocks: (B, 3).
        spread: (m, m).
        t_ns: Time of the tick.
        settings: Of ``record_of``.
        heard_before: The memory of sources before, eight arrays, of ``learn_kernel``.
        product_before: (S,).
        normal_before: (S,).
        last_before: Of each number.
        bias_before: Of each number.
        misfit_before: (S,).
        scale_before: (S,).
        colour_before: (S,).
        streak_before: Rejections in a row, (S, N).
        heard_ns: Out: the memory now, with the next seven.
        product: Out.
        mean_normal: Out.
        last: Out.
        bias: Out.
        misfit: Out.
        scale: Out.
        colour: Out.
        streak: Out: rejections in a row now, (S, N).
        left: Out: of ``gate_kernel``, with the next five.
        noise: Out: (m, m).
        seen: Out: (m, n).
        normal: Out: (N, 3).
        nis: Out: (S,).
        dof: Out: (S,).
        spare: Work space, (3, m).

    Returns:
        What ``gate_kernel`` returns.
    """
    count, legs = innovation.size, streak.shape[1]
    source, place, chosen = spare[0], spare[1], spare[2]
    expected = np.empty(count)
    place_kernel(blocks, legs, source, place)
    for kind in range(streak.shape[0]):
        nis[kind] = np.nan
        for leg in range(legs):
            streak[kind, leg] = streak_before[kind, leg]
    for leg in range(legs):
        normal[leg, 0], normal[leg, 1], normal[leg, 2] = np.nan, np.nan, np.nan
    for i in range(count):
        for j in range(count):
            noise[i, j] = 0.0
    setting = settings[0]
    rejects, used, fit, volume = gate_kernel(
        innovation, rows, variance, gates, blocks, spread, source, scale_before, colour_before,
        setting["least_weight"], int(setting["reject_limit"]), streak, expected, left, noise, seen,
        normal, nis, dof, chosen,
    )  # fmt: skip
    learn_kernel(
        source, place, innovation, expected, variance, t_ns, settings, heard_before, product_before,
        normal_before, last_before, bias_before, misfit_before, scale_before, colour_before, heard_ns,
        product, mean_normal, last, bias, misfit, scale, colour,
    )  # fmt: skip
    return rejects, used, fit, volume


@compiled
def gate_kernel(
    innovation: FloatArray, rows: FloatArray, variance: FloatArray, gates: FloatArray,
    blocks: IntArray, spread: FloatArray, source: IntArray, scale: FloatArray, colour: FloatArray,
    least: float, reject_limit: int, streak: IntArray, expected: FloatArray, left: FloatArray,
    noise: FloatArray, seen: FloatArray, normal: FloatArray, nis: FloatArray, dof: IntArray,
    chosen: IntArray,
) -> tuple[int, int, float, float]:  # fmt: skip
    """Gate a measurement of m numbers, and lay out what is used of it.

    Args:
        innovation: Of ``MeasurementStack``, as are the next four.
        rows: (m, n).
        variance: (m,).
        gates: (B,).
        blocks: (B, 3).
        spread: H P H', (m, m).
        source: Of each number, -1 for none, (m,).
        scale: Of ``SourceMemory``, (S,).
        colour: Of ``SourceMemory``, (S,).
        least: Smallest variance with which a source weighs in, over that of the settings.
        reject_limit: Rejections in a row after which a block is used.
        streak: In and out: rejections in a row by source and leg, (S, N).
        expected: Out: variance of the innovation by the state's covariance alone, (m,).
        left: Out: of the k numbers that are used the innovation over its sd, the first k of (m,).
        noise: In: zero, out: R of these, (m, m).
        seen: Out: H of these, (m, n).
        normal: In: NaN, out: innovation of the feet's forces over its sd, (N, 3).
        nis: In: NaN, out: normalised innovation squared of each source by itself, (S,).
        dof: Out: its numbers, (S,).
        chosen: Work space, (m,): whole numbers made here would cost the compiler a third of a second.

    Returns:
        How many blocks did not pass at first, k, the normalised innovation squared of all k numbers, and
        the logarithm of the determinant of their covariance.
    """
    count = innovation.size
    known, weighed, more = np.empty(count), np.empty(count), np.zeros(count)
    at_gate, used = np.empty(count), np.empty(count)
    work = np.empty((count + 1, count))
    for i in range(count):
        kind = source[i]
        size, counted = 1.0, 1.0
        if kind != NO_SOURCE:
            size, counted = scale[kind], colour[kind]
        # as learned, and as it weighs in, since errors last
        known[i] = variance[i] * size
        weighed[i] = variance[i] * max(size * counted, least)
        expected[i] = spread[i, i]
        # a gate does not get used to all that it sees
        at_gate[i] = spread[i, i] + min(weighed[i], MOST_AT_A_GATE * variance[i])
    rejects = 0
    for block in range(blocks.shape[0]):
        first, kind, leg = blocks[block, 0], blocks[block, 1], blocks[block, 2]
        end = blocks[block + 1, 0] if block + 1 < blocks.shape[0] else count
        distance = _distance(innovation, spread, at_gate, first, end, chosen, work)
        passed = distance <= gates[block]
        insists = kind != NO_SOURCE and streak[kind, leg] >= reject_limit and distance < FARTHEST
        for i in range(first, end):
            used[i] = 1.0 if passed or insists else 0.0
            if not passed and insists:
                # brings one number exactly to the gate, a pair near it
                more[i] = (distance / gates[block] - 1.0) * at_gate[i]
        if not passed:
            rejects += 1
        if kind != NO_SOURCE:
            streak[kind, leg] = 0 if passed else streak[kind, leg] + 1
    number = 0
    for i in range(count):
        total = expected[i] + known[i] + more[i]
        if used[i] > 0.0:
            sd = np.sqrt(expected[i] + weighed[i] + more[i])
            left[number] = innovation[i] / sd
            noise[number, number] = (weighed[i] + more[i]) / sd**2
            for j in range(rows.shape[1]):
                seen[number, j] = rows[i, j] / sd
            chosen[number] = i
            number += 1
        known[i] = total  # from here on the variance of what is used
    for block in range(blocks.shape[0]):
        first, kind, leg = blocks[block, 0], blocks[block, 1], blocks[block, 2]
        if kind == LOAD and used[first] > 0.0:
            normal[leg, 2] = innovation[first] / np.sqrt(known[first])
        elif kind == FORCE and used[first] > 0.0:
            normal[leg, 0] = innovation[first] / np.sqrt(known[first])
            normal[leg, 1] = innovation[first + 1] / np.sqrt(known[first + 1])
    fit, volume = _fit(innovation, spread, known, chosen, number, work)
    for kind in range(nis.size):
        own = 0
        for i in range(count):
            if used[i] > 0.0 and source[i] == kind:
                chosen[own] = i
                own += 1
        dof[kind] = own
        if own > 0:
            nis[kind], _ = _fit(innovation, spread, known, chosen, own, work)
    return rejects, number, fit, volume


@in_place
@compiled
def _distance(
    innovation: FloatArray, spread: FloatArray, variance: FloatArray, first: int, end: int,
    chosen: IntArray, work: FloatArray,
) -> float:  # fmt: skip
    """Normalised innovation squared of a block; infinite where its covariance is none."""
    total = 0.0
    for i in range(first, end):
        total += variance[i]
        chosen[i - first] = i
    if not abs(total) < np.inf:
        return np.inf
    if end - first == 1:
        one: float = innovation[first] * innovation[first] / variance[first]
        return one
    if end - first == 2:
        x, y, beside = innovation[first], innovation[first + 1], spread[first, first + 1]
        xx, yy = variance[first], variance[first + 1]
        volume = xx * yy - beside * beside
        if not volume > 0.0:
            return np.inf
        pair: float = (yy * x * x - 2.0 * beside * x * y + xx * y * y) / volume
        return pair
    distance, _ = _fit(innovation, spread, variance, chosen, end - first, work)
    return distance


@in_place
@compiled
def _fit(
    innovation: FloatArray, spread: FloatArray, variance: FloatArray, chosen: IntArray, count: int,
    work: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Normalised innovation squared of chosen numbers, and the logarithm of S's determinant.

    Args:
        innovation: Of all, (m,).
        spread: Its covariance but for the diagonal, (m, m).
        variance: That diagonal, (m,).
        chosen: Which numbers, the first ``count`` of (m,).
        count: How many.
        work: Space for the factor of the correlations and a row more, (m + 1, m).
    """
    fit, volume = 0.0, 0.0
    solved = work[work.shape[0] - 1]
    for i in range(count):
        sd = np.sqrt(variance[chosen[i]])
        total = innovation[chosen[i]] / sd
        for j in range(i + 1):
            entry = 1.0
            if j < i:
                entry = spread[chosen[i], chosen[j]] / (sd * np.sqrt(variance[chosen[j]]))
            for m in range(j):
                entry -= work[i, m] * work[j, m]
            work[i, j] = np.sqrt(entry) if j == i else entry / work[j, j]
        for j in range(i):
            total -= work[i, j] * solved[j]
        solved[i] = total / work[i, i]
        fit += solved[i] ** 2
        volume += np.log(variance[chosen[i]]) + 2.0 * np.log(work[i, i])
    return fit, volume


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        weigh_kernel, *given(1, 2, 1, 1), *given(2, kind=COUNT), *given(2), COUNT, settings,
        *given(1, kind=COUNT), *given(1, 1, 1, 1, 1, 1, 1), *given(2, kind=COUNT),
        *out(1, kind=COUNT), *out(1, 1, 1, 1, 1, 1, 1), *out(2, kind=COUNT), *out(1, 2, 2, 2, 1),
        *out(1, kind=COUNT), *out(2, kind=COUNT),
    )  # fmt: skip
