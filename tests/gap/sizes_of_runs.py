"""Sizes of a cause in runs, as tests write them."""

from collections.abc import Sequence

import numpy as np

from gap.search.sizes import Sizes
from model.values.arrays import FloatArray


def walked(values: Sequence[float] | FloatArray, gaits: str = "") -> Sizes:
    """Return sizes of runs, a letter a gait; all of one gait if none is given."""
    return Sizes(np.asarray(values, dtype=float), tuple(gaits or "t" * len(values)))
