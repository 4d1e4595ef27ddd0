"""The extended Kalman filter of filterpy behind two functions on plain arrays.

Nothing else in the program knows filterpy: what it needs of us (a nonlinear prediction, gates) and what
it leaves to us (a covariance that is symmetric and positive definite) is settled here.
"""

from dataclasses import dataclass

import numpy as np

from model.estimator.step_kernel import sound_kernel
from model.values.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Stack:
    """A measurement in blocks, each of which is believed or not as a whole.

    Attributes:
        innovation: Measured less expected, angles wrapped already, (m,).
        rows: H, (m, n).
        variance: Of the noise, independent from number to number, (m,); made larger for a block that
            is believed after many rejections, infinite for one that is not used.
        gates: Largest normalised innovation squared of each block, (B,); infinite for none.
        blocks: Of each block: its first number, kind and leg, (B, 3); kind -1 keeps no count.
    """

    innovation: FloatArray
    rows: FloatArray
    variance: FloatArray
    gates: FloatArray
    blocks: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Patience:
    """What bounds an update.

    Attributes:
        reject_limit: Rejections in a row after which a block is believed with more noise.
        first_limited: Place in the state from which on
        limit: no number gets farther from 0 than this.
    """

    reject_limit: int
    first_limited: int
    limit: float


@dataclass(frozen=True, slots=True, eq=False)
class Updated:
    """Mean and covariance after a measurement, and how it fitted.

    Attributes:
        mean: (n,).
        covariance: P, (n, n).
        nis: Normalised innovation squared of what was used; NaN if nothing was.
        log_likelihood: Of the innovation of what was used; NaN if nothing was.
        numbers: How many numbers were used.
        rejects: Blocks that did not pass their gates at first.
        streak: Rejections in a row by kind and leg, (3, N).
        innovation: Of the feet's forces over the sd that the filter gives them, (N, 3); NaN where
            none was used.
    """

    mean: FloatArray
    covariance: FloatArray
    nis: float
    log_likelihood: float
    numbers: int
    rejects: int
    streak: IntArray
    innovation: FloatArray


class Kalman:
    """Prediction and update for a state of fixed size; holds no belief of its own between calls.

    Args:
        size: Number of states n.
    """

    def __init__(self, size: int) -> None:
        from model.estimator.kalman_filter import (
            CompiledFilter,  # a second, which not every command needs
        )

        self._filter = CompiledFilter(size)

    def predict(
        self, mean: FloatArray, covariance: FloatArray, transition: FloatArray, noise: FloatArray
    ) -> FloatArray:
        """Covariance F P F' + Q of a predicted mean, exactly symmetric.

        Args:
            mean: Predicted mean, (n,).
            covariance: P before, (n, n).
            transition: F, (n, n).
            noise: Q, (n, n).
        """
        ekf = self._filter
        ekf.P, ekf.F, ekf.Q = covariance, transition, noise
        ekf.predict(mean=mean)
        after: FloatArray = ekf.P
        return after

    def update(
        self,
        mean: FloatArray,
        covariance: FloatArray,
        stack: Stack,
        streak: IntArray,
        patience: Patience,
    ) -> Updated:
        """Gate each block by its own normalised innovation, and use the rest.

        Args:
            mean: (n,).
            covariance: P, (n, n).
            stack: The measurement; its variance is changed.
            streak: Rejections in a row by kind and leg, (3, N).
            patience: When to believe what is rejected, and how far parameters may go.
        """
        ekf = self._filter
        ekf.x, ekf.P = mean, covariance
        streak, normal = streak.copy(), np.full((streak.shape[1], 3), np.nan)
        nis, log_likelihood, numbers, rejects = ekf.gated_update(
            stack.innovation, stack.rows, stack.variance, stack.gates, stack.blocks,
            patience.reject_limit, patience.first_limited, patience.limit, streak, normal,
        )  # fmt: skip
        return Updated(ekf.x, ekf.P, nis, log_likelihood, numbers, rejects, streak, normal)


def symmetric(covariance: FloatArray) -> FloatArray:
    """Mean of a matrix and its transpose: rounding must not add up."""
    half: FloatArray = 0.5 * (covariance + covariance.T)
    return half


def sound(covariance: FloatArray) -> bool:
    """Whether a covariance is finite and positive definite."""
    return bool(sound_kernel(covariance))


def mended(covariance: FloatArray) -> FloatArray:
    """The nearest matrix whose eigenvalues are above a floor; a last resort that is reported."""
    values, vectors = np.linalg.eigh(symmetric(covariance))
    floor = max(1e-14, 1e-12 * float(values[-1]))
    mended_one: FloatArray = (vectors * np.maximum(values, floor)) @ vectors.T
    return symmetric(mended_one)
