"""Arrays as values: their types, and the end of writing to them."""

from dataclasses import fields
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complex128]
Rows = TypeVar("Rows")


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


def part_of(rows: Rows, chosen: slice | BoolArray) -> Rows:
    """Return some rows of a dataclass: its fields have a row each, or are such dataclasses."""
    value: Any = rows
    parts = (getattr(value, field.name) for field in fields(value))
    made: Rows = type(value)(
        *(one[chosen] if hasattr(one, "__getitem__") else part_of(one, chosen) for one in parts)
    )
    return made
