"""Predicted foot forces, weighed between the filter's and those of the robot file alone.

The filter knows friction better, the open loop has the simpler law where feet hardly slip. Which is nearer
to what the sensors measure differs from gait to gait and axis to axis, so it is measured: the weights of
the horizontal axes are the least squares of the last seconds, all of it the open loop's before.
"""

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, compiled, given, out
from model.estimator.settings import RECORD_S, EstimatorSettings
from model.quasistatic.frame import frame_forces
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
    share: FloatArray = frame_forces(feet, contact, weight_n) / weight_n
    return share


def predict(
    before: ForceMemory,
    measured: FloatArray | None,
    filtered: FloatArray,
    plain: FloatArray,
    weight_n: float,
    settings: EstimatorSettings,
) -> tuple[FloatArray, ForceMemory]:
    """Predict the forces of a tick, and compare both with a new record of them.

    Vertical forces are the filter's, which learns from them.

    Args:
        before: What is known of both.
        measured: Forces over the weight, (N, 3), NaN where there are none; None without a new record.
        filtered: The filter's.
        plain: Of ``open_loop``.
        weight_n: The weight [N].
        settings: Memory.

    Returns:
        The forces as they were known before the record, (N, 3) [N]; what is known now.
    """
    predicted, apart, agree = np.empty(plain.shape), np.empty(2), np.empty(2)
    known = blend_kernel(
        before.apart, before.agree, filtered if measured is None else measured, measured is not None,
        filtered, plain, weight_n, RECORD_S / settings.learning_s, predicted, apart, agree,
    )  # fmt: skip
    return readonly(predicted), ForceMemory(readonly(apart), readonly(agree)) if known else before


@compiled
def blend_kernel(
    apart: FloatArray, agree: FloatArray, measured: FloatArray, fresh: bool, filtered: FloatArray,
    plain: FloatArray, weight: float, new: float, predicted: FloatArray, apart_now: FloatArray,
    agree_now: FloatArray,
) -> bool:  # fmt: skip
    """Predict forces, and compare with a new record: the arguments of ``predict``.

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


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(blend_kernel, *given(1, 1, 2), FLAG, *given(2, 2), NUMBER, NUMBER, *out(2, 1, 1))
