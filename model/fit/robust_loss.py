"""Loss functions of a robust fit, with the derivatives that its errors need.

The names and meanings are those of ``scipy.optimize.least_squares``: with z = (r / scale)^2 the fit
minimises sum scale^2 rho(z) / 2. A penalty (a wish about the parameters, not a measurement) must stay
quadratic however large it is, which the names alone cannot say; hence functions of our own.
"""

from collections.abc import Callable
from typing import Literal, get_args

import numpy as np
from scipy.optimize import least_squares

from model.errors import ModelError
from model.values.arrays import FloatArray

Loss = Literal["linear", "soft_l1", "huber", "cauchy", "arctan"]
TOLERANCE = 1e-12
MOST_EVALUATIONS = 200
LOSSES: tuple[Loss, ...] = get_args(Loss)


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
    """Loss and its first two derivatives by z.

    Args:
        loss: Its name.
        z: Squared residuals over the squared scale, (M,), not negative.

    Returns:
        rho, rho', rho'', (3, M).
    """
    one = np.ones_like(z)
    if loss == "linear":
        return np.stack([z, one, 0 * z])
    if loss == "soft_l1":
        root = np.sqrt(1 + z)
        return np.stack([2 * (root - 1), 1 / root, -0.5 / root**3])
    if loss == "huber":
        root = np.sqrt(np.maximum(z, 1.0))
        inside = z <= 1
        return np.stack(
            [
                np.where(inside, z, 2 * root - 1),
                1 / root,
                np.where(inside, 0.0, -0.5 / root**3),
            ]
        )
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
    penalties: int = 0,
    lowest: FloatArray | None = None,
) -> tuple[FloatArray, bool]:
    """Minimise the loss of residuals with ``scipy.optimize.least_squares``.

    Args:
        residual: (M,) of parameters (P,).
        jacobian: (M, P) of parameters (P,).
        start: (P,).
        loss: Its name.
        loss_scale: Size of a residual from which on it is an outlier.
        penalties: How many of the last residuals are penalties, which stay quadratic.
        lowest: Lower bounds of the parameters, (P,), if there are any.

    Returns:
        Parameters at the minimum, (P,), and whether the search ended by itself.
    """

    def evaluate(z: FloatArray) -> FloatArray:
        values = rho(loss, z)
        if penalties:
            values[:, -penalties:] = rho("linear", z[-penalties:])
        return values

    result = least_squares(
        residual,
        start,
        jac=jacobian,
        loss=evaluate,  # type: ignore[arg-type]  # the stubs want a protocol of their own
        f_scale=loss_scale,
        bounds=(-np.inf if lowest is None else lowest, np.inf),
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
