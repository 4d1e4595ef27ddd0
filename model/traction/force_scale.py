"""One positive scalar a frame that puts the viscous ansatz in newtons (the paper's sigma, sec:tripod).

The balance of the ansatz holds for any scale of its forces, so a comparison with a sensor needs one for
each frame. The paper prints sigma = argmin_c sum_k (c |Fhat_k| - |F_k|)^2, of norms, and says that it fits
the twelve horizontal components. The two differ: norms reward a force of the right size and the wrong
direction. We fit the components unless told otherwise.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import BoolArray, FloatArray, readonly


@dataclass(frozen=True, slots=True, eq=False)
class ForceScale:
    """Scales of F frames.

    Attributes:
        scale: (F,), not negative; NaN where no foot has both a predicted and a measured force.
        clamped: (F,) the best scale was negative (the prediction points the wrong way); it is 0.
    """

    scale: FloatArray
    clamped: BoolArray


def force_scale(
    predicted_xy: FloatArray, measured_xy: FloatArray, *, norms: bool = False
) -> ForceScale:
    """Scale of the predicted horizontal forces that fits the measured ones best, frame by frame.

    Args:
        predicted_xy: Predicted horizontal force of each foot up to one scale a frame, (F, N, 2).
        measured_xy: Measured, same axes, (F, N, 2) [N]. A foot with a NaN in either is left out.
        norms: Fit the sizes of the forces instead of their components, as the paper's formula has it.

    Returns:
        The scales [N per unit of the prediction].

    Raises:
        ModelError: Shapes do not fit.
    """
    if predicted_xy.shape != measured_xy.shape or predicted_xy.shape[2:] != (2,):
        raise ModelError(
            f"forces must both be (F, N, 2), not {predicted_xy.shape} and {measured_xy.shape}"
        )
    known = (np.isfinite(predicted_xy) & np.isfinite(measured_xy)).all(axis=2, keepdims=True)
    predicted = np.where(known, predicted_xy, 0.0)
    measured = np.where(known, measured_xy, 0.0)
    if norms:
        predicted = np.linalg.norm(predicted, axis=2, keepdims=True)
        measured = np.linalg.norm(measured, axis=2, keepdims=True)
    power = np.sum(predicted**2, axis=(1, 2))
    product = np.sum(predicted * measured, axis=(1, 2))
    there = power > 0
    best = np.where(there, product / np.where(there, power, 1.0), np.nan)
    clamped = there & (best < 0)
    return ForceScale(readonly(np.where(clamped, 0.0, best)), readonly(clamped))
