"""Rates from sampled angles, for a loop that cannot look ahead."""

from math import isfinite

import numpy as np

from model.signals import FloatArray, IntArray


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
    if isfinite(angle_rad.sum()):
        return _whole_window(t_ns.tolist(), angle_rad)
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
    rate: FloatArray = np.where((count >= 2) & (spread > 0), slope, np.nan)
    return rate


def _whole_window(t_ns: list[int], angle_rad: FloatArray) -> FloatArray:
    """The same, bit for bit, where nothing is missing: the times' part is the same for all legs."""
    times = [(t - t_ns[-1]) * 1e-9 for t in t_ns]
    mean, spread = 0.0, 0.0
    for t in times:
        mean += t
    mean /= len(times)
    times = [t - mean for t in times]
    for t in times:
        spread += t * t
    if len(times) < 2 or spread <= 0:
        return np.full(angle_rad.shape[1], np.nan)
    offset = angle_rad - angle_rad.sum(axis=0) / len(times)
    slope: FloatArray = (np.array(times)[:, None] * offset).sum(axis=0) / spread
    return slope
