"""What a fit found, how well, and what its data cannot tell.

Errors are those of linearised least squares, variance (J^T J + P)^-1, with the variance of the
residuals for a plain fit and Huber's form E[psi^2] / E[psi']^2 for a robust one (Huber, "Robust
Statistics", chapter 7; good for many residuals and losses whose psi' is positive on average). They take
every residual for independent: neighbouring frames of a log are not, so that on a log they are too
small by about the root of the number of frames over which errors keep their sign. A model that does
not hold (Coulomb's robot, viscous fit) has a bias that no such error knows.

A direction of the parameters is *undetermined* if its singular value is nothing beside the largest, or
if one unit along it (a factor e of a stiffness or mu, 1 of w) changes the residuals by less than their
noise. Every parameter with a share in such a direction gets NaN for its errors.
"""

from dataclasses import dataclass

import numpy as np

from model.robust_loss import Loss, influence
from model.signals import BoolArray, FloatArray, readonly

# Singular values below this share of the largest are rounding.
SINGULAR_TOLERANCE = 1e-6
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
        undetermined: Names of the parameters that the data cannot tell; their values are a
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
    """Covariance of the search parameters, and what the data leaves open.

    Attributes:
        covariance: (P, P) over determined directions; NaN for undetermined parameters.
        undetermined: (P,) bool.
        rank: Number of determined directions.
    """

    covariance: FloatArray
    undetermined: BoolArray
    rank: int


def spread(
    jacobian: FloatArray,
    residual: FloatArray,
    *,
    lost: int = 0,
    loss: Loss = "linear",
    loss_scale: float = 1.0,
    penalty: FloatArray | None = None,
    conventions: FloatArray | None = None,
) -> Spread:
    """Covariance from Jacobian and residuals, and the undetermined parameters.

    Args:
        jacobian: Of the measured residuals by the search parameters, (M, P); a unit of every search
            parameter is a large change (a factor e, a w of 1).
        residual: Measured residuals, (M,).
        lost: Degrees of freedom used up by other than these parameters (a scale a frame).
        loss: Loss of the fit.
        loss_scale: Its scale, units of the residual.
        penalty: Square of the penalty's Jacobian, (P, P); widens nothing, only steadies.
        conventions: Directions that a convention holds fast, (P, C), orthonormal; they count neither
            as known nor as unknown.
    """
    count = jacobian.shape[1]
    free = np.eye(count)
    if conventions is not None and conventions.size:
        # an orthonormal basis of what the conventions leave: the rest of a full QR
        free = np.linalg.qr(conventions, mode="complete")[0][:, conventions.shape[1] :]
    variance = _variance(residual, lost + free.shape[1], loss, loss_scale)
    reduced = jacobian @ free
    values, vectors = np.linalg.eigh(reduced.T @ reduced)
    singular = np.sqrt(np.maximum(values, 0.0))
    least = max(SINGULAR_TOLERANCE * singular[-1], np.sqrt(variance), np.finfo(float).tiny)
    known = singular > least
    unknown = free @ vectors[:, ~known]
    undetermined = np.sqrt(np.sum(unknown**2, axis=1)) > COMPONENT_TOLERANCE
    basis = free @ vectors[:, known]
    normal = np.diag(values[known])
    if penalty is not None:
        normal = normal + basis.T @ penalty @ basis
    covariance = variance * basis @ np.linalg.solve(normal, basis.T)
    covariance[undetermined] = covariance[:, undetermined] = np.nan
    return Spread(readonly(covariance), readonly(undetermined), int(known.sum()))


def _variance(residual: FloatArray, used: int, loss: Loss, loss_scale: float) -> float:
    freedom = len(residual) - used
    if freedom <= 0:
        return np.inf
    pull, slope = influence(loss, residual, loss_scale)
    mean_slope = float(np.mean(slope))
    if mean_slope <= 0:  # most residuals lie where the loss is flat: nothing can be said
        return np.inf
    return float(pull @ pull) / freedom / mean_slope**2
