"""filterpy's Kalman filter behind two functions on plain arrays: an extended filter in error-state form.

filterpy's own ``predict`` and ``update`` do the arithmetic. Its state is the error of the mean, 0 before
each of them, as the mean itself moves by a model that is not linear. Gates, and a covariance that stays
symmetric and positive definite, are settled here; nothing else in the program knows filterpy.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import inf, isfinite, log, tau
from typing import NamedTuple

import numpy as np

from model.estimator import sources as source
from model.estimator.settings import EstimatorSettings, record_of
from model.estimator.sources import FORCE, LOAD, NO_SOURCE, NumberPlaces
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.estimate import SOURCES, SourceMemory

LOG_TURN = log(tau)
MOST_AT_A_GATE = 4.0  # variance over that of the settings
FARTHEST = 1e100  # normalised innovation squared of what no noise explains


class MeasurementStack(NamedTuple):
    """A measurement of m numbers in B blocks, each of which is used or rejected as a whole.

    Attributes:
        innovation: Measured less expected, angles wrapped already, (m,).
        rows: H, (m, n).
        variance: Of the noise, independent from number to number, (m,).
        gates: Largest normalised innovation squared of each block, (B,); infinite for none.
        blocks: Of each block: its first number, source (-1 for none) and leg or axis, (B, 3).
    """

    innovation: FloatArray
    rows: FloatArray
    variance: FloatArray
    gates: FloatArray
    blocks: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Updated:
    """Mean and covariance after a measurement, and how it fitted.

    Attributes:
        mean: (n,).
        covariance: P, (n, n).
        nis: Normalised innovation squared of what was used; NaN if nothing was.
        source_nis: The same by source, (S,); NaN where nothing was used.
        source_dof: Numbers used of each, (S,).
        log_likelihood: Of the innovation of what was used; NaN if nothing was.
        numbers: How many numbers were used.
        rejects: Blocks that did not pass their gates at first.
        streak: Rejections in a row by source and leg, (S, N).
        innovation: Of the feet's forces over the sd that the filter gives them, (N, 3); NaN where
            none was used.
        sources: What is known of the sources now.
    """

    mean: FloatArray
    covariance: FloatArray
    nis: float
    source_nis: FloatArray
    source_dof: IntArray
    log_likelihood: float
    numbers: int
    rejects: int
    streak: IntArray
    innovation: FloatArray
    sources: SourceMemory


class Kalman:
    """Prediction and update for a state of fixed size; holds no belief of its own between calls.

    Args:
        size: Number of states n.
        first_limited: Place of the first state that is limited; all after it are.
        settings: Rejections in a row after which a block is used with more noise, largest size of
            limited states, bounds of what is learned.
    """

    def __init__(self, size: int, first_limited: int, settings: EstimatorSettings) -> None:
        from filterpy.kalman import KalmanFilter  # a second, which not every command needs

        self._settings, self._first_limited = settings, first_limited
        self._record = record_of(settings, 1.0)
        self._reject_limit, self._limit = settings.reject_limit, settings.parameter_limit
        self._filter = KalmanFilter(size, 1)
        self._no_error = readonly(np.zeros(size))

    def predict(
        self, covariance: FloatArray, transition: FloatArray, noise: FloatArray
    ) -> FloatArray:
        """Covariance F P F' + Q of a predicted mean, exactly symmetric.

        Args:
            covariance: P before, (n, n).
            transition: F, (n, n).
            noise: Q, (n, n).
        """
        error = self._filter
        error.x, error.P, error.F, error.Q = self._no_error, covariance, transition, noise
        error.predict()
        return symmetric(error.P)

    def update(
        self,
        mean: FloatArray,
        covariance: FloatArray,
        stack: MeasurementStack | None,
        streak: IntArray,
        sources: SourceMemory,
        t_ns: int,
    ) -> Updated:
        """Gate each block by its own normalised innovation, and use what passes at once.

        After a row of rejections a block is used again with as much more noise as brings it to its
        gate: a filter that never uses its sensors again is worse than one that doubts them.

        Args:
            mean: (n,).
            covariance: P, (n, n).
            stack: The measurement; None for none.
            streak: Rejections in a row by source and leg, (S, N).
            sources: What was learned about the noise so far.
            t_ns: Time of the tick.
        """
        legs = streak.shape[1]
        nothing = _not_measured(legs)
        none = Updated(
            mean, covariance, np.nan, *_no_source(), np.nan, 0, 0, streak, nothing, sources
        )
        if stack is None:
            return none
        streak = streak.copy()
        where = source.places(stack.blocks, len(stack.innovation), legs)
        known, weighed = _noise(stack.variance, where, sources, self._settings.least_weight)
        spread = stack.rows @ covariance @ stack.rows.T
        expected = spread.diagonal().copy()
        gated = spread.copy()  # a gate does not get used to all that it sees
        gated.flat[:: len(spread) + 1] += np.minimum(weighed, MOST_AT_A_GATE * stack.variance)
        used, more, rejects = _gate(stack, gated, streak, self._reject_limit)
        learned = source.learn(
            sources, where, stack.innovation, expected, stack.variance, t_ns, self._record
        )
        if not used.any():
            return replace(none, rejects=rejects, streak=streak, sources=learned)
        keep = used if rejects else slice(None)  # a view where all pass, as in nearly every tick
        variance = (weighed + more)[keep]
        sd = np.sqrt((expected + weighed + more)[keep])
        left = stack.innovation[keep]
        normal = nothing.copy()
        over_sd = np.full(len(used), np.nan)
        over_sd[keep] = left / np.sqrt((expected + known + more)[keep])
        for first, kind, leg in stack.blocks.tolist():
            if kind == LOAD:
                normal[leg, 2] = over_sd[first]
            elif kind == FORCE:
                normal[leg, :2] = over_sd[first : first + 2]
        # Over their sd S is a matrix of correlations: it has an inverse whatever the units.
        noise = np.zeros((len(sd), len(sd)))
        noise.flat[:: len(sd) + 1] = variance / sd**2
        error = self._filter
        error.x, error.P = self._no_error, covariance
        error.update(left / sd, noise, stack.rows[keep] / sd[:, None])
        after = mean + error.x
        limited = after[self._first_limited :]
        limited.clip(-self._limit, self._limit, out=limited)
        fitted = spread[keep][:, keep] if rejects else spread
        fitted.flat[:: len(fitted) + 1] += (known + more)[keep]
        nis = _fit(left, fitted)
        volume = np.linalg.slogdet(fitted)[1]
        likelihood = -0.5 * (nis + float(volume) + len(left) * LOG_TURN)
        return Updated(
            after, symmetric(error.P), nis, *_by_source(left, fitted, where.source[keep]),
            likelihood, len(left), rejects, streak, readonly(normal), learned,
        )  # fmt: skip


def _noise(
    variance: FloatArray, where: NumberPlaces, sources: SourceMemory, least: float
) -> tuple[FloatArray, FloatArray]:
    """Variance of each number as learned, and that with which it weighs in, as errors last, (m,)."""
    scale, colour = np.append(sources.scale, 1.0), np.append(sources.colour, 1.0)
    known, counted = scale[where.source], colour[where.source]
    return variance * known, variance * np.maximum(known * counted, least)


def _fit(left: FloatArray, spread: FloatArray) -> float:
    """Normalised innovation squared; over its sd, S is a matrix of correlations whatever the units."""
    if len(left) == 1:
        return float(left[0] ** 2 / spread[0, 0])
    sd = np.sqrt(spread.diagonal())
    normal = left / sd
    return float(normal @ np.linalg.solve(spread / np.outer(sd, sd), normal))


def _by_source(
    left: FloatArray, spread: FloatArray, kinds: IntArray
) -> tuple[FloatArray, IntArray]:
    """Normalised innovation squared of each source by itself, and its numbers, (S,)."""
    nis, dof = _no_source()
    nis, dof = nis.copy(), dof.copy()
    for kind in sorted(set(kinds.tolist())):
        if kind != NO_SOURCE:
            own = kinds == kind
            nis[kind] = _fit(left[own], spread[np.ix_(own, own)])
            dof[kind] = np.count_nonzero(own)
    return readonly(nis), readonly(dof)


@cache
def _no_source() -> tuple[FloatArray, IntArray]:
    """NIS and numbers by source where nothing was measured, (S,)."""
    count = len(SOURCES)
    return readonly(np.full(count, np.nan)), readonly(np.zeros(count, dtype=np.int64))


@cache
def _not_measured(legs: int) -> FloatArray:
    """Normalised innovations of feet none of which was used, (N, 3)."""
    return readonly(np.full((legs, 3), np.nan))


def _gate(
    stack: MeasurementStack, spread: FloatArray, streak: IntArray, reject_limit: int
) -> tuple[BoolArray, FloatArray, int]:
    """Which numbers are used, with how much more variance, and how many blocks were rejected.

    Args:
        stack: The measurement.
        spread: Covariance of its innovation, (m, m).
        streak: In and out: rejections in a row by source and leg, (S, N).
        reject_limit: Rejections in a row after which a block is used.
    """
    used, more, rejects = np.ones(len(spread), dtype=bool), np.zeros(len(spread)), 0
    blocks = stack.blocks.tolist()
    ends = [*(first for first, _, _ in blocks[1:]), len(spread)]
    left, own = stack.innovation.tolist(), spread.diagonal().tolist()
    beside = spread.diagonal(1).tolist()
    for (first, kind, leg), end, gate in zip(blocks, ends, stack.gates.tolist(), strict=True):
        part, counted = slice(first, end), kind != NO_SOURCE
        if not isfinite(sum(own[part])):
            distance = inf
        elif end - first == 1:
            distance = left[first] * left[first] / own[first]
        elif end - first == 2:
            distance = _pair_distance(left[part], own[part], beside[first])
        else:
            several = stack.innovation[part]
            distance = float(np.vdot(several, np.linalg.solve(spread[part, part], several)))
        passed = distance <= gate
        if not passed:
            rejects += 1
            insists = counted and streak[kind, leg] >= reject_limit
            if insists and distance < FARTHEST:
                # brings one number exactly to the gate, a pair near it
                more[part] = (distance / gate - 1.0) * spread.diagonal()[part]
            else:
                used[part] = False
        if counted:
            streak[kind, leg] = 0 if passed else streak[kind, leg] + 1
    return used, more, rejects


def _pair_distance(left: list[float], own: list[float], beside: float) -> float:
    """Normalised innovation squared of two numbers; a solver for them costs as much as all else here."""
    (x, y), (xx, yy) = left, own
    volume = xx * yy - beside * beside
    return (yy * x * x - 2.0 * beside * x * y + xx * y * y) / volume if volume > 0.0 else inf


def symmetric(covariance: FloatArray) -> FloatArray:
    """Mean of a matrix and its transpose: rounding must not add up."""
    half: FloatArray = 0.5 * (covariance + covariance.T)
    return half


def sound(covariance: FloatArray) -> bool:
    """Whether a covariance is finite and positive definite."""
    return isfinite(np.vdot(covariance, covariance)) and _cholesky()(covariance)[1] == 0


@cache
def _cholesky() -> Callable[[FloatArray], tuple[FloatArray, int]]:
    from scipy.linalg.lapack import dpotrf  # comes with filterpy, as late as it

    cholesky: Callable[[FloatArray], tuple[FloatArray, int]] = dpotrf
    return cholesky


def mended(covariance: FloatArray) -> FloatArray:
    """The nearest matrix whose eigenvalues are above a floor; a last resort that is reported."""
    values, vectors = np.linalg.eigh(symmetric(covariance))
    floor = max(1e-14, 1e-12 * float(values[-1]))
    mended_one: FloatArray = (vectors * np.maximum(values, floor)) @ vectors.T
    return symmetric(mended_one)
