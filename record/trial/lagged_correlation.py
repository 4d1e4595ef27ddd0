"""How late one signal is against another: correlation at every lag, the best one, and how sure that is."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import FloatArray, IntArray

FEWEST = 10  # samples that must overlap


class Lag(NamedTuple):
    """Where two signals agree best; NaN throughout where there is too little to compare.

    Attributes:
        seconds: Time by which the second comes after the first.
        sd_s: Standard deviation of it, from what the best lag leaves unexplained.
        correlation: At the best lag, -1 to 1.
        rival_s: The best lag outside of the same peak; NaN if there is no other peak.
        rival_correlation: The correlation there.
        sigmas: By how many standard deviations the best lag is better than the second best, as Fisher's z
            of the two correlations; infinite without a second one.
    """

    seconds: float
    sd_s: float
    correlation: float
    rival_s: float
    rival_correlation: float
    sigmas: float


UNKNOWN = Lag(*(float("nan"),) * 6)


def best_lag(
    first: FloatArray, then: FloatArray, period_s: float, longest_s: float, overlap: float
) -> Lag:
    """Return the lag at which two signals on even grids of the same start and period agree best.

    The correlation of a lag is that of the samples that overlap there, each with the mean and size that
    it has there (J. P. Lewis, Fast Normalized Cross-Correlation, 1995), so a loud stretch does not draw
    the peak towards itself. Columns count alike.

    Args:
        first: Samples, (T, C); NaN where unknown.
        then: The same quantities of the other signal, (U, C).
        period_s: Between samples.
        longest_s: No lag beyond this, either way.
        overlap: Share of the shorter signal's known samples that must overlap.
    """
    x, y = _scaled(first), _scaled(then)
    known = np.isfinite(x).any(axis=0) & np.isfinite(y).any(axis=0)
    x, y = x[:, known], y[:, known]
    if x.shape[1] == 0 or min(len(x), len(y)) < FEWEST:
        return UNKNOWN
    lags = np.arange(-(len(x) - 1), len(y))
    alike, count = _correlations(x, y)
    fewest = overlap * min(np.isfinite(x).sum(), np.isfinite(y).sum())
    usable = (np.abs(lags) * period_s <= longest_s) & (count >= max(fewest, FEWEST))
    alike = np.where(usable, alike, np.nan)
    if not np.isfinite(alike).any():
        return UNKNOWN
    best = int(np.nanargmax(alike))
    sd_s, independent = _certainty(x, y, int(lags[best]), period_s)
    peak = float(alike[best])
    rival = _rival(alike, best)
    rival_s = rival_peak = float("nan")
    sigmas = float("inf")
    if rival >= 0:
        rival_s, rival_peak = float(lags[rival] * period_s), float(alike[rival])
        z = np.arctanh(np.clip([peak, rival_peak], -1 + 1e-12, 1 - 1e-12))
        sigmas = float((z[0] - z[1]) * np.sqrt(max(independent - 3, 0.0) / 2))
    seconds = float((lags[best] + _vertex(alike, best)) * period_s)
    return Lag(seconds, sd_s, peak, rival_s, rival_peak, sigmas)


def likeness_at(first: FloatArray, then: FloatArray, lag: int) -> float:
    """Return the correlation of two signals at one lag in samples, as ``best_lag`` has it; NaN for none.

    Args:
        first: Samples, (T, C); NaN where unknown.
        then: The same quantities of the other signal, (U, C).
        lag: Samples by which the second comes after the first.
    """
    x, y = _overlapping(_scaled(first), _scaled(then), lag)
    both = np.isfinite(x) & np.isfinite(y)
    counts = both.sum(axis=0)
    x, y = (np.where(both, one, 0.0) for one in (x, y))
    a, b = (one - np.where(both, one.sum(axis=0) / np.maximum(counts, 1), 0.0) for one in (x, y))
    size = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / size if size > 0 else float("nan")


def _scaled(values: FloatArray) -> FloatArray:
    """Columns with mean 0 and size 1; NaN throughout where one never changes."""
    out = np.full(values.shape, np.nan)
    for j, column in enumerate(values.T):
        known = column[np.isfinite(column)]
        if len(known) >= FEWEST and np.ptp(known) > 0:
            out[:, j] = (column - known.mean()) / known.std()
    return out


def _correlations(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Correlation of all columns together at each lag, and how many samples overlap, (T + U - 1,)."""
    count, shared, own, other = np.zeros((4, len(x) + len(y) - 1))
    for a, b in zip(x.T, y.T, strict=True):  # one at a time: of an hour each takes 60 MB
        for total, part in zip((count, shared, own, other), _sums(a, b), strict=True):
            total += part
    sound = (own > 1e-9 * own.max()) & (other > 1e-9 * other.max())
    alike = np.where(sound, shared / np.sqrt(np.where(sound, own * other, 1.0)), np.nan)
    return alike, count


def _sums(x: FloatArray, y: FloatArray) -> tuple[FloatArray, ...]:
    """Of what overlaps at each lag: number, sum of products, and of squares of both, about their means."""
    from scipy import fft  # as late as it is needed

    fast = fft.next_fast_len(len(x) + len(y) - 1, real=True)

    def spectra(values: FloatArray) -> tuple[NDArray[np.complex128], ...]:
        """Of what is known (1 or 0), of the values, of their squares; (fast // 2 + 1,) each."""
        known, filled = np.isfinite(values).astype(np.float64), np.nan_to_num(values)
        return tuple(fft.rfft(one, fast) for one in (known, filled, filled**2))

    def slide(a: NDArray[np.complex128], b: NDArray[np.complex128]) -> FloatArray:
        """Sum of a[i] b[i + lag] for each lag from -(T - 1) on, (T + U - 1,)."""
        around = fft.irfft(a.conj() * b, fast)
        return np.concatenate([around[fast - len(x) + 1 :], around[: len(y)]])

    in_x, of_x, squares_x = spectra(x)
    in_y, of_y, squares_y = spectra(y)
    n = np.round(slide(in_x, in_y))
    sum_x, sum_y, per = slide(of_x, in_y), slide(in_x, of_y), 1 / np.maximum(n, 1)
    return (
        n,
        slide(of_x, of_y) - sum_x * sum_y * per,
        np.maximum(slide(squares_x, in_y) - sum_x**2 * per, 0.0),
        np.maximum(slide(in_x, squares_y) - sum_y**2 * per, 0.0),
    )


def _vertex(values: FloatArray, at: int) -> float:
    """Where the parabola through a maximum and its neighbours has its top, in samples from it."""
    if not 0 < at < len(values) - 1:
        return 0.0
    left, here, right = values[at - 1 : at + 2]
    bend = left - 2 * here + right
    return float(0.5 * (left - right) / bend) if bend < 0 else 0.0


def _rival(alike: FloatArray, best: int) -> int:
    """Index of the highest correlation outside of the best one's own peak; -1 for none.

    A peak reaches on either side to where it has fallen to half.
    """
    values = np.where(np.isfinite(alike), alike, -np.inf)
    low = values < 0.5 * values[best]
    left = best - int(np.argmax(low[best::-1])) if low[: best + 1].any() else 0
    right = best + int(np.argmax(low[best:])) if low[best:].any() else len(values) - 1
    values[left : right + 1] = -np.inf
    other = int(np.argmax(values))
    return other if np.isfinite(values[other]) else -1


def _certainty(x: FloatArray, y: FloatArray, lag: int, period_s: float) -> tuple[float, float]:
    """Standard deviation of a lag, and the number of independent samples of what it leaves over.

    A lag is a parameter of a least-squares fit, with the slope of the signal as its derivative. Only what
    both have of it counts: the noise of one would make its slope steeper.
    """
    a, b = _overlapping(x, y, lag)
    slopes = np.gradient(a, period_s, axis=0) * np.gradient(b, period_s, axis=0)
    a, b = a - np.nanmean(a, axis=0), b - np.nanmean(b, axis=0)
    both = np.isfinite(a) & np.isfinite(b)
    factor = float(np.sum((a * b)[both]) / np.sum((a * a)[both]))
    error = np.where(both, b - factor * a, 0.0)
    lasting = _lasting(error)
    independent = float(both.sum()) / lasting
    information = factor * float(np.nansum(slopes[both])) / lasting
    variance = float(np.sum(error**2)) / max(float(both.sum()), 1.0)
    sd_s = float(np.sqrt(variance / information)) if information > 0 else float("inf")
    return sd_s, independent


def _overlapping(x: FloatArray, y: FloatArray, lag: int) -> tuple[FloatArray, FloatArray]:
    begin = max(0, -lag)
    length = min(len(x), len(y) - lag) - begin
    at: IntArray = np.arange(begin, begin + length)
    return x[at], y[at + lag]


def _lasting(error: FloatArray) -> float:
    """How many samples an error lasts: 1 if they are independent; of all columns, (T, C)."""
    from scipy import fft

    count = len(error)
    power = np.zeros(count + 1)
    for one in error.T:
        power += np.abs(fft.rfft(one - one.mean(), 2 * count)) ** 2
    total = fft.irfft(power, 2 * count)[:count]
    if total[0] <= 0:
        return 1.0
    shares = total / total[0]
    below = np.flatnonzero(shares <= 0)
    return float(1 + 2 * shares[1 : int(below[0]) if len(below) else len(shares)].sum())
