"""Rates from sampled angles, for a loop that cannot look ahead."""

import numpy as np

from model.compiled import COUNT, compile_for, compiled, given, out
from model.values.arrays import FloatArray, IntArray


def latest_rate(t_ns: IntArray, angle_rad: FloatArray) -> FloatArray:
    """Slope of the least-squares line through the latest samples of each angle.

    An encoder count (1.53 mrad) over one 10 ms period is 0.15 rad/s, half a stance speed; the slope
    of a line through a dozen samples is good to a few mrad/s and late by half their span.

    Args:
        t_ns: Sample times, (W,) int64, increasing.
        angle_rad: Angles, (W, N) [rad]; NaN where missing.

    Returns:
        (N,) [rad/s]; NaN where fewer than two samples are there.
    """
    rate: FloatArray = np.empty(angle_rad.shape[1])
    _slopes(np.ascontiguousarray(t_ns), np.ascontiguousarray(angle_rad), rate)
    return rate


@compiled
def _slopes(t_ns: IntArray, angle_rad: FloatArray, rate: FloatArray) -> None:
    """Fill in the rates, (N,)."""
    window, legs = angle_rad.shape
    times = np.empty(window)
    for i in range(window):
        times[i] = (t_ns[i] - t_ns[window - 1]) * 1e-9
    for k in range(legs):
        count, time, angle = 0, 0.0, 0.0
        for i in range(window):
            if np.isfinite(angle_rad[i, k]):
                count += 1
                time += times[i]
                angle += angle_rad[i, k]
        time /= max(count, 1)
        angle /= max(count, 1)
        slope, spread = 0.0, 0.0
        for i in range(window):
            if np.isfinite(angle_rad[i, k]):
                spread += (times[i] - time) ** 2
                slope += (times[i] - time) * (angle_rad[i, k] - angle)
        rate[k] = slope / spread if count > 1 and spread > 0.0 else np.nan


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(_slopes, *given(1, kind=COUNT), *given(2), *out(1))
