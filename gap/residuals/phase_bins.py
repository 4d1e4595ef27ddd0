"""At which phase of its cycle a frame is: what repeats shows below noise at the same phases."""

import numpy as np

from gap.residuals.parts import TrialPart
from model.values.arrays import IntArray

PHASE_BINS = 8


def phase_bins(part: TrialPart) -> IntArray:
    """Phase bin of each frame of a part, (F,); 0 throughout where there are no cycles."""
    cycle = part.observation.cycle
    known = np.isfinite(cycle).all()
    phase = np.mod(cycle, 1.0) if known else np.zeros(part.frames)
    return np.minimum((phase * PHASE_BINS).astype(np.int64), PHASE_BINS - 1)
