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
    if _whole_window(np.ascontiguousarray(t_ns), np.ascontiguousarray(angle_rad), rate):
        return rate
    t = (t_ns - t_ns[-1]) * 1e-9  # [s]
    present = np.isfinite(angle_rad)
    weight = present.astype(np.float64)
    count = weight.sum(axis=0)
    angle = np.where(present, angle_rad, 0.0)
    safe = np.maximum(count, 1.0)
    t_mean = (weight * t[:, None]).sum(axis=0) / safe
    angle_mean = angle.sum(axis=0) / safe
    t_centred = weight * (t[:, None] - t_mean)
    spread = (t_centred**2).sum(axis=0)  # [s^2]
    slope = (t_centred * (angle - angle_mean)).sum(axis=0) / np.where(spread > 0, spread, 1.0)
    rate[:] = np.where((count >= 2) & (spread > 0), slope, np.nan)
    return rate


@compiled
def _whole_window(t_ns: IntArray, angle_rad: FloatArray, rate: FloatArray) -> bool:
    """The same, bit for bit, where nothing is missing; False if something is.

    Args:
        t_ns: (W,).
        angle_rad: (W, N).
        rate: Out: (N,).
    """
    window, count = angle_rad.shape
    times = np.empty(window)
    mean, spread = 0.0, 0.0
    for i in range(window):
        times[i] = (t_ns[i] - t_ns[window - 1]) * 1e-9
        mean += times[i]
    mean /= window
    for i in range(window):
        times[i] -= mean
        spread += times[i] * times[i]
    for k in range(count):
        total, slope = 0.0, 0.0
        for i in range(window):
            total += angle_rad[i, k]
        middle = total / window
        for i in range(window):
            slope += times[i] * (angle_rad[i, k] - middle)
        if not np.isfinite(total):
            return False
        rate[k] = slope / spread if window > 1 and spread > 0.0 else np.nan
    return True


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(_whole_window, *given(1, kind=COUNT), *given(2), *out(1))
