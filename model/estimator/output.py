"""From the estimator's state to numbers: covariances, parameters, what is expected of feet; compiled."""

import numpy as np

from model.compiled import compiled, in_place
from model.estimator.frame_kernel import lay_parameters
from model.estimator.settings import Record
from model.values.arrays import BoolArray, FloatArray
from model.values.estimate import FIXED, SCALE

MU, MU_SD, STIFFNESS, STIFFNESS_SD, SHARE, SHARE_SD = range(6)  # rows of what is read out


@compiled
def _spread(rows: FloatArray, covariance: FloatArray, settings: Record, spread: FloatArray) -> None:
    """Covariance of predicted forces: from that of the parameters, and the noise of a measured one.

    A prediction cannot be better than the model that it is judged by.
    """
    count, setting = spread.shape[0], settings[0]
    size = covariance.shape[0] - SCALE  # the common friction, the gyro's bias, the parameters
    by, half = np.zeros((3, size)), np.empty((3, size))
    for k in range(count):
        by[0, 0], by[1, 0] = rows[0, 6 + 3 * k], rows[0, 7 + 3 * k]
        for i in range(3):
            for j in range(2 * count):
                by[i, FIXED - SCALE + j] = rows[1 + j, 6 + 3 * k + i]
            for j in range(size):
                half[i, j] = 0.0
            for other in range(size):  # outside, so that rows of numbers are added at once
                if by[i, other] == 0.0:  # of feet in the air, and of friction for a load
                    continue
                for j in range(size):
                    half[i, j] += by[i, other] * covariance[SCALE + other, SCALE + j]
        for i in range(3):
            for j in range(i + 1):
                total = 0.0
                for other in range(size):
                    total += half[i, other] * by[j, other]
                spread[k, i, j] = spread[k, j, i] = total
        if rows[0, 8 + 3 * k] > 0.0:
            level = by[0, 0] ** 2 + by[1, 0] ** 2
            flat = (setting["force_sd"] * setting["weight_n"]) ** 2 + setting[
                "force_share_sd"
            ] ** 2 * level
            spread[k, 0, 0] += flat
            spread[k, 1, 1] += flat
            spread[k, 2, 2] += (setting["load_sd"] * setting["weight_n"]) ** 2


@in_place
@compiled
def readout_kernel(
    mean: FloatArray, covariance: FloatArray, mu: FloatArray, stiffness: FloatArray,
    contact: BoolArray, rows: FloatArray, slip: FloatArray, elsewhere: FloatArray, shake: FloatArray,
    settings: Record, feet: FloatArray, body: FloatArray, tilt: FloatArray, spread: FloatArray,
    slipping: BoolArray,
) -> None:  # fmt: skip
    """Read out a state. Where the model has no answer it is NaN, and so is what follows from it.

    Args:
        mean: (n,).
        covariance: P, (n, n).
        mu: The robot file's friction coefficients, (N,).
        stiffness: Its stiffnesses, (N,) [N/m].
        contact: Loaded feet, (N,).
        rows: Of ``Neighbourhood``.
        slip: Of the feet, (N, 2) [m/s].
        elsewhere: Covariance of the pose by the companions, of ``Companions``, (3, 3).
        shake: Variance that vibration adds to the velocity, (3,).
        settings: Of ``record_of``.
        feet: Out: MU and the sd of its logarithm, STIFFNESS [N/m] and that of its, SHARE of the weight and
            its own, (6, N).
        body: Out: covariances of pose and velocity, (2, 3, 3).
        tilt: Out: roll and pitch, (2,) [rad].
        spread: Out: covariance of the predicted forces, (N, 3, 3) [N^2].
        slipping: Out: feet that clearly slip, (N,).
    """
    count, setting = mu.size, settings[0]
    _spread(rows, covariance, settings, spread)
    for i in range(3):
        for j in range(3):
            body[0, i, j] = covariance[i, j] + elsewhere[i, j]
            body[1, i, j] = covariance[3 + i, 3 + j] + (shake[i] if i == j else 0.0)
    tilt[0], tilt[1] = np.arctan(rows[0, 4]), np.arctan(rows[0, 3])
    lay_parameters(mean, stiffness, mu, feet[STIFFNESS], feet[MU])
    for k in range(count):
        grip, spring = FIXED + k, FIXED + count + k
        # log of the common friction and log mu of a leg vary together
        both = covariance[grip, grip] + covariance[SCALE, SCALE] + 2.0 * covariance[SCALE, grip]
        feet[MU_SD, k] = np.sqrt(max(both, 0.0))
        feet[STIFFNESS_SD, k] = np.sqrt(covariance[spring, spring])
        feet[SHARE, k] = rows[0, 8 + 3 * k] / setting["weight_n"]
        feet[SHARE_SD, k] = np.sqrt(spread[k, 2, 2]) / setting["weight_n"]
        speed = np.sqrt(slip[k, 0] ** 2 + slip[k, 1] ** 2)
        slipping[k] = contact[k] and speed > setting["slip_speed"]
