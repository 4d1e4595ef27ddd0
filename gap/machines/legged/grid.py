"""The legged simulator's grids and filters, the same for what was measured and what is predicted.

Signals are put on an even working grid (50 a second, or the trial's rate if that is less); velocities
are the slope of a Savitzky-Golay filter there; channels are averaged down to half the rate, (1, 2, 1) /
4.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.ndimage import convolve1d
from scipy.signal import savgol_coeffs

from model.errors import GapError
from model.values.arrays import FloatArray, readonly

WORKING_HZ = 50.0
TWIST_WINDOW_S = 0.25  # the paper's: order 2, 25 samples at 100 Hz
FOOT_WINDOW_S = 0.13  # short, so that the body's velocity is not smoothed twice
ORDER = 2
LONGEST_HOLE_S = 0.06  # a shorter one is bridged
SHORTEST_TRIAL_S = 1.0
DOWN = np.array([0.25, 0.5, 0.25])


@dataclass(frozen=True)
class Grid:
    """The working grid of a trial.

    Attributes:
        start_s: Time of the first frame.
        period_s: Between frames.
        frames: Their number, W; channels have every second one, F.
        source_period_s: Median period of the trial's own samples.
    """

    start_s: float
    period_s: float
    frames: int
    source_period_s: float

    @cached_property
    def time_s(self) -> FloatArray:
        """(W,), since the start."""
        time: FloatArray = np.arange(self.frames, dtype=np.float64) * self.period_s
        return time

    def window(self, seconds: float) -> int:
        """Odd number of frames that is nearest to a time, at least one more than the order."""
        return max(2 * round((seconds / self.period_s - 1) / 2) + 1, ORDER + 1 + ORDER % 2)

    def slope(self, values: FloatArray, seconds: float) -> FloatArray:
        """Derivative in time along the first axis, Savitzky-Golay."""
        window = self.window(seconds)
        kernel = _slope_kernel(window, self.period_s)
        half = window // 2
        # mirrored through the end points, so that a straight line keeps its slope to the edge
        head = 2 * values[:1] - values[half:0:-1]
        tail = 2 * values[-1:] - values[-2 : -half - 2 : -1]
        wide = np.concatenate([head, values, tail])
        slope: FloatArray = convolve1d(wide, kernel, axis=0, mode="nearest")[half:-half]
        return slope

    @property
    def is_moment(self) -> bool:
        """Whether it is too short for what needs a memory, such as an acceleration."""
        return self.frames <= self.window(TWIST_WINDOW_S)

    def slope_noise(self, seconds: float) -> float:
        """Standard deviation of ``slope`` followed by ``down`` for white noise of 1."""
        kernel = savgol_coeffs(self.window(seconds), ORDER, deriv=1, delta=self.period_s)
        return float(np.linalg.norm(np.convolve(kernel, DOWN)))


@lru_cache(maxsize=32)
def _slope_kernel(window: int, period_s: float) -> FloatArray:
    kernel = savgol_coeffs(window, ORDER, deriv=1, delta=period_s, use="conv")
    return readonly(np.asarray(kernel, dtype=np.float64))


def down(values: FloatArray) -> FloatArray:
    """Average from the working grid to that of the channels, (W, ...) to (F, ...)."""
    averaged: FloatArray = convolve1d(values, DOWN, axis=0, mode="nearest")[::2]
    return averaged


def body_velocity(grid: Grid, pose: FloatArray) -> FloatArray:
    """Velocity in body axes, vx, vy, yaw rate, of a pose x, y, yaw in the world, both (W, 3)."""
    rate = grid.slope(pose, TWIST_WINDOW_S)
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    forward, left = c * rate[:, 0] + s * rate[:, 1], c * rate[:, 1] - s * rate[:, 0]
    return np.column_stack([forward, left, rate[:, 2]])


def make_grid(time_s: FloatArray) -> Grid:
    """Lay the grid over a trial.

    Raises:
        GapError: The trial is too short.
    """
    if len(time_s) < 2 or time_s[-1] - time_s[0] < SHORTEST_TRIAL_S:
        raise GapError(f"the trial is shorter than {SHORTEST_TRIAL_S:g} s; record longer ones")
    source = float(np.median(np.diff(time_s)))
    period = max(1.0 / WORKING_HZ, source)
    frames = int(np.floor((time_s[-1] - time_s[0]) / period + 1e-6)) + 1
    return Grid(float(time_s[0]), period, frames, source)


def place(grid: Grid, time_s: FloatArray, values: FloatArray, later_s: float = 0.0) -> FloatArray:
    """Put samples on the grid: linear between samples, averaged where there are more than frames.

    Args:
        grid: The grid.
        time_s: Times of the samples, (T,).
        values: (T, ...); NaN where missing. Holes up to ``LONGEST_HOLE_S`` are bridged.
        later_s: Delay: a frame at t gets what the samples say of t - later_s.
    """
    flat = _bridged(time_s, values.reshape(len(values), -1))
    at = grid.start_s + grid.time_s - later_s
    if grid.period_s > 1.5 * grid.source_period_s:
        half = grid.period_s / 2
        out = DOWN[0] * (_between(time_s, flat, at - half) + _between(time_s, flat, at + half))
        out += DOWN[1] * _between(time_s, flat, at)
    else:
        out = _between(time_s, flat, at)
    placed: FloatArray = out.reshape(grid.frames, *values.shape[1:])
    return placed


def placed_noise(grid: Grid) -> float:
    """Standard deviation after ``place`` and ``down`` for white noise of 1 in the samples."""
    if grid.period_s <= 1.5 * grid.source_period_s:
        return float(np.linalg.norm(DOWN))
    fine = round(grid.period_s / grid.source_period_s)
    wide = np.zeros(4 * fine + 1)
    for share, shift in zip(DOWN, (-fine, 0, fine), strict=True):
        for inner, offset in zip(DOWN, (-(fine // 2), 0, fine // 2), strict=True):
            wide[2 * fine + shift + offset] += share * inner
    return float(np.linalg.norm(wide))


def shifted(grid: Grid, values: FloatArray, time_s: FloatArray) -> FloatArray:
    """What a signal on the grid was at other times, (W,) since the start, held beyond its ends."""
    flat = values.reshape(grid.frames, -1)
    moved: FloatArray = _between(grid.time_s, flat, time_s).reshape(values.shape)
    return moved


def lagged(grid: Grid, values: FloatArray, time_constant_s: float) -> FloatArray:
    """First-order low pass, exact for what is linear between frames; begins in a steady ramp."""
    from scipy.signal import lfilter

    a = np.exp(-grid.period_s / time_constant_s)
    r = time_constant_s / grid.period_s
    b0, b1 = 1 - r * (1 - a), r * (1 - a) - a
    ramp = (values[1] - values[0]) * r
    first = values[:1] - ramp[None]
    # state so that the first output is the ramp's
    state = first - b0 * values[:1]
    out, _ = lfilter([b0, b1], [1.0, -a], values, axis=0, zi=state)
    filtered: FloatArray = out
    return filtered


def _between(time_s: FloatArray, flat: FloatArray, at: FloatArray) -> FloatArray:
    right = np.clip(np.searchsorted(time_s, at, side="right"), 1, len(time_s) - 1)
    left = right - 1
    share = np.clip((at - time_s[left]) / (time_s[right] - time_s[left]), 0.0, 1.0)[:, None]
    low, high = flat[left], flat[right]
    # a sample hit exactly needs no neighbour
    out: FloatArray = np.where(
        share == 0.0, low, np.where(share == 1.0, high, low + share * (high - low))
    )
    return out


def _bridged(time_s: FloatArray, flat: FloatArray) -> FloatArray:
    missing = ~np.isfinite(flat)
    if not missing.any():
        return flat
    out = flat.copy()
    for column in np.flatnonzero(missing.any(axis=0) & ~missing.all(axis=0)):
        known = np.flatnonzero(~missing[:, column])
        gone = np.flatnonzero(missing[:, column])
        after = np.searchsorted(known, gone)
        inner = (after > 0) & (after < len(known))
        gone, after = gone[inner], after[inner]
        short = time_s[known[after]] - time_s[known[after - 1]] <= LONGEST_HOLE_S
        gone = gone[short]
        out[gone, column] = np.interp(time_s[gone], time_s[known], flat[known, column])
    return out
