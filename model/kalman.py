"""The extended Kalman filter of filterpy behind two functions on plain arrays.

Nothing else in the program knows filterpy: what it needs of us (a nonlinear prediction) and what it
leaves to us (keeping P symmetric) is settled here.
"""

from typing import Any

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from model.estimator_step_kernel import sound_kernel
from model.signals import FloatArray


class _Filter(ExtendedKalmanFilter):  # type: ignore[misc]  # filterpy has no types
    """An EKF whose predicted mean comes from outside."""

    mean: FloatArray

    def predict_x(self, u: Any = 0) -> None:
        """Take the mean that our process gave."""
        self.x = self.mean


class Kalman:
    """Prediction and update for a state of fixed size; holds no belief of its own between calls.

    Args:
        size: Number of states n.
    """

    def __init__(self, size: int) -> None:
        self._filter = _Filter(size, 1)

    def predict(
        self, mean: FloatArray, covariance: FloatArray, transition: FloatArray, noise: FloatArray
    ) -> FloatArray:
        """Covariance F P F' + Q of a predicted mean.

        Args:
            mean: Predicted mean, (n,).
            covariance: P before, (n, n).
            transition: F, (n, n).
            noise: Q, (n, n).
        """
        ekf = self._filter
        ekf.mean, ekf.P, ekf.F, ekf.Q = mean, covariance, transition, noise
        ekf.predict()
        return symmetric(ekf.P)

    def update(
        self,
        mean: FloatArray,
        covariance: FloatArray,
        innovation: FloatArray,
        rows: FloatArray,
        noise: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Mean and covariance after a measurement, in Joseph's form.

        Args:
            mean: (n,).
            covariance: P, (n, n).
            innovation: Measured less predicted, (m,), angles wrapped already.
            rows: H, (m, n).
            noise: R, (m, m).
        """
        ekf = self._filter
        ekf.x, ekf.P = mean, covariance
        # what was predicted is in the innovation already
        nothing = np.zeros(len(innovation))
        ekf.update(innovation, lambda _: rows, lambda _: nothing, noise)
        return ekf.x, symmetric(ekf.P)


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
