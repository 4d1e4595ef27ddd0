"""Rauch, Tung and Striebel's backward pass over an estimator's states: offline, with all of the log known.

Written out here because filterpy's takes F x for the mean before a measurement; ours is not linear, and
each state keeps it.
"""

from collections.abc import Sequence

import numpy as np

from model.errors import ModelError
from model.estimator.kalman import symmetric
from model.values.arrays import FloatArray
from model.values.estimate import EstimatorState


def smooth(states: Sequence[EstimatorState]) -> tuple[FloatArray, FloatArray]:
    """Means and covariances given all measurements.

    Args:
        states: Of T ticks in order, T >= 1.

    Returns:
        (T, n) and (T, n, n).

    Raises:
        ModelError: There are no states.
    """
    if not states:
        raise ModelError("there is nothing to smooth: keep the states while the estimator runs")
    count, size = len(states), len(states[0].mean)
    mean = np.empty((count, size))
    covariance = np.empty((count, size, size))
    mean[-1], covariance[-1] = states[-1].mean, states[-1].covariance
    for i in range(count - 2, -1, -1):
        here, after = states[i], states[i + 1]
        before_mean, before_covariance = after.before
        # G = P F' / (F P F' + Q)
        gain = np.linalg.solve(before_covariance, after.transition @ here.covariance).T
        mean[i] = here.mean + gain @ (mean[i + 1] - before_mean)
        spread = gain @ (covariance[i + 1] - before_covariance) @ gain.T
        covariance[i] = symmetric(here.covariance + spread)
    return mean, covariance
