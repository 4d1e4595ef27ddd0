"""filterpy's Kalman filter, loaded without SciPy's statistics.

filterpy imports ``scipy.stats`` for the densities of two distributions, which its Kalman filter does not
use: half a second of every start and 40 MB. So while filterpy is imported, two stand-ins are there in
their place. They load ``scipy.stats`` when they are used. filterpy itself is imported with the first
filter, which not every command needs.
"""

import importlib
import sys
from functools import cache
from types import ModuleType
from typing import Any

STATISTICS = "scipy.stats"
DISTRIBUTIONS = ("norm", "multivariate_normal")  # all that filterpy wants of it


@cache
def kalman_filter_class() -> Any:
    """Return ``filterpy.kalman.KalmanFilter``, which has no types."""
    if STATISTICS in sys.modules or "filterpy" in sys.modules:
        return importlib.import_module("filterpy.kalman").KalmanFilter
    stand_in = ModuleType(STATISTICS)
    distributions = [_Distribution(name) for name in DISTRIBUTIONS]
    for one in distributions:
        setattr(stand_in, one.name, one)
    sys.modules[STATISTICS] = stand_in
    try:
        made = importlib.import_module("filterpy.kalman").KalmanFilter
    finally:
        del sys.modules[STATISTICS]
        for one in distributions:
            one.loads = True
    return made


class _Distribution:
    """A distribution of SciPy that is loaded when it is used.

    Attributes:
        name: Its name in ``scipy.stats``.
        loads: False while filterpy is imported: it asks then whether a density can be computed, and
            looks at no number.
    """

    def __init__(self, name: str) -> None:
        self.name, self.loads = name, False

    def __getattr__(self, attribute: str) -> Any:
        if self.loads:
            return getattr(getattr(importlib.import_module(STATISTICS), self.name), attribute)
        return _not_yet


def _not_yet(*arguments: Any, **named: Any) -> None:
    del arguments, named
