"""What the estimator says of each foot after a step, compiled: parameters, loads, forces, with spreads."""

import numpy as np

from model.compiled import COUNT, FLAG, NUMBER, compile_for, compiled, given, out
from model.values.arrays import BoolArray, FloatArray

# Rows of what is said of the feet.
MU, MU_SD, STIFFNESS, STIFFNESS_SD, SHARE, SHARE_SD, ROWS = 0, 1, 2, 3, 4, 5, 6


@compiled
def _forces(
    force_xy: FloatArray,
    load: FloatArray,
    by_parameters: FloatArray,
    load_by_stiffness: FloatArray,
    covariance: FloatArray,
    scale: int,
    force_sd: float,
    force_share_sd: float,
    load_sd: float,
    force: FloatArray,
    spread: FloatArray,
) -> None:
    """Predicted forces and their covariance from that of the parameters, and the noise of a measured one.

    Args:
        force_xy: (N, 2) [N].
        load: (N,) [N].
        by_parameters: (N, 2, 2 N).
        load_by_stiffness: (N, N).
        covariance: P, (n, n).
        scale: Where the log of the common friction stands in the state.
        force_sd: Of a horizontal force [N].
        force_share_sd: Of a horizontal force over its size.
        load_sd: Of a vertical force [N].
        force: Out: (N, 3) [N].
        spread: Out: (N, 3, 3) [N^2].
    """
    count = load.size
    parameters = 2 * count
    fixed = covariance.shape[0] - parameters
    by = np.zeros((3, parameters + 1))
    half = np.empty((3, parameters + 1))
    for k in range(count):
        for i in range(2):
            force[k, i] = force_xy[k, i]
            by[i, 0] = force_xy[k, i]
            for j in range(parameters):
                by[i, 1 + j] = by_parameters[k, i, j]
        force[k, 2] = load[k]
        for j in range(count):
            by[2, 1 + count + j] = load_by_stiffness[k, j]
        for i in range(3):
            for j in range(parameters + 1):
                row = scale if j == 0 else fixed + j - 1
                total = by[i, 0] * covariance[scale, row]
                for other in range(parameters):
                    total += by[i, 1 + other] * covariance[fixed + other, row]
                half[i, j] = total
        for i in range(3):
            for j in range(i + 1):
                total = 0.0
                for other in range(parameters + 1):
                    total += half[i, other] * by[j, other]
                spread[k, i, j] = total
                spread[k, j, i] = total
        if load[k] > 0.0:
            level = force_xy[k, 0] ** 2 + force_xy[k, 1] ** 2
            flat = force_sd**2 + force_share_sd**2 * level
            spread[k, 0, 0] += flat
            spread[k, 1, 1] += flat
            spread[k, 2, 2] += load_sd**2


@compiled
def readout_kernel(
    mean: FloatArray,
    covariance: FloatArray,
    mu: FloatArray,
    stiffness: FloatArray,
    force_xy: FloatArray,
    load: FloatArray,
    by_parameters: FloatArray,
    load_by_stiffness: FloatArray,
    slip: FloatArray,
    contact: BoolArray,
    scale: int,
    weight: float,
    force_sd: float,
    force_share_sd: float,
    load_sd: float,
    slip_speed: float,
    feet: FloatArray,
    slipping: BoolArray,
    force: FloatArray,
    spread: FloatArray,
) -> None:
    """Read out a state. Where the model has no answer its arrays are NaN, and so is what follows.

    Args:
        mean: (n,).
        covariance: P, (n, n).
        mu: The robot file's friction coefficients, (N,).
        stiffness: Its stiffnesses, (N,) [N/m].
        force_xy: (N, 2) [N], with the next three as in ``model.estimator.neighbourhood``.
        load: (N,) [N].
        by_parameters: (N, 2, 2 N).
        load_by_stiffness: (N, N).
        slip: (N, 2) [m/s].
        contact: Loaded feet, (N,).
        scale: Where the log of the common friction stands in the state.
        weight: Weight carried [N].
        force_sd: Of a horizontal force [N].
        force_share_sd: Of a horizontal force over its size.
        load_sd: Of a vertical force [N].
        slip_speed: A foot in contact slips above this [m/s].
        feet: Out: rows MU to SHARE_SD, (ROWS, N).
        slipping: Out: (N,).
        force: Out: (N, 3) [N].
        spread: Out: (N, 3, 3) [N^2].
    """
    count = load.size
    fixed = mean.size - 2 * count
    _forces(
        force_xy, load, by_parameters, load_by_stiffness, covariance, scale, force_sd,
        force_share_sd, load_sd, force, spread,
    )  # fmt: skip
    for k in range(count):
        grip, spring = fixed + k, fixed + count + k
        feet[MU, k] = mu[k] * np.exp(mean[scale] + mean[grip])
        # log of the common friction and log mu of a leg vary together
        both = covariance[grip, grip] + covariance[scale, scale] + 2.0 * covariance[scale, grip]
        feet[MU_SD, k] = np.sqrt(max(both, 0.0))
        feet[STIFFNESS, k] = stiffness[k] * np.exp(mean[spring])
        feet[STIFFNESS_SD, k] = np.sqrt(covariance[spring, spring])
        feet[SHARE, k] = load[k] / weight
        feet[SHARE_SD, k] = np.sqrt(spread[k, 2, 2]) / weight
        slipping[k] = contact[k] and slip[k, 0] ** 2 + slip[k, 1] ** 2 > slip_speed**2


def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    compile_for(
        readout_kernel, *given(1, 2, 1, 1, 2, 1, 3, 2, 2), *given(1, kind=FLAG), COUNT,
        *(NUMBER,) * 5, *out(2), *out(1, kind=FLAG), *out(2, 3),
    )  # fmt: skip
