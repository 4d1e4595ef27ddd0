"""Robust least squares with ``scipy.optimize.least_squares``, and the derivatives that its errors need.

With z = (r / scale)^2 the fit minimises sum scale^2 rho(z) / 2. Names of losses alone are not enough: a
penalty (a wish about the parameters, not a measurement) must stay quadratic however large it is, and errors
need rho' and rho''.
"""

from collections.abc import Callable
from typing import Literal, get_args

import numpy as np
from scipy.optimize import least_squares

from model.errors import ModelError
from model.values.arrays import FloatArray

Loss = Literal["linear", "soft_l1", "huber", "cauchy", "arctan"]
LOSSES: tuple[Loss, ...] = get_args(Loss)
TOLERANCE = 1e-12
MOST_EVALUATIONS = 200
# Pull towards the start, so that a direction which does not show stays there.
TETHER = 1e-6


def check_loss(loss: str, scale: float) -> None:
    """Refuse a loss that is none.

    Raises:
        ModelError: Unknown name, or a scale that is not positive.
    """
    if loss not in LOSSES:
        raise ModelError(f"there is no loss {loss!r}; choose one of {', '.join(LOSSES)}")
    if not (np.isfinite(scale) and scale > 0):
        raise ModelError(f"the scale of a loss must be positive, not {scale}")


def rho(loss: Loss, z: FloatArray) -> FloatArray:
    """Loss and its first two derivatives by z, as in ``scipy.optimize.least_squares``.

    Args:
        loss: Its name.
        z: Squared residuals over the squared scale, (M,), not negative.

    Returns:
        rho, rho', rho'', (3, M).
    """
    linear, root = (z, np.ones_like(z), np.zeros_like(z)), np.sqrt(1 + z)
    if loss == "linear":
        return np.stack(linear)
    if loss == "soft_l1":
        return np.stack([2 * (root - 1), 1 / root, -0.5 / root**3])
    if loss == "huber":
        root = np.sqrt(np.maximum(z, 1.0))
        return np.where(z <= 1, linear, (2 * root - 1, 1 / root, -0.5 / root**3))
    if loss == "cauchy":
        return np.stack([np.log1p(z), 1 / (1 + z), -1 / (1 + z) ** 2])
    return np.stack([np.arctan(z), 1 / (1 + z**2), -2 * z / (1 + z**2) ** 2])


def minimise(
    residual: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    *,
    loss: Loss,
    loss_scale: float,
    size: float,
    penalties: int = 0,
    lowest: FloatArray | float = -np.inf,
) -> tuple[FloatArray, bool]:
    """Minimise the loss of residuals from ``start``, to which a weak tether holds what does not show.

    Args:
        residual: (M,) of parameters (P,).
        jacobian: (M, P) of parameters (P,).
        start: (P,).
        loss: Its name.
        loss_scale: Size of a residual from which on it is an outlier.
        size: Norm of what was measured, beside which the tether is weak.
        penalties: How many of the last residuals are penalties, which stay quadratic.
        lowest: Lower bounds of the parameters, (P,) or one for all.

    Returns:
        Parameters at the minimum, (P,), and whether the search ended by itself.
    """
    hold = TETHER * size * np.eye(len(start))
    wishes = penalties + len(start)

    def tethered(at: FloatArray) -> FloatArray:
        return np.append(residual(at), hold @ (at - start))

    def slope(at: FloatArray) -> FloatArray:
        return np.concatenate([jacobian(at), hold])

    def evaluate(z: FloatArray) -> FloatArray:
        return np.concatenate([rho(loss, z[:-wishes]), rho("linear", z[-wishes:])], axis=1)

    result = least_squares(
        tethered,
        start,
        jac=slope,
        loss=evaluate,  # type: ignore[arg-type]  # the stubs want a protocol of their own
        f_scale=loss_scale,
        bounds=(lowest, np.inf),
        xtol=TOLERANCE,
        ftol=TOLERANCE,
        gtol=TOLERANCE,
        max_nfev=MOST_EVALUATIONS,
    )
    return np.asarray(result.x, dtype=np.float64), bool(result.status > 0)


def influence(loss: Loss, residual: FloatArray, scale: float) -> tuple[FloatArray, FloatArray]:
    """How much each residual pulls: psi = r rho' and its slope d psi / d r, (M,) each."""
    z = (residual / scale) ** 2
    _, first, second = rho(loss, z)
    return residual * first, first + 2 * z * second
