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
    rows = [0, count - 1]
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        part = y[begin:end]
        known = np.isfinite(part)
        if known.any():
            rows += [begin + int(np.nanargmin(part)), begin + int(np.nanargmax(part))]
        if not known.all():
            rows.append(begin + int(np.argmin(known)))
    return np.unique(np.array(rows))
