"""What columns of measured numbers show by themselves: runs, lone samples, likeness, units."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy.ndimage import median_filter

from gap.interfaces import DataFault
from model.values.arrays import BoolArray, FloatArray, IntArray

LONGEST_SPIKE = 3
FEWEST = 20  # samples from which two columns are compared
Unit = tuple[float, str]  # how many of it are one SI unit, and its name
# Kind of a fault, its evidence, whether it is severe, and which share of the samples it concerns.
Sign = tuple[str, str, bool] | tuple[str, str, bool, float]


def faults_of(channel: str, signs: Iterable[Sign]) -> Iterator[DataFault]:
    """Return what was found in a channel as its faults."""
    return (DataFault(sign[0], channel, *sign[1:]) for sign in signs)


def runs(flags: BoolArray) -> IntArray:
    """Return begin and end (behind the last) of each run of True, (R, 2)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return edges.reshape(-1, 2)


def standing_out(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return values without lone samples, and how far each stands out from them, (T,) both."""
    smooth = median_filter(values, 2 * LONGEST_SPIKE + 1, mode="nearest")
    return smooth, np.abs(values - smooth)


def spread_of(values: FloatArray) -> float:
    """Return the standard deviation of most values about 0, whatever a few of them are."""
    return 1.4826 * float(np.median(np.abs(values)))


def likeness(first: FloatArray, then: FloatArray, *, clipped: bool = False) -> FloatArray:
    """Return the correlation of each column with each of the other's, (N, M); NaN for too few samples.

    Args:
        first: (T, N); NaN where nothing was measured.
        then: (T, M).
        clipped: Whether the outermost hundredths count as the rest: jumps are faults of their own.
    """
    out = np.full((first.shape[1], then.shape[1]), np.nan)
    for j, a in enumerate(first.T):
        for k, b in enumerate(then.T):
            x, y = paired(a, b, clipped=clipped)
            if len(x) >= FEWEST and np.ptp(x) > 0 and np.ptp(y) > 0:
                out[j, k] = np.corrcoef(x, y)[0, 1]
    return out


def paired(a: FloatArray, b: FloatArray, *, clipped: bool = False) -> tuple[FloatArray, FloatArray]:
    """Return two columns where both are known; ``clipped`` as in ``likeness``."""
    both = np.isfinite(a) & np.isfinite(b)
    x, y = a[both], b[both]
    if clipped and len(x) >= FEWEST:
        x, y = (np.clip(v, *np.percentile(v, [1, 99])) for v in (x, y))
    return x, y


def slope(x: FloatArray, y: FloatArray) -> float:
    """Return the slope of a straight line through points."""
    x, y = x - x.mean(), y - y.mean()
    return float(x @ y / (x @ x))


def exchanged(alike: FloatArray, others: float, own: float) -> Iterator[tuple[int, int]]:
    """Return pairs of columns that are like the other's and not like their own.

    Args:
        alike: Likeness of each column to each, (N, N).
        others: Likeness to the other's that both exceed.
        own: Likeness to their own that neither exceeds.
    """
    for j in range(len(alike)):
        for k in range(j + 1, len(alike)):
            if min(alike[j, k], alike[k, j]) > others and max(alike[j, j], alike[k, k]) < own:
                yield j, k


def unit_of(ratio: float, units: Sequence[Unit], close: float) -> str | None:
    """Return the unit in which a quantity is ``ratio`` times what it should be; None for none of them."""
    return next((name for factor, name in units if abs(ratio / factor - 1) < close), None)
