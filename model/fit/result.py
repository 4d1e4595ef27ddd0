"""A least-squares search, what a fit came to, how well, and what its data do not determine.

Errors are those of linearised least squares, variance (J^T J + P)^-1, with the variance of the residuals.
They take every residual for independent: neighbouring frames of a log are not, so that on a log they are
too small by about the root of the number of frames over which errors keep their sign. A model that does
not hold (Coulomb's robot, viscous fit) has a bias that no such error knows.

A direction of the parameters is *undetermined* if its singular value is nothing beside the largest, or
if one unit along it (a factor e of a stiffness or mu, 1 of w) changes the residuals by less than their
noise. Every parameter with a share in such a direction gets NaN for its errors.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from model.values.arrays import BoolArray, FloatArray, readonly

TOLERANCE = 1e-12
MOST_EVALUATIONS = 200
# Pull towards the start, so that a direction which does not show stays there.
TETHER = 1e-6
# Singular values below this share of the largest are rounding.
SINGULAR_TOLERANCE = 1e-6
# And so are those below this share of the measurements.
ROUNDING = 1e-10
# A parameter's component along an undetermined direction of length 1 that makes it undetermined too.
COMPONENT_TOLERANCE = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class FitResult:
    """Outcome of a fit of P parameters to some of F frames.

    Attributes:
        names: Names of the parameters, such as ``mu HL``, P of them.
        values: (P,), units as the fit says.
        covariance: (P, P); rows and columns of undetermined parameters are NaN.
        residual_rms: Root mean square of the measured residuals, units as the fit says.
        frames_used: Frames that had a residual.
        left_out: Why frames (or single feet) were left out, and how many.
        undetermined: Names of the parameters that the data do not determine; their values are a
            convention or an accident.
        warnings: One sentence for each thing that a reader must know.
        converged: Whether the search ended by itself.
    """

    names: tuple[str, ...]
    values: FloatArray
    covariance: FloatArray
    residual_rms: float
    frames_used: int
    left_out: tuple[tuple[str, int], ...]
    undetermined: tuple[str, ...]
    warnings: tuple[str, ...]
    converged: bool

    @property
    def standard_errors(self) -> FloatArray:
        """(P,) one standard deviation of each value; NaN where undetermined."""
        errors: FloatArray = np.sqrt(np.diag(self.covariance))
        return errors


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """Covariance of the P search parameters, and what the data leave open.

    Attributes:
        covariance: (P, P); NaN for undetermined parameters.
        undetermined: (P,) bool.
        reference: (P,) bool, the parameters that may define a common scale: determined next to each
            other. All False where there is no common scale, or none of them is determined.
    """

    covariance: FloatArray
    undetermined: BoolArray
    reference: BoolArray


def minimise(
    residual: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    *,
    size: float,
    lowest: FloatArray | float = -np.inf,
) -> tuple[FloatArray, bool]:
    """Minimise the sum of squares from ``start``, to which a weak tether holds what does not show.

    Args:
        residual: (M,) of parameters (P,).
        jacobian: (M, P) of parameters (P,).
        start: (P,).
        size: Norm of what was measured, beside which the tether is weak.
        lowest: Lower bounds of the parameters, (P,) or one for all.

    Returns:
        Parameters at the minimum, (P,), and whether the search ended by itself.
    """
    hold = TETHER * size * np.eye(len(start))

    def tethered(at: FloatArray) -> FloatArray:
        return np.append(residual(at), hold @ (at - start))

    def slope(at: FloatArray) -> FloatArray:
        return np.concatenate([jacobian(at), hold])

    result = least_squares(
        tethered,
        start,
        jac=slope,
        bounds=(lowest, np.inf),
        xtol=TOLERANCE,
        ftol=TOLERANCE,
        gtol=TOLERANCE,
        max_nfev=MOST_EVALUATIONS,
    )
    return np.asarray(result.x, dtype=np.float64), bool(result.status > 0)


def spread(
    jacobian: FloatArray,
    residual: FloatArray,
    size: float,
    *,
    lost: int = 0,
    penalty: FloatArray | None = None,
    scaled: BoolArray | None = None,
    scale_share: FloatArray | None = None,
) -> Spread:
    """Covariance from Jacobian and residuals, and the undetermined parameters.

    Some parameters may be logarithms of things whose common scale is held by convention. The
    covariance is then that of the logarithms after scaling, which is theirs next to the mean of the
    reference.

    Args:
        jacobian: Of the measured residuals by the search parameters, (M, P); a unit of every search
            parameter is a large change (a factor e, a w of 1).
        residual: Measured residuals, (M,).
        size: Norm of what was measured, beside which rounding is nothing.
        lost: Degrees of freedom used up by other than these parameters (a scale a frame).
        penalty: J^T J of the penalty, (P, P). It narrows errors; it never makes anything determined.
        scaled: (P,) the logarithms with a conventional common scale; None if there are none.
        scale_share: Their values, whose mean is held, (P,); needed with ``scaled``.
    """
    count = jacobian.shape[1]
    freedom = len(residual) - lost - count + int(scaled is not None)
    variance = float(residual @ residual) / freedom if freedom > 0 else np.inf
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    singular = np.sqrt(np.maximum(values, 0.0))
    least = max(SINGULAR_TOLERANCE * singular[-1], ROUNDING * size, np.sqrt(variance))
    known = singular > least
    null, basis = vectors[:, ~known], vectors[:, known]
    reference = np.zeros(count, dtype=bool)
    undetermined = _in_null_space(null)
    to_scaled = np.eye(count)
    if scaled is not None and scale_share is not None:
        reference, undetermined = _best_reference(null, scaled)
        to_scaled = _scaling(scaled, np.where(reference, scale_share, 0.0))
    normal = np.diag(values[known])
    if penalty is not None:
        normal = normal + basis.T @ penalty @ basis
    scaled_basis = to_scaled @ basis
    covariance = np.full((count, count), np.nan)
    if known.any():
        covariance = variance * scaled_basis @ np.linalg.solve(normal, scaled_basis.T)
    covariance[undetermined] = covariance[:, undetermined] = np.nan
    return Spread(readonly(covariance), readonly(undetermined), readonly(reference))


def _in_null_space(null: FloatArray) -> BoolArray:
    share: BoolArray = np.sqrt(np.sum(null**2, axis=1)) > COMPONENT_TOLERANCE
    return share


def _scaling(scaled: BoolArray, weights: FloatArray) -> FloatArray:
    """Matrix that takes the weighted mean of some logarithms out of all scaled ones."""
    total = float(weights.sum())
    mean = weights / total if total > 0 else weights
    matrix: FloatArray = np.eye(len(scaled)) - np.outer(scaled, mean)
    return matrix


def _best_reference(null: FloatArray, scaled: BoolArray) -> tuple[BoolArray, BoolArray]:
    """Largest set of scaled parameters that the data tell next to each other, and what is left open."""
    best = np.zeros(len(scaled), dtype=bool), scaled | _in_null_space(null)
    for one in np.flatnonzero(scaled):
        single = np.zeros(len(scaled))
        single[one] = 1.0
        unknown = _in_null_space(_scaling(scaled, single) @ null)
        determined = scaled & ~unknown
        # next to itself a parameter is always told: one alone is no reference unless it is the only one
        if determined.sum() > max(best[0].sum(), min(1, scaled.sum() - 1)):
            best = determined, unknown
    return best
