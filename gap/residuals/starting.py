"""How much noisier a machine is as it starts to move than later, as references show it.

Servos that break loose from rest and feet that begin to slip do it each time in another way. That lasts for
a moment, but it is several times what walking leaves. Taken for noise of the whole run, it would hide what
the rest of the run shows.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.constants import NOISIER
from gap.interfaces import Channel
from gap.residuals.parts import TrialPart
from model.values.arrays import FloatArray, IntArray

EDGES_S = (0.25, 0.5, 1.0)  # from the first frame that counts; after the last one it walks
FEWEST_FRAMES = 8  # of a channel, in all runs together, that tell its noise in a window


@dataclass(frozen=True, slots=True, eq=False)
class Starting:
    """Noise of the windows between ``EDGES_S`` in units of that of walking, (W, C), at least 1."""

    factor: FloatArray

    def at(self, part: TrialPart) -> FloatArray:
        """Return the factor of each frame and channel, (F, C)."""
        every = np.vstack([self.factor, np.ones(self.factor.shape[1])])
        return np.asarray(every[_windows(part)])


def noise_of_frames(starting: Starting | None, part: TrialPart) -> FloatArray:
    """Return the noise of each frame in units of that of walking, (F, C); (1, 1) where all are alike."""
    return np.ones((1, 1)) if starting is None else starting.at(part)


def starting_noise(
    channels: Sequence[Channel], parts: Sequence[TrialPart], left: Sequence[FloatArray]
) -> Starting:
    """Measure it.

    Args:
        channels: C of them; those of one name count together.
        parts: Healthy runs.
        left: What is left of each without all that repeats with the phase, (F, C); NaN where unused.
    """
    windows = np.concatenate([_windows(part) for part in parts])
    squares = np.concatenate(left) ** 2
    factor = np.ones((len(EDGES_S), len(channels)))
    names = np.array([channel.name for channel in channels])
    for channel in {one.name: one for one in channels if not one.lasting}.values():
        own = names == channel.name
        walking = _mean(squares[windows == len(EDGES_S)][:, own])
        for window in range(len(EDGES_S)):
            ratio = _mean(squares[windows == window][:, own]) / walking if walking > 0.0 else 1.0
            if ratio >= NOISIER**2:  # and so not NaN
                factor[window, own] = np.sqrt(ratio)
    return Starting(factor)


def _mean(squares: FloatArray) -> float:
    """Mean of what is known; NaN of too little."""
    known = np.isfinite(squares)
    return float(squares[known].mean()) if known.sum() >= FEWEST_FRAMES else float("nan")


def _windows(part: TrialPart) -> IntArray:
    """Window of each frame, (F,): that of walking for a part that does not begin with its run."""
    since_s = part.observation.time_s - part.observation.time_s[0]
    counts = (part.observation.weight > 0.0).any(axis=1)
    if part.first > 0 or not counts.any():
        return np.full(part.frames, len(EDGES_S))
    since_s = since_s - since_s[counts.argmax()]
    return np.asarray(np.searchsorted(EDGES_S, since_s, side="right"))
