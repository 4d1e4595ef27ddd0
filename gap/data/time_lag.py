"""How late one stream is against another, by cross-correlation, and whether that grows with time."""

from collections.abc import Sequence

import numpy as np

from gap.interfaces import DataFault
from model.values.arrays import FloatArray
from record.trial.lagged_correlation import UNKNOWN, Lag, best_lag, likeness_at
from record.trial.trial import Trial

PERIOD_S = 0.01
RATE_STEPS = 10
LONGEST_S = 1.5
# Delays up to here are effects of the catalogue; beyond, or when an answer comes first, clocks disagree.
LATEST_S = 0.35
EARLIEST_S = -0.06
ALLOWED_S = tuple(np.arange(EARLIEST_S, LATEST_S, 0.02).tolist())  # between them
# change of the lag from the first to the last third; in 340 streams of the 19 realities (labels open) whose
# clocks agree, none that is as sure moves by more than 0.065 s
SKEW_S = 0.08
SURE = 0.7  # correlation at the best lag
SIGMAS = 3.0  # a lag must be beyond its limit by so many standard deviations
CLEARLY_LESS = 0.9  # share of what another lag leaves unexplained
OVERLAP = 0.5
FEWEST_STEPS = 2


def lag(time_s: FloatArray, first: FloatArray, then: FloatArray) -> Lag:
    """Time by which ``then`` comes after ``first``, how well that is known, and how alike they are there.

    Args:
        time_s: Times of both, (T,).
        first: Any number of signals, (T, C).
        then: The same signals of the other stream, (T, C).
    """
    pair = _paired(time_s, first, then)
    if pair is None:
        return UNKNOWN
    reach_s = min(LONGEST_S, (len(pair[0]) + RATE_STEPS) // 4 * PERIOD_S)
    return best_lag(*pair, PERIOD_S, reach_s, OVERLAP)


def _paired(
    time_s: FloatArray, first: FloatArray, then: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Rates of the signals that both streams have, on one grid; None for none."""
    grid = np.arange(time_s[0], time_s[-1], PERIOD_S)
    pairs = []
    for a, b in zip(first.T, then.T, strict=True):
        both = np.isfinite(a) & np.isfinite(b)
        if both.sum() >= len(a) / 2 and len(grid) > 10 * FEWEST_STEPS:
            pairs.append([_rates(np.interp(grid, time_s[both], v[both])) for v in (a, b)])
    if not pairs:
        return None
    x, y = (np.column_stack(side) for side in zip(*pairs, strict=True))
    return x, y


def _clearly(
    time_s: FloatArray, first: FloatArray, then: FloatArray, best: Lag, others_s: Sequence[float]
) -> bool:
    """Whether the best lag leaves clearly less unexplained than each of some others.

    Where the likeness hardly changes with the lag, as that of legs that ring, its peak says little.
    """
    pair = _paired(time_s, first, then)
    if pair is None:
        return False
    alike = [likeness_at(*pair, round(other / PERIOD_S)) for other in others_s]
    return 1.0 - best.correlation**2 < CLEARLY_LESS * (1.0 - max(0.0, *alike) ** 2)


def _rates(values: FloatArray) -> FloatArray:
    """Change over 0.1 s: a long ramp would hide the lag."""
    return values[RATE_STEPS:] - values[:-RATE_STEPS]


def stream_faults(
    time_s: FloatArray,
    first: FloatArray,
    then: FloatArray,
    channel: str,
    words: str,
    known: Lag | None = None,
) -> tuple[DataFault, ...]:
    """Report a stream whose lag no effect explains, or whose lag grows.

    Args:
        time_s: Times, (T,).
        first: What it should follow, (T, C).
        then: The stream, (T, C).
        channel: How the stream is called.
        words: What it is compared with.
        known: Its lag over the whole time; None works it out.
    """
    third = len(time_s) // 3
    early, last = slice(0, third), slice(-third, None)
    begin, end = (lag(time_s[part], first[part], then[part]) for part in (early, last))
    whole = known or lag(time_s, first, then)
    moved, sd_s = end.seconds - begin.seconds, float(np.hypot(begin.sd_s, end.sd_s))
    late, unsure_s = whole.seconds, SIGMAS * whole.sd_s
    if (
        min(begin.correlation, end.correlation) > SURE
        and abs(moved) > max(SKEW_S, SIGMAS * sd_s)
        and _clearly(time_s[last], first[last], then[last], end, [begin.seconds])
    ):
        rate = moved / (time_s[-third] - time_s[0])
        evidence = f"its lag behind {words} goes from {begin.seconds:.2f} to {end.seconds:.2f} s "
        evidence += f"(+- {sd_s:.2f}): its clock is off by {100 * rate:.2f} %"
    elif (
        whole.correlation > SURE
        and not EARLIEST_S - unsure_s <= late <= LATEST_S + unsure_s
        and _clearly(time_s, first, then, whole, ALLOWED_S)
    ):
        where = f"{late:.2f} s behind" if late > 0 else f"{-late:.2f} s ahead of"
        evidence = f"is {where} {words} (+- {whole.sd_s:.2f} s, correlation "
        evidence += f"{whole.correlation:.2f}): its clock has an offset"
    else:
        return ()
    return (DataFault("clock_offset", channel, evidence, True),)


def lag_faults(trial: Trial) -> tuple[DataFault, ...]:
    """Compare shafts with commands, which any machine with joints has."""
    if not trial.joints or len(trial.time_s) < 100:
        return ()
    return stream_faults(trial.time_s, trial.command_rad, trial.shaft_rad, "shaft", "the commands")
