"""Arrays as values: their types, and the end of writing to them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complex128]


def root_mean_square(values: FloatArray) -> FloatArray:
    """Root mean square over the first axis, of what is known; NaN where nothing is."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    total = np.where(known, values, 0.0) ** 2
    rms: FloatArray = np.sqrt(total.sum(axis=0) / np.where(count > 0, count, np.nan))
    return rms


def known_mean(values: FloatArray) -> float:
    """Mean of all that is known; NaN where nothing is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else np.nan


def readonly(array: NDArray[Any]) -> NDArray[Any]:
    """Return the array with its write flag off, so that a value stays the value it was."""
    array.setflags(write=False)
    return array


def given_rows(values: FloatArray) -> FloatArray:
    """Return numbers in rows that nobody may write, the kind of array that kernels are compiled to read."""
    return readonly(np.ascontiguousarray(values, dtype=np.float64).view())
