"""Covariances of the estimator: predicted, tested, mended."""

import numpy as np

from model.estimator_step_kernel import sound_kernel
from model.estimator_update_kernel import predict_kernel
from model.signals import FloatArray


def predicted(covariance: FloatArray, transition: FloatArray, noise: FloatArray) -> FloatArray:
    """Covariance F P F' + Q of a predicted mean, exactly symmetric.

    Args:
        covariance: P before, (n, n).
        transition: F, (n, n).
        noise: Q, (n, n).
    """
    after = np.empty_like(covariance)
    predict_kernel(covariance, transition, noise, after)
    return after


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
