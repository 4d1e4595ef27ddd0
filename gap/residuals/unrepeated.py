"""What a run leaves that is another in each cycle of its gait.

What a simulator has wrong, and what a constant cause changes, comes back in each cycle. Gusts, missed steps
and contacts that come loose now and then do not. Healthy runs hardly differ in it, however much they differ
from day to day in what repeats.
"""

import numpy as np

from gap.residuals.parts import TrialPart
from gap.residuals.phase_bins import binned
from model.values.arrays import FloatArray, IntArray

PHASES = 32  # of a cycle
FEWEST_FRAMES = 0.5  # of the usual number in a phase, from which its mean counts


def unrepeated(part: TrialPart, residual: FloatArray) -> FloatArray:
    """Return the variance, between cycles, of the mean at a phase, in the mean of all phases, (C,).

    NaN where no phase was measured in two cycles.

    Args:
        part: A run, or the beginning of one.
        residual: What is left of its first F frames, whitened, (F, C); 0 or NaN where it does not count.
    """
    frames, channels = residual.shape
    cycle = part.observation.cycle[:frames]
    if not np.isfinite(cycle).all():
        return np.full(channels, np.nan)
    number = np.floor(cycle).astype(np.int64)
    number -= number.min()
    place, shape = number * PHASES + binned(cycle, PHASES), (int(number.max()) + 1, PHASES)
    return np.array([_between_cycles(place, shape, own) for own in residual.T])


def _between_cycles(place: IntArray, shape: tuple[int, int], values: FloatArray) -> float:
    """The variance of one channel; ``place`` numbers the cycle and phase of each frame."""
    known = np.isfinite(values) & (values != 0.0)
    size = shape[0] * shape[1]
    frames = np.bincount(place[known], minlength=size).reshape(shape)
    if not frames.any():
        return np.nan
    sums = np.bincount(place[known], values[known], size).reshape(shape)
    counts = frames >= FEWEST_FRAMES * np.median(frames[frames > 0])
    means = np.where(counts, sums / np.fmax(frames, 1), np.nan)
    free = int(np.fmax(counts.sum(axis=0) - 1, 0).sum())
    if not free:
        return np.nan
    means = means[:, counts.sum(axis=0) > 1]
    return float(np.nansum((means - np.nanmean(means, axis=0)) ** 2)) / free
