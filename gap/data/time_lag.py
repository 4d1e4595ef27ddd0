"""How late one stream is against another, by cross-correlation, and whether that grows with time."""

import numpy as np

from gap.interfaces import DataFault
from model.values.arrays import FloatArray
from record.trial.trial import Trial

PERIOD_S = 0.01
LONGEST_S = 1.5
# Delays up to here are effects of the catalogue; beyond, or when an answer comes first, clocks disagree.
LATEST_S = 0.35
EARLIEST_S = -0.06
SKEW_S = 0.12  # change of the lag from the first to the last third
SURE = 0.7  # correlation at the best lag


def lag(time_s: FloatArray, first: FloatArray, then: FloatArray) -> tuple[float, float]:
    """Time by which ``then`` comes after ``first``, and their correlation there.

    Args:
        time_s: Times of both, (T,).
        first: Any number of signals, (T, C).
        then: The same signals of the other stream, (T, C).

    Returns:
        Lag [s] and correlation; NaN where there is too little to compare.
    """
    grid = np.arange(time_s[0], time_s[-1], PERIOD_S)
    reach = min(round(LONGEST_S / PERIOD_S), len(grid) // 4)
    total = np.zeros(2 * reach + 1)
    power = 0.0
    for a, b in zip(first.T, then.T, strict=True):
        both = np.isfinite(a) & np.isfinite(b)
        if both.sum() < len(a) / 2 or reach < 5:
            continue
        x, y = (np.interp(grid, time_s[both], v[both]) for v in (a, b))
        x, y = (_rates(v) for v in (x, y))
        if x.std() == 0 or y.std() == 0:
            continue
        x, y = (x - x.mean()) / x.std(), (y - y.mean()) / y.std()
        middle = y[reach:-reach]
        # middle[i] = y[i + reach]; lag k compares it with x[i + reach - k]
        total += np.correlate(x, middle, "valid")[::-1]
        power += len(middle)
    if power == 0.0:
        return float("nan"), float("nan")
    total /= power
    best = int(np.argmax(total))
    offset = 0.0
    if 0 < best < len(total) - 1:
        left, here, right = total[best - 1 : best + 2]
        bend = left - 2 * here + right
        offset = 0.5 * (left - right) / bend if bend < 0 else 0.0
    return (best - reach + offset) * PERIOD_S, float(total[best])


def _rates(values: FloatArray) -> FloatArray:
    """Change over 0.1 s: a long ramp would hide the lag."""
    return values[10:] - values[:-10]


def stream_faults(
    time_s: FloatArray, first: FloatArray, then: FloatArray, channel: str, words: str
) -> tuple[DataFault, ...]:
    """Report a stream whose lag no effect explains, or whose lag grows.

    Args:
        time_s: Times, (T,).
        first: What it should follow, (T, C).
        then: The stream, (T, C).
        channel: How the stream is called.
        words: What it is compared with.
    """
    late, sure = lag(time_s, first, then)
    if not sure > SURE:
        return ()
    third = len(time_s) // 3
    ends = [
        lag(time_s[part], first[part], then[part])
        for part in (slice(0, third), slice(-third, None))
    ]
    if all(s > SURE for _, s in ends) and abs(ends[1][0] - ends[0][0]) > SKEW_S:
        rate = (ends[1][0] - ends[0][0]) / (time_s[-third] - time_s[0])
        evidence = f"its lag behind {words} goes from {ends[0][0]:.2f} to {ends[1][0]:.2f} s: "
        evidence += f"its clock is off by {100 * rate:.2f} %"
    elif late > LATEST_S or late < EARLIEST_S:
        where = f"{late:.2f} s behind" if late > 0 else f"{-late:.2f} s ahead of"
        evidence = f"is {where} {words} (correlation {sure:.2f}): its clock is set otherwise"
    else:
        return ()
    return (DataFault("clock_offset", channel, evidence, True),)


def lag_faults(trial: Trial) -> tuple[DataFault, ...]:
    """Compare shafts with commands, which any machine with joints has."""
    if not trial.joints or len(trial.time_s) < 100:
        return ()
    return stream_faults(trial.time_s, trial.command_rad, trial.shaft_rad, "shaft", "the commands")
