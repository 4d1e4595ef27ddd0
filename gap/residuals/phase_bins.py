"""At which phase of its cycle a frame is: what repeats shows below noise at the same phases."""

import numpy as np

from gap.residuals.parts import TrialPart
from model.values.arrays import FloatArray, IntArray

PHASE_BINS = 8


def phase_bins(part: TrialPart) -> IntArray:
    """Phase bin of each frame of a part, (F,); 0 throughout where there are no cycles."""
    cycle = part.observation.cycle
    known = np.isfinite(cycle).all()
    return binned(cycle if known else np.zeros(part.frames), PHASE_BINS)


def binned(cycle: FloatArray, bins: int) -> IntArray:
    """Return the bin of each phase of a cycle that is known all along, (F,)."""
    return np.minimum((np.mod(cycle, 1.0) * bins).astype(np.int64), bins - 1)
