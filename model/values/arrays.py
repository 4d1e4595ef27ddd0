"""Arrays as values: their types, and the end of writing to them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def readonly(array: NDArray[Any]) -> NDArray[Any]:
    """Return the array with its write flag off, so that a value stays the value it was."""
    array.setflags(write=False)
    return array
