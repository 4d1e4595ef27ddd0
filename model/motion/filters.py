"""Filters of sampled signals: a first-order low pass, play between two flanks, a look at other times."""

import numpy as np

from model.compiled import compiled, in_place
from model.values.arrays import FloatArray, given_rows


def lagged(
    values: FloatArray, time_constant_s: float, period_s: float, *, ramping: bool = False
) -> FloatArray:
    """First-order low pass along the first axis, exact for what is linear between samples.

    Args:
        values: (F, ...).
        time_constant_s: Time constant; 0 is no filter.
        period_s: Between samples.
        ramping: Whether it begins in a steady ramp along the first two samples, not at rest.
    """
    out = values.reshape(len(values), -1).copy()
    if time_constant_s > 0:
        keep = float(np.exp(-period_s / time_constant_s))
        steps = time_constant_s / period_s
        start = out[0] - steps * (out[1] - out[0]) if ramping else out[0].copy()
        recursion(out, start, keep, 1.0 - steps * (1.0 - keep), steps * (1.0 - keep) - keep)
    return out.reshape(values.shape)


@in_place
@compiled
def recursion(
    values: FloatArray, start: FloatArray, keep: float, newest: float, before: float
) -> None:
    """Filter in place: y[n] = keep y[n-1] + newest x[n] + before x[n-1], with y[0] given.

    Args:
        values: x, then y, (F, C).
        start: y[0], (C,).
        keep: Share of the answer before.
        newest: Share of the newest value.
        before: Share of the value before.
    """
    for k in range(values.shape[1]):
        last = values[0, k]
        values[0, k] = start[k]
        for i in range(1, len(values)):
            now = values[i, k]
            values[i, k] = newest * now + (before * last + keep * values[i - 1, k])
            last = now


@compiled
def play(values: FloatArray, width: float, start: float) -> FloatArray:
    """Where something lies that a driver drags along with play, (F,).

    Args:
        values: Where the driver is, (F,).
        width: Full width of the play.
        start: Where the dragged side lies at first; outside its play it is at the nearer end.
    """
    out = np.empty_like(values)
    at = start
    for i in range(len(values)):
        at = min(max(at, values[i] - 0.5 * width), values[i] + 0.5 * width)
        out[i] = at
    return out


def at_times(time_s: FloatArray, values: FloatArray, at_s: FloatArray) -> FloatArray:
    """What a signal was at other times: linear between samples, held beyond its ends.

    Args:
        time_s: Times of the samples, (F,), increasing.
        values: (F, ...); a NaN affects only its neighbours in time, not a time that hits its neighbour.
        at_s: Times in question, (T,).

    Returns:
        (T, ...).
    """
    out = np.empty((len(at_s), *values.shape[1:]))
    flat = given_rows(values.reshape(len(values), -1))
    _between(given_rows(time_s), flat, given_rows(at_s), out.reshape(len(at_s), -1))
    return out


@in_place
@compiled
def _between(time_s: FloatArray, values: FloatArray, at_s: FloatArray, out: FloatArray) -> None:
    """Fill ``out``, (T, C), with (F, C) values at times that may come in any order."""
    right, last = 1, len(time_s) - 1
    for i in range(len(at_s)):
        at = at_s[i]
        if at < time_s[right - 1]:
            right = 1
        while right < last and time_s[right] <= at:
            right += 1
        left = right - 1
        share = (at - time_s[left]) / (time_s[right] - time_s[left])
        share = min(max(share, 0.0), 1.0) if share == share else share
        for k in range(values.shape[1]):
            low, high = values[left, k], values[right, k]
            if share == 0.0:
                out[i, k] = low
            elif share == 1.0:
                out[i, k] = high
            else:
                out[i, k] = low + share * (high - low)
