"""Stage one of the in-situ calibration: what a sensor reads while its foot is in the air.

Least squares of a short Fourier series in the shaft angle, all six axes with the same number of harmonics.
That number is the one with the smallest Bayesian information criterion among those that the angles can
tell: a robot that stands on its other feet shows a leg only over the arc where it is in the air, and over
an arc harmonics look alike. The condition number says how alike.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import FloatArray, readonly
from model.values.force_calibration import fourier_rows

MAX_HARMONICS = 3
# Beyond this condition number of the fit a harmonic is not offered at all.
WORST_CONDITION = 300.0
# Distinct angles wanted for each unknown, and two more.
SAMPLES_PER_UNKNOWN = 2
# Angles nearer to each other than this are one angle [rad].
SAME_ANGLE_RAD = 0.02
_FLOOR = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class UnloadedFit:
    """The fit of one sensor.

    Attributes:
        coefficients: (6, 1 + 2 H) [N, N m]; see ``ForceCalibration.unloaded``.
        condition: Condition number of the least squares.
        residual_rms: Of each axis, (6,) [N, N m]; NaN where there are no more samples than unknowns.
        covariance: Of the coefficients of any axis, for unit residuals, (1 + 2 H, 1 + 2 H).
        widest_gap_rad: Widest arc without a sample.
        gap_centre_rad: Its middle, -pi to pi.
        samples: Number of samples used.
    """

    coefficients: FloatArray
    condition: float
    residual_rms: FloatArray
    covariance: FloatArray
    widest_gap_rad: float
    gap_centre_rad: float
    samples: int

    @property
    def harmonics(self) -> int:
        """Number of harmonics H."""
        return int(self.coefficients.shape[1] - 1) // 2

    def standard_error(self, angle_rad: float) -> FloatArray:
        """Return one standard deviation of the fit at a shaft angle, (6,) [N, N m]."""
        row = fourier_rows(np.array(angle_rad), self.harmonics)
        error: FloatArray = self.residual_rms * np.sqrt(row @ self.covariance @ row)
        return error


def fit_unloaded(
    angle_rad: FloatArray, sensed: FloatArray, max_harmonics: int = MAX_HARMONICS
) -> UnloadedFit:
    """Fit the readings of a sensor whose foot is in the air.

    Args:
        angle_rad: Shaft angles, (P,) [rad].
        sensed: Readings, (P, 6) [N, N m].
        max_harmonics: Most harmonics to try.

    Raises:
        ModelError: There is no sample.
    """
    sound = np.isfinite(angle_rad) & np.isfinite(sensed).all(axis=1)
    angle_rad, sensed = angle_rad[sound], sensed[sound]
    if len(angle_rad) == 0:
        raise ModelError("no sample with the foot in the air; lift each leg once while recording")
    distinct = _distinct(angle_rad)
    best, best_score = None, np.inf
    for harmonics in range(max_harmonics + 1):
        unknowns = 1 + 2 * harmonics
        if harmonics and distinct < SAMPLES_PER_UNKNOWN * unknowns + 2:
            break
        fit = _fit(angle_rad, sensed, harmonics)
        if harmonics and fit.condition > WORST_CONDITION:
            break
        score = _information(fit, sensed, unknowns)
        if best is None or score < best_score:
            best, best_score = fit, score
    assert best is not None  # no harmonics at all is always offered
    return best


def _fit(angle_rad: FloatArray, sensed: FloatArray, harmonics: int) -> UnloadedFit:
    rows = fourier_rows(angle_rad, harmonics)
    coefficients, _, _, singular = np.linalg.lstsq(rows, sensed, rcond=None)
    spare = len(rows) - rows.shape[1]
    error = sensed - rows @ coefficients
    rms = np.sqrt((error**2).sum(axis=0) / spare) if spare > 0 else np.full(6, np.nan)
    gap, centre = _widest_gap(angle_rad)
    return UnloadedFit(
        coefficients=readonly(coefficients.T.copy()),
        condition=float(singular[0] / max(singular[-1], _FLOOR)),
        residual_rms=readonly(rms),
        covariance=readonly(np.linalg.pinv(rows.T @ rows)),
        widest_gap_rad=gap,
        gap_centre_rad=centre,
        samples=len(rows),
    )


def _information(fit: UnloadedFit, sensed: FloatArray, unknowns: int) -> float:
    """Bayesian information criterion, summed over the axes (Schwarz 1978)."""
    count = len(sensed)
    spare = max(count - unknowns, 0)
    mean_square = np.nan_to_num(fit.residual_rms) ** 2 * spare / count
    floor = (_FLOOR * (1.0 + np.abs(sensed).max())) ** 2
    log_likelihood = float(np.log(np.maximum(mean_square, floor)).sum())
    return count * log_likelihood + unknowns * 6 * float(np.log(count))


def _distinct(angle_rad: FloatArray) -> int:
    places = np.sort(np.remainder(angle_rad, 2 * np.pi))
    return 1 + int((np.diff(places) > SAME_ANGLE_RAD).sum())


def _widest_gap(angle_rad: FloatArray) -> tuple[float, float]:
    places = np.sort(np.remainder(angle_rad, 2 * np.pi))
    gaps = np.diff(np.append(places, places[0] + 2 * np.pi))
    widest = int(np.argmax(gaps))
    centre = places[widest] + gaps[widest] / 2
    return float(gaps[widest]), float(np.remainder(centre + np.pi, 2 * np.pi) - np.pi)
