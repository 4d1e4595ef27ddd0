"""Predicted foot forces, weighed between the filter's and those of the robot file alone.

The filter knows friction better, the open loop has the simpler law where feet hardly slip. Which is nearer
to what the sensors measure differs from gait to gait and axis to axis, so it is measured: the weights of
the horizontal axes are the least squares of the last seconds, all of it the open loop's before.
"""

import numpy as np

from model.compiled import compiled, in_place
from model.quasistatic.frame import frame_kernel
from model.values.arrays import FloatArray, readonly
from model.values.estimate import ForceMemory

PRIOR = 1e-5  # squared share of the weight by which they must differ before that counts


def at_start() -> ForceMemory:
    """Nothing is known of either."""
    nothing = readonly(np.zeros(2))
    return ForceMemory(nothing, nothing)


@compiled
def forces_kernel(
    feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray, mu: FloatArray,
    anisotropy: FloatArray, weight: float, apart: FloatArray, agree: FloatArray,
    measured: FloatArray, fresh: bool, filtered: FloatArray, new: float, predicted: FloatArray,
    apart_now: FloatArray, agree_now: FloatArray,
) -> bool:  # fmt: skip
    """Solve the open loop, predict the forces of a tick, and compare both with a new record of them.

    Vertical forces are the filter's, which learns from them.

    Args:
        feet: Of ``frame_kernel``, (N, 3) [m], as are the next five.
        feet_velocity: (N, 3) [m/s].
        stiffness: (N,) [N/m].
        mu: (N,).
        anisotropy: (N, 2).
        weight: [N].
        apart: Of ``blend_kernel``, (2,), as are all that follow but the last three.
        agree: (2,).
        measured: (N, 3).
        fresh: Whether they are there.
        filtered: (N, 3).
        new: Share of a record.
        predicted: Out: the forces as they were known before the record, (N, 3) [N].
        apart_now: Out: what is known now, (2,).
        agree_now: Out: the same.

    Returns:
        Whether anything was learned.
    """
    count = mu.size
    numbers, loaded = np.empty(6 + 6 * count), np.empty(count, dtype=np.bool_)
    frame_kernel(feet, feet_velocity, stiffness, mu, anisotropy, weight, numbers, loaded)
    plain = numbers[6 + 3 * count :].reshape(count, 3)
    for k in range(count):
        for i in range(3):
            plain[k, i] = plain[k, i] / weight
    known: bool = blend_kernel(
        apart, agree, measured, fresh, filtered, plain, weight, new, predicted, apart_now, agree_now
    )
    return known


@in_place
@compiled
def blend_kernel(
    apart: FloatArray, agree: FloatArray, measured: FloatArray, fresh: bool, filtered: FloatArray,
    plain: FloatArray, weight: float, new: float, predicted: FloatArray, apart_now: FloatArray,
    agree_now: FloatArray,
) -> bool:  # fmt: skip
    """Predict forces, and compare with a new record.

    Args:
        apart: What is known, of ``ForceMemory``, (2,).
        agree: The same.
        measured: Forces over the weight, (N, 3).
        fresh: Whether they are there.
        filtered: The filter's, (N, 3).
        plain: The open loop's, (N, 3).
        weight: [N].
        new: Share of a new record in what is known.
        predicted: Out: (N, 3) [N].
        apart_now: Out: what is known now, (2,).
        agree_now: Out: the same.

    Returns:
        Whether anything was learned.
    """
    count = plain.shape[0]
    answered = True
    for k in range(count):
        for i in range(3):
            answered = answered and abs(plain[k, i]) < np.inf
    for i in range(2):
        share = min(max(agree[i] / (apart[i] + PRIOR), 0.0), 1.0)
        for k in range(count):
            value = filtered[k, i]
            if answered:
                value = plain[k, i] + share * (filtered[k, i] - plain[k, i])
            predicted[k, i] = weight * value
    known = False
    square0, square1, product0, product1 = 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        predicted[k, 2] = weight * filtered[k, 2]
        x, y = filtered[k, 0] - plain[k, 0], filtered[k, 1] - plain[k, 1]
        left, aside = measured[k, 0] - plain[k, 0], measured[k, 1] - plain[k, 1]
        if fresh and abs(x + left) < np.inf and abs(y + aside) < np.inf:
            known = True
            square0, square1 = square0 + x * x, square1 + y * y
            product0, product1 = product0 + x * left, product1 + y * aside
    apart_now[0] = (1.0 - new) * apart[0] + new * square0
    apart_now[1] = (1.0 - new) * apart[1] + new * square1
    agree_now[0] = (1.0 - new) * agree[0] + new * product0
    agree_now[1] = (1.0 - new) * agree[1] + new * product1
    return known
