"""filterpy's extended Kalman filter with its two methods compiled; known to ``kalman`` only.

filterpy's object keeps mean, covariance and everything else that it makes public. What runs in it every
tick is ours: the same prediction and update as filterpy's own, to which tests hold them, at a tenth of
the time and with a gate for each block of measurements. Importing filterpy takes a second (it brings
scipy's statistics along), so this module is imported when the first filter is made.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from model.estimator.update_kernel import NO_STREAK, predict_kernel, update_kernel
from model.values.arrays import FloatArray, IntArray


class CompiledFilter(ExtendedKalmanFilter):  # type: ignore[misc]  # filterpy has no types
    """An extended Kalman filter in compiled code.

    All of filterpy's attributes hold what they do there, with S, SI and K worked out when they are asked
    for: the update takes one number after the other and needs none of them.

    Args:
        size: Number of states n.
    """

    P: FloatArray

    def __init__(self, size: int) -> None:
        nothing = np.zeros((0, size))
        self._taken = np.zeros((size, size)), nothing, np.zeros(0)
        super().__init__(size, 1)
        self.x = np.zeros(size)
        self._nis = np.nan

    def predict(self, u: Any = 0, mean: FloatArray | None = None) -> None:
        """F P F' + Q; the mean is F x + B u as filterpy has it, or comes from a nonlinear process.

        Args:
            u: Input, for filterpy's ``B``.
            mean: The predicted mean, (n,).
        """
        if mean is None:
            self.predict_x(u)
        else:
            self.x = mean
        after = np.empty_like(self.P)
        predict_kernel(self.P, self.F, self.Q, after)
        self.P = after
        self.x_prior, self.P_prior = self.x, after  # neither is ever written to

    def update(
        self,
        z: FloatArray,
        HJacobian: Callable[..., FloatArray],  # noqa: N803 (filterpy's name)
        Hx: Callable[..., FloatArray],  # noqa: N803
        R: FloatArray | None = None,  # noqa: N803
        args: tuple[Any, ...] = (),
        hx_args: tuple[Any, ...] = (),
        residual: Callable[[FloatArray, FloatArray], FloatArray] = np.subtract,
    ) -> None:
        """Use a measurement, as filterpy's method of this name; the noise must be diagonal.

        Args:
            z: Measured, (m,).
            HJacobian: Derivatives at a mean, (m, n).
            Hx: What is expected at a mean, (m,).
            R: Noise, (m, m), diagonal; ``self.R`` if None.
            args: For ``HJacobian``.
            hx_args: For ``Hx``.
            residual: Difference of measured and expected.
        """
        self.z = z
        left = residual(z, Hx(self.x, *hx_args))
        self.gated_update(
            left, HJacobian(self.x, *args), np.diagonal(self.R if R is None else R).copy(),
            np.array([np.inf]), np.array([[0, NO_STREAK, 0]]), 0, self.dim_x, np.inf,
            np.zeros((3, 1), dtype=np.int64), np.full((1, 3), np.nan),
        )  # fmt: skip

    def gated_update(
        self,
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
        """Gate each block, use what passes; arguments and answer are those of ``update_kernel``."""
        before = self.P
        mean, covariance = self.x.copy(), before.copy()
        found: tuple[float, float, int, int] = update_kernel(
            mean, covariance, innovation, rows, variance, gates, blocks, reject_limit,
            first_limited, limit, streaks, normal,
        )  # fmt: skip
        self.x = self.x_post = mean
        self.P = self.P_post = covariance
        self.y, self._taken = innovation, (before, rows, variance)
        self._nis, self._log_likelihood = found[0], found[1]
        self._likelihood = None
        return found

    @property
    def mahalanobis(self) -> float:
        """Distance of the innovation that was used, in standard deviations; NaN if nothing was."""
        return float(np.sqrt(self._nis))

    @property
    def S(self) -> FloatArray:  # noqa: N802
        """Covariance of the innovation; infinite for numbers that were not used."""
        before, rows, variance = self._taken
        spread: FloatArray = rows @ before @ rows.T + np.diag(variance)
        return spread

    @S.setter
    def S(self, _value: FloatArray) -> None:  # noqa: N802
        """Leave out what filterpy's constructor puts here."""

    @property
    def SI(self) -> FloatArray:  # noqa: N802
        """Inverse of S; 0 for numbers that were not used."""
        used = np.isfinite(self._taken[2])
        inverse = np.zeros((len(used), len(used)))
        inverse[np.ix_(used, used)] = np.linalg.inv(self.S[np.ix_(used, used)])
        return inverse

    @SI.setter
    def SI(self, _value: FloatArray) -> None:  # noqa: N802
        """As that of S."""

    @property
    def K(self) -> FloatArray:  # noqa: N802
        """Gain; 0 for numbers that were not used."""
        before, rows, _ = self._taken
        gain: FloatArray = before @ rows.T @ self.SI
        return gain

    @K.setter
    def K(self, _value: FloatArray) -> None:  # noqa: N802
        """As that of S."""
