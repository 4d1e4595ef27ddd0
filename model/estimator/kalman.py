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

from model.compiled import COUNT, NUMBER, compile_for, compiled, given, in_place, out
from model.estimator import sources as source
from model.estimator.filterpy_filter import kalman_filter_class
from model.estimator.gate_kernel import weigh_kernel
from model.estimator.settings import EstimatorSettings, record_of
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.estimate import SOURCES, SourceMemory

LOG_TURN = log(tau)
CLEAR = 1e-7  # share of a variance that is left by what is known of others, far above rounding


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

    Attributes:
        error: filterpy's filter; its state is the error of the mean.
        no_error: That state before each step, (n,).
    """

    def __init__(self, size: int, first_limited: int, settings: EstimatorSettings) -> None:
        self._settings, self._first_limited = settings, first_limited
        self._record = record_of(settings, 1.0)
        self._reject_limit, self._limit = settings.reject_limit, settings.parameter_limit
        self.error = kalman_filter_class()(size, 1)
        self.no_error = readonly(np.zeros(size))

    def predict(
        self, covariance: FloatArray, transition: FloatArray, noise: FloatArray
    ) -> FloatArray:
        """Covariance F P F' + Q of a predicted mean, exactly symmetric.

        Args:
            covariance: P before, (n, n).
            transition: F, (n, n).
            noise: Q, (n, n).
        """
        error = self.error
        error.x, error.P, error.F, error.Q = self.no_error, covariance, transition, noise
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
        count, size = stack.rows.shape
        spread = stack.rows @ covariance @ stack.rows.T
        now, legs, kinds = source.room_for(sources), streak.shape[1], len(SOURCES)
        left, seen, noise = np.empty(count), np.empty((count, size)), np.empty((count, count))
        in_a_row, normal = np.empty((kinds, legs), np.int64), np.empty((legs, 3))
        source_nis, source_dof = np.empty(kinds), np.empty(kinds, np.int64)
        rejects, used, nis, volume = weigh_kernel(
            *stack, spread, t_ns, self._record, sources.t_ns, sources.product, sources.normal,
            sources.last, sources.bias, sources.misfit, sources.scale, sources.colour, streak,
            now.t_ns, now.product, now.normal, now.last, now.bias, now.misfit, now.scale, now.colour,
            in_a_row, left, noise, seen, normal, source_nis, source_dof,
            np.empty((3, count), np.int64),
        )  # fmt: skip
        learned = source.closed(now)
        if not used:
            return _unused(mean, covariance, rejects, in_a_row, learned)
        error = self.error
        error.x, error.P = self.no_error, covariance
        error.update(left[:used], noise[:used, :used], seen[:used])
        after, settled = np.empty(size), np.empty((size, size))
        settle_kernel(mean, error.x, error.P, self._first_limited, self._limit, after, settled)
        return Updated(
            after, settled, nis, readonly(source_nis), readonly(source_dof),
            -0.5 * (nis + volume + used * LOG_TURN), used, rejects, in_a_row, readonly(normal), learned,
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
    half = np.empty(covariance.shape)
    symmetric_kernel(covariance, half)
    return half


@in_place
@compiled
def symmetric_kernel(covariance: FloatArray, half: FloatArray) -> None:
    """Fill the mean of a matrix and its transpose, (n, n)."""
    for i in range(half.shape[0]):
        for j in range(i + 1):
            half[i, j] = half[j, i] = (covariance[i, j] + covariance[j, i]) * 0.5


@in_place
@compiled
def settle_kernel(
    mean: FloatArray, error: FloatArray, spread: FloatArray, first: int, limit: float,
    after: FloatArray, settled: FloatArray,
) -> None:  # fmt: skip
    """Add the error that an update found to the mean, with limits, and make its covariance symmetric.

    Args:
        mean: (n,).
        error: (n,).
        spread: Covariance as the update left it, (n, n).
        first: Place of the first state that is limited; all after it are.
        limit: Their largest size.
        after: Out: the mean now, (n,).
        settled: Out: its covariance, (n, n).
    """
    for i in range(mean.size):
        now = mean[i] + error[i]
        if i >= first and abs(now) > limit:  # what is no number stays none
            now = limit if now > 0.0 else -limit
        after[i] = now
    symmetric_kernel(spread, settled)


@in_place
@compiled
def sound_kernel(covariance: FloatArray, factor: FloatArray) -> bool:
    """Whether a covariance is positive definite beyond doubt: no pivot is anywhere near rounding.

    Args:
        covariance: (n, n).
        factor: Work space, (n, n).
    """
    size = covariance.shape[0]
    for i in range(size):
        for j in range(i, size):
            factor[i, j] = covariance[i, j]
    for k in range(size):
        pivot = factor[k, k]
        if not CLEAR * covariance[k, k] < pivot < np.inf:
            return False
        for i in range(k + 1, size):
            share = factor[k, i] / pivot
            for j in range(i, size):
                factor[i, j] -= share * factor[k, j]
    return True


def sound(covariance: FloatArray) -> bool:
    """Whether a covariance is finite and positive definite."""
    if sound_kernel(covariance, np.empty(covariance.shape)):
        return True
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


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(symmetric_kernel, *given(2), *out(2))
    compile_for(settle_kernel, *given(1, 1, 2), COUNT, NUMBER, *out(1, 2))
    compile_for(sound_kernel, *given(2), *out(2))
