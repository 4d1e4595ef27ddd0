"""Rates from samples: of the latest ones for a loop that cannot look ahead, and of those on both sides."""

import numpy as np

from model.compiled import COUNT, compile_for, compiled, given, in_place, out
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


def latest_rates(t_ns: IntArray, angle_rad: FloatArray, window: int) -> FloatArray:
    """What ``latest_rate`` says of every sample that has so many with itself, from the first such on.

    Args:
        t_ns: Sample times, (T,) int64, increasing.
        angle_rad: Angles, (T, N) [rad]; NaN where missing.
        window: Samples of a slope.

    Returns:
        (T - window + 1, N) [rad/s].
    """
    rates: FloatArray = np.empty((len(t_ns) - window + 1, angle_rad.shape[1]))
    compile_for(_latest_slopes, *given(1, kind=COUNT), *given(2), COUNT, *out(2))
    _latest_slopes(np.ascontiguousarray(t_ns), np.ascontiguousarray(angle_rad), window, rates)
    return rates


def centred_rate(t_ns: IntArray, values: FloatArray, half_ns: int) -> FloatArray:
    """Slope of the least-squares line through the samples on both sides of each one, where all are known.

    It is not late. Samples may lie unevenly; beside a hole and at the ends it leans to where samples are.

    Args:
        t_ns: Sample times, (T,) int64, increasing.
        values: (T, N); NaN where missing.
        half_ns: How far to look on each side.

    Returns:
        (T, N) [1/s]; NaN where the sample itself is missing, or is alone.
    """
    rate: FloatArray = np.empty(values.shape)
    _centred_slopes(np.ascontiguousarray(t_ns), np.ascontiguousarray(values), half_ns, rate)
    rate[~np.isfinite(values)] = np.nan
    return rate


@in_place
@compiled
def _centred_slopes(t_ns: IntArray, values: FloatArray, half_ns: int, rate: FloatArray) -> None:
    """Fill in the rates, (T, N)."""
    first, behind = 0, 0
    for i in range(len(t_ns)):
        while t_ns[first] < t_ns[i] - half_ns:
            first += 1
        while behind < len(t_ns) and t_ns[behind] <= t_ns[i] + half_ns:
            behind += 1
        _slopes(t_ns[first:behind], values[first:behind], rate[i])


@in_place
@compiled
def _latest_slopes(t_ns: IntArray, angle_rad: FloatArray, window: int, rates: FloatArray) -> None:
    """Fill in the rates, (T - window + 1, N)."""
    for i in range(len(rates)):
        _slopes(t_ns[i : i + window], angle_rad[i : i + window], rates[i])


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
