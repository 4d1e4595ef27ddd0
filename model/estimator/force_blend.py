"""Predicted foot forces, weighed between the filter's and those of the robot file alone.

The filter knows friction better, the open loop has the simpler law where feet hardly slip. Which is nearer
to what the sensors measure differs from gait to gait and axis to axis, so it is measured: the weights of
the horizontal axes are the least squares of the last seconds, all of it the open loop's before.
"""

import numpy as np

from model.estimator.settings import RECORD_S, EstimatorSettings
from model.quasistatic.frame import solve_frame
from model.values.arrays import FloatArray, readonly
from model.values.estimate import ForceMemory
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

PRIOR = 1e-5  # squared share of the weight by which they must differ before that counts


def at_start() -> ForceMemory:
    """Nothing is known of either."""
    nothing = readonly(np.zeros(2))
    return ForceMemory(nothing, nothing)


def open_loop(feet: FootMotion, contact: ContactParameters, weight_n: float) -> FloatArray:
    """Forces of the robot file alone over the weight, (N, 3); NaN where it has no answer."""
    share: FloatArray = solve_frame(feet, contact, weight_n).traction.force_B / weight_n
    return share


def learn(
    before: ForceMemory,
    measured: FloatArray,
    filtered: FloatArray,
    plain: FloatArray,
    settings: EstimatorSettings,
) -> ForceMemory:
    """Compare both with a new record of the forces.

    Args:
        before: What is known of them.
        measured: Forces over the weight, (N, 3); NaN where there are none.
        filtered: The filter's.
        plain: Of ``open_loop``.
        settings: Memory.
    """
    apart, left = (filtered - plain)[:, :2], (measured - plain)[:, :2]
    known = np.isfinite(apart + left).all(axis=1)
    if not known.any():
        return before
    new = RECORD_S / settings.learning_s
    apart, left = apart[known], left[known]
    return ForceMemory(
        readonly((1.0 - new) * before.apart + new * (apart**2).sum(axis=0)),
        readonly((1.0 - new) * before.agree + new * (apart * left).sum(axis=0)),
    )


def blended(memory: ForceMemory, filtered: FloatArray, plain: FloatArray) -> FloatArray:
    """Return what is predicted, (N, 3): vertical forces are the filter's, which learns from them."""
    if not np.isfinite(plain).all():
        return filtered
    share = np.clip(memory.agree / (memory.apart + PRIOR), 0.0, 1.0)
    both = filtered.copy()
    both[:, :2] = plain[:, :2] + share * (filtered - plain)[:, :2]
    return both
