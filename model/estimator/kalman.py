"""filterpy's Kalman filter behind two functions on plain arrays: an extended filter in error-state form.

filterpy's own ``predict`` and ``update`` do the arithmetic. Its state is the error of the mean, 0 before
each of them, as the mean itself moves by a model that is not linear. Gates, and a covariance that stays
symmetric and positive definite, are settled here; nothing else in the program knows filterpy.
"""

from collections.abc import Callable
from functools import cache
from math import isfinite, log, tau
from typing import NamedTuple

import numpy as np

from model.estimator import sources as source
from model.estimator.filterpy_filter import kalman_filter_class
from model.estimator.gate_kernel import gate_kernel
from model.estimator.settings import EstimatorSettings, record_of
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.estimate import SOURCES, SourceMemory

LOG_TURN = log(tau)


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


class Updated(NamedTuple):
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
        self._settings, self._first_limited = settings, first_limited
        self._record = record_of(settings, 1.0)
        self._reject_limit, self._limit = settings.reject_limit, settings.parameter_limit
        self._filter = kalman_filter_class()(size, 1)
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
        if stack is None:
            return _unused(mean, covariance, 0, streak, sources)
        streak, legs = streak.copy(), streak.shape[1]
        count, size = stack.rows.shape
        where = source.places(stack.blocks, count, legs)
        spread = stack.rows @ covariance @ stack.rows.T
        expected, left, seen = np.empty(count), np.empty(count), np.empty((count, size))
        noise, normal = np.zeros((count, count)), np.full((legs, 3), np.nan)
        source_nis, source_dof = (
            np.full(len(SOURCES), np.nan),
            np.empty(len(SOURCES), dtype=np.int64),
        )
        rejects, used, nis, volume = gate_kernel(
            *stack, spread, where.source, sources.scale, sources.colour, self._settings.least_weight,
            self._reject_limit, streak, expected, left, noise, seen, normal, source_nis, source_dof,
            np.empty(count, dtype=np.int64),
        )  # fmt: skip
        learned = source.learn(
            sources, where, stack.innovation, expected, stack.variance, t_ns, self._record
        )
        if not used:
            return _unused(mean, covariance, rejects, streak, learned)
        error = self._filter
        error.x, error.P = self._no_error, covariance
        error.update(left[:used], noise[:used, :used], seen[:used])
        after = mean + error.x
        limited = after[self._first_limited :]
        np.minimum(np.maximum(limited, -self._limit, out=limited), self._limit, out=limited)
        return Updated(
            after, symmetric(error.P), nis, readonly(source_nis), readonly(source_dof),
            -0.5 * (nis + volume + used * LOG_TURN), used, rejects, streak, readonly(normal), learned,
        )  # fmt: skip


def _unused(
    mean: FloatArray, covariance: FloatArray, rejects: int, streak: IntArray, sources: SourceMemory
) -> Updated:
    """What is known where nothing was measured, or nothing passed."""
    nothing, (nis, dof) = _not_measured(streak.shape[1]), _no_source()
    return Updated(mean, covariance, np.nan, nis, dof, np.nan, 0, rejects, streak, nothing, sources)


@cache
def _no_source() -> tuple[FloatArray, IntArray]:
    """NIS and numbers by source where nothing was measured, (S,)."""
    count = len(SOURCES)
    return readonly(np.full(count, np.nan)), readonly(np.zeros(count, dtype=np.int64))


@cache
def _not_measured(legs: int) -> FloatArray:
    """Normalised innovations of feet none of which was used, (N, 3)."""
    return readonly(np.full((legs, 3), np.nan))


def symmetric(covariance: FloatArray) -> FloatArray:
    """Mean of a matrix and its transpose: rounding must not add up."""
    half: FloatArray = covariance + covariance.T
    half *= 0.5
    return half


def sound(covariance: FloatArray) -> bool:
    """Whether a covariance is finite and positive definite."""
    if not isfinite(np.vdot(covariance, covariance)):
        return False
    # turned over it is the same matrix, with its numbers where LAPACK looks for them
    return _cholesky()(covariance.T, clean=0)[1] == 0


@cache
def _cholesky() -> Callable[..., tuple[FloatArray, int]]:
    from scipy.linalg.lapack import dpotrf  # comes with filterpy, as late as it

    cholesky: Callable[..., tuple[FloatArray, int]] = dpotrf
    return cholesky


def mended(covariance: FloatArray) -> FloatArray:
    """The nearest matrix whose eigenvalues are above a floor; a last resort that is reported."""
    values, vectors = np.linalg.eigh(symmetric(covariance))
    floor = max(1e-14, 1e-12 * float(values[-1]))
    mended_one: FloatArray = (vectors * np.maximum(values, floor)) @ vectors.T
    return symmetric(mended_one)
