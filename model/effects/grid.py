"""The chain's grids, the same for what was measured and what is predicted, and the slope of signals there.

Signals are put on an even working grid (50 a second, or the trial's rate if that is less); velocities
are the slope of a Savitzky-Golay filter there; channels are averaged down to half the rate, (1, 2, 1) /
4.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from model.compiled import compiled
from model.errors import GapError
from model.motion.filters import at_times
from model.motion.se2 import turned
from model.values.arrays import FloatArray, given_rows

WORKING_HZ = 50.0
TWIST_WINDOW_S = 0.25  # the paper's: order 2, 25 samples at 100 Hz
FOOT_WINDOW_S = 0.13  # short, so that the body's velocity is not smoothed twice
ORDER = 2
GIVEN_BACK = 2  # times
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
        """Derivative in time along the first axis: of a parabola through each window (Savitzky-Golay).

        Raises:
            GapError: There are too few frames.
        """
        half = self.window(seconds) // 2
        if len(values) <= half:
            raise GapError(f"{len(values)} frames are too few for a slope over {seconds:g} s")
        slope = np.empty(values.shape)
        flat = given_rows(values).reshape(len(values), -1)
        _slopes(flat, half, self._lever(half), slope.reshape(flat.shape))
        return slope

    def given_back(self, slope: FloatArray, seconds: float, windows: int) -> FloatArray:
        """Return a slope with most of what so many windows in a row took from it, (W, K).

        A slope over a window is the derivative, smoothed: at half the window's rate a quarter is missing.
        What smoothing takes once more from what it left is added, twice (twicing, Tukey 1977, Exploratory
        Data Analysis, chapter 16): of 0.6 this makes 0.94. What is missing altogether does not come back.
        """
        kernel, half = self._smoothing(seconds), self.window(seconds) // 2
        back = slope
        for _ in range(GIVEN_BACK):
            smooth = back
            for _ in range(windows):
                wide = np.pad(smooth, ((half, half), (0, 0)), mode="edge")
                columns = [np.convolve(column, kernel, "valid") for column in wide.T]
                smooth = np.stack(columns, axis=1)
            back = slope + (back - smooth)
        return back

    def _smoothing(self, seconds: float) -> FloatArray:
        """Weights of the derivatives, frame by frame, in a slope over a window."""
        half = self.window(seconds) // 2
        numbers = np.arange(half + 1)
        # of the step from one frame to the next, and half of it for each of the two
        steps = half * (half + 1) - numbers[:-1] * numbers[1:]
        side = np.append(steps, 0.0) + np.append(steps[0], steps)
        kernel = np.concatenate([side[:0:-1], side])
        return np.asarray(kernel / kernel.sum())

    @property
    def is_moment(self) -> bool:
        """Whether it is too short for what needs a memory, such as an acceleration."""
        return self.frames <= self.window(TWIST_WINDOW_S)

    def slope_noise(self, seconds: float) -> float:
        """Standard deviation of ``slope`` followed by ``DOWN`` for white noise of 1."""
        half = self.window(seconds) // 2
        kernel = np.arange(-half, half + 1) / self._lever(half)
        return float(np.linalg.norm(np.convolve(kernel, DOWN)))

    def _lever(self, half: int) -> float:
        """Sum of what moves frames and times in a window have in common [s]."""
        return half * (half + 1) * (2 * half + 1) / 3 * self.period_s


@compiled
def _slopes(values: FloatArray, half: int, lever: float, out: FloatArray) -> None:
    """Slopes of columns, (W, K); unknown where the value itself is."""
    frames, columns = values.shape
    for f in range(frames):
        for c in range(columns):
            out[f, c] = 0.0 * values[f, c]
            for k in range(1, half + 1):
                # mirrored through the end points, so that a straight line keeps its slope to the edge
                if f + k < frames:
                    later = values[f + k, c]
                else:
                    later = 2 * values[frames - 1, c] - values[2 * frames - 2 - f - k, c]
                earlier = values[f - k, c] if f >= k else 2 * values[0, c] - values[k - f, c]
                out[f, c] += k * (later - earlier)
            out[f, c] /= lever


def body_velocity(grid: Grid, pose: FloatArray) -> FloatArray:
    """Velocity in body axes, vx, vy, yaw rate, of a pose x, y, yaw in the world, both (W, 3)."""
    rate = grid.slope(pose, TWIST_WINDOW_S)
    return np.column_stack([*turned(rate[:, 0], rate[:, 1], -pose[:, 2]), rate[:, 2]])


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
    out = at_times(time_s, flat, at)
    if grid.period_s > 1.5 * grid.source_period_s:
        half = grid.period_s / 2
        beside = at_times(time_s, flat, at - half) + at_times(time_s, flat, at + half)
        out = DOWN[0] * beside + DOWN[1] * out
    placed: FloatArray = out.reshape(grid.frames, *values.shape[1:])
    return placed


def placed_noise(grid: Grid) -> float:
    """Standard deviation after ``place`` and ``DOWN`` for white noise of 1 in the samples."""
    if grid.period_s <= 1.5 * grid.source_period_s:
        return float(np.linalg.norm(DOWN))
    fine = round(grid.period_s / grid.source_period_s)
    wide = np.zeros(4 * fine + 1)
    for share, shift in zip(DOWN, (-fine, 0, fine), strict=True):
        for inner, offset in zip(DOWN, (-(fine // 2), 0, fine // 2), strict=True):
            wide[2 * fine + shift + offset] += share * inner
    return float(np.linalg.norm(wide))


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
