"""Fewer points of a curve that look the same: of each stretch, the lowest and the highest are kept."""

import numpy as np

from model.values.arrays import FloatArray, IntArray


def kept_rows(x: FloatArray, y: FloatArray, most: int) -> IntArray:
    """Return which of K points of a curve are kept, at most ``most`` of them (four at least), in order.

    Where x only grows (a curve over time): of each stretch the lowest and the highest, so that no peak is
    lost. Otherwise (a path in a plane): points at equal steps. Ends are always kept, and where values
    become unknown (NaN) the curve still breaks.
    """
    count = len(x)
    if count <= most:
        return np.arange(count)
    if not bool((np.diff(x) >= 0.0).all()):
        return np.unique(np.linspace(0, count - 1, most).round().astype(np.int64))
    edges = np.linspace(0, count, max(1, (most - 2) // 3) + 1).round().astype(np.int64)
    begins, lengths = edges[:-1], np.diff(edges)
    known, absent = np.isfinite(y), np.isnan(y)
    some = np.logical_or.reduceat(known, begins)
    rows = [np.array([0, count - 1])]
    for sign in (1.0, -1.0):
        values = np.where(absent, np.inf, sign * y)
        least = np.repeat(np.minimum.reduceat(values, begins), lengths)
        at = np.flatnonzero(values == least)
        rows.append(at[np.searchsorted(at, begins[some])])
    gaps = np.flatnonzero(~known)
    # the first of each stretch that has some
    first = np.unique(np.searchsorted(gaps, begins))
    rows.append(gaps[first[first < len(gaps)]])
    return np.unique(np.concatenate(rows))
