"""One family of friction laws from Coulomb's to the viscous-Coulomb ansatz (eqn:h2), and their gap.

A foot that slips at v feels F = -mu N H(|v|, eps) v with

    H(v, eps) = (eps + v) / (eps + v^2)

eps -> 0 gives Coulomb's law (H = 1/v), eps -> infinity the ansatz (H = 1). As printed, eps is added
to a speed and to a squared speed, so the speeds are numbers: speed over 1 m/s.
"""

import numpy as np

from model.values.arrays import FloatArray


def drag(speed: FloatArray | float, eps: float) -> FloatArray:
    """H of eqn:h2: drag per unit of mu N.

    Args:
        speed: Slip speed, any shape [m/s], not negative.
        eps: 0 is Coulomb's law, ``inf`` the viscous-Coulomb ansatz.

    Returns:
        H [s/m], the shape of ``speed``; infinite at rest under Coulomb's law.
    """
    v = np.asarray(speed, dtype=np.float64)
    if np.isinf(eps):
        return np.ones_like(v)
    with np.errstate(divide="ignore", invalid="ignore"):
        if eps == 0:
            coulomb: FloatArray = np.divide(1.0, v)
            return coulomb
        between: FloatArray = (eps + v) / (eps + v**2)
        return between


def force_share(speed: FloatArray | float, eps: float) -> FloatArray:
    """Horizontal force over mu N at a slip speed: v H(v, eps).

    Args:
        speed: Slip speed, any shape [m/s].
        eps: As in ``drag``.

    Returns:
        The shape of ``speed``. At rest it is 0, also under Coulomb's law, whose force there can be
        anything from 0 to 1.
    """
    v = np.asarray(speed, dtype=np.float64)
    moving = v > 0
    share: FloatArray = np.where(moving, v * drag(np.where(moving, v, 1.0), eps), 0.0)
    return share


def ansatz_error(change: FloatArray) -> FloatArray:
    """Relative error of the ansatz, matched to Coulomb's law at v = (1, 0), at v + change (fig:Fv-Fc).

    Both laws point against the slip, so only the magnitudes differ: mu N |v + change| against mu N.

        error = | |v + change| - 1 |

    Across the sliding direction this grows with the square of the change (2 % at 0.2), along it in
    proportion (20 % at 0.2): the paper's "within 2 %" holds only across (erratum E9).

    Args:
        change: Change of the slip velocity over the slip speed, (..., 2): along it, across it.

    Returns:
        (...), 0.02 is 2 %.
    """
    speed = np.hypot(1.0 + change[..., 0], change[..., 1])
    error: FloatArray = np.abs(speed - 1.0)
    return error
