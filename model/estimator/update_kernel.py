"""The Kalman filter's two halves, compiled: the covariance of a prediction, and a gated measurement.

The noise of a measurement is independent from number to number, so the numbers of a stack may be used one
after the other: the same mean, covariance and likelihood as all at once, without a matrix to invert. Tests
hold both halves to filterpy.
"""

from typing import Any

import numpy as np

from model.compiled import COUNT, NUMBER, compile_for, compiled, compiled_sums, given, out
from model.values.arrays import FloatArray, IntArray

LOG_TURN = 1.8378770664093453  # log(2 pi)
ACCEPTED, REJECTED, FORGIVEN = (
    0,
    1,
    2,
)  # the last: rejected so often that it is believed with more noise
NO_STREAK = -1  # kind of a block that keeps no count of rejections
LOAD, FORCE = 0, 1


@compiled_sums
def _times(matrix: FloatArray, row: FloatArray, out: FloatArray) -> float:
    """Product of a symmetric matrix and a row that is mostly zeros; also the row times the product."""
    for j in range(row.size):
        out[j] = 0.0
    for i in range(row.size):
        if row[i] != 0.0:
            for j in range(row.size):
                out[j] += row[i] * matrix[i, j]
    total = 0.0
    for j in range(row.size):
        total += row[j] * out[j]
    return total


@compiled
def predict_kernel(
    covariance: FloatArray, transition: FloatArray, noise: FloatArray, after: FloatArray
) -> None:
    """F P F' + Q, exactly symmetric.

    Args:
        covariance: P, symmetric, (n, n).
        transition: F, most of it zeros, (n, n).
        noise: Q, symmetric, (n, n).
        after: Out: (n, n).
    """
    size = covariance.shape[0]
    row = np.empty(size)
    half = np.empty((size, size))
    for i in range(size):
        _times(covariance, transition[i], row)
        for j in range(size):
            half[j, i] = row[j]  # P F'
    for i in range(size):
        for j in range(size):
            row[j] = 0.0
        for k in range(size):
            if transition[i, k] != 0.0:
                for j in range(size):
                    row[j] += transition[i, k] * half[k, j]
        for j in range(i + 1):
            after[i, j] = row[j] + noise[i, j]
            after[j, i] = after[i, j]


@compiled
def _distance(
    products: FloatArray,
    rows: FloatArray,
    innovation: FloatArray,
    variance: FloatArray,
    begin: int,
    end: int,
    whitened: FloatArray,
    root: FloatArray,
) -> float:
    """Normalised innovation squared of the block of numbers begin to end - 1; infinite without one."""
    total = 0.0
    for i in range(begin, end):
        left = innovation[i]
        for j in range(begin, i + 1):
            inner = variance[i] if i == j else 0.0
            for m in range(rows.shape[1]):
                inner += rows[i, m] * products[j, m]
            for m in range(begin, j):
                inner -= root[i - begin, m - begin] * root[j - begin, m - begin]
            if i > j:
                root[i - begin, j - begin] = inner / root[j - begin, j - begin]
                left -= root[i - begin, j - begin] * whitened[j - begin]
            elif inner > 0.0:
                root[i - begin, i - begin] = np.sqrt(inner)
            else:
                return np.inf
        whitened[i - begin] = left / root[i - begin, i - begin]
        total += whitened[i - begin] ** 2
    return total


@compiled
def update_kernel(
    mean: FloatArray,
    covariance: FloatArray,
    innovation: FloatArray,
    rows: FloatArray,
    variance: FloatArray,
    gates: FloatArray,
    blocks: IntArray,
    reject_limit: int,
    first_limited: int,
    limit: float,
    streaks: IntArray,
    normal: FloatArray,
) -> tuple[float, float, int, int]:
    """Gate each block by its own normalised innovation, and use what passes.

    After a row of rejections a block is believed again with as much more noise as brings it to its
    gate: a filter that never hears its sensors again is worse than one that doubts them.

    Args:
        mean: In and out: (n,).
        covariance: In and out: P, symmetric, (n, n).
        innovation: Measured less expected, (m,).
        rows: H, (m, n).
        variance: Of the noise, (m,); out: larger where believed after a row of rejections, infinite
            where not used.
        gates: Largest normalised innovation squared of each block, (B,).
        blocks: Of each block: its first number, kind (NO_STREAK: none is kept) and leg, (B, 3).
        reject_limit: Rejections in a row after which a block is believed.
        first_limited: Place in the state from which on
        limit: no number gets farther from 0 than this.
        streaks: In and out: rejections in a row by kind and leg, (3, N).
        normal: In: NaN, out: normalised innovations of the feet's forces that were used, (N, 3).

    Returns:
        Normalised innovation squared, its log likelihood, how many numbers were used, and how many
        blocks did not pass their gates at first.
    """
    count, size = rows.shape
    products = np.empty((count, size))
    spread = np.empty(count)
    root, whitened = np.empty((3, 3)), np.empty(3)
    use = np.ones(count, dtype=np.bool_)
    rejects = 0
    for i in range(count):
        spread[i] = _times(covariance, rows[i], products[i])
    for b in range(gates.size):
        begin, kind, leg = blocks[b, 0], blocks[b, 1], blocks[b, 2]
        end = blocks[b + 1, 0] if b + 1 < gates.size else count
        passed = True
        if gates[b] < np.inf:
            distance = _distance(products, rows, innovation, variance, begin, end, whitened, root)
            passed = distance <= gates[b]
            if not passed:
                rejects += 1
                patient = kind != NO_STREAK and streaks[kind, leg] >= reject_limit
                for i in range(begin, end):
                    if patient and distance < np.inf:
                        # brings one number exactly to the gate, a pair near it
                        variance[i] += (distance / gates[b] - 1.0) * (spread[i] + variance[i])
                    else:
                        use[i] = False
                        variance[i] = np.inf
        if kind != NO_STREAK:
            streaks[kind, leg] = 0 if passed else streaks[kind, leg] + 1
        if use[begin]:
            for i in range(begin, end):
                share = innovation[i] / np.sqrt(spread[i] + variance[i])
                if kind == LOAD:
                    normal[leg, 2] = share
                elif kind == FORCE:
                    normal[leg, i - begin] = share
    return _use(mean, covariance, innovation, rows, variance, use, first_limited, limit, rejects)


@compiled
def _use(
    mean: FloatArray,
    covariance: FloatArray,
    innovation: FloatArray,
    rows: FloatArray,
    variance: FloatArray,
    use: Any,
    first_limited: int,
    limit: float,
    rejects: int,
) -> tuple[float, float, int, int]:
    """Number after number into mean and covariance; returns what ``update_kernel`` does."""
    count, size = rows.shape
    expected = mean.copy()
    product = np.empty(size)
    nis, volume, used = 0.0, 0.0, 0
    for i in range(count):
        if not use[i]:
            continue
        spread = _times(covariance, rows[i], product) + variance[i]
        root = 1.0 / np.sqrt(spread)
        left = innovation[i]
        for j in range(size):
            left -= rows[i, j] * (mean[j] - expected[j])
        left *= root
        for j in range(size):
            product[j] *= root
            mean[j] += product[j] * left
        for j in range(size):
            for k in range(size):  # the same product both ways round: symmetric to the last bit
                covariance[j, k] -= product[j] * product[k]
        nis += left * left
        volume += np.log(spread) + LOG_TURN
        used += 1
    if used == 0:
        return np.nan, np.nan, 0, rejects
    for j in range(first_limited, size):
        mean[j] = min(max(mean[j], -limit), limit)
    return nis, -0.5 * (nis + volume), used, rejects


def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    compile_for(predict_kernel, *given(2, 2, 2), *out(2))
    compile_for(
        update_kernel, *out(1, 2), *given(1, 2), *out(1), *given(1), *given(2, kind=COUNT),
        COUNT, COUNT, NUMBER, *out(2, kind=COUNT), *out(2),
    )  # fmt: skip
