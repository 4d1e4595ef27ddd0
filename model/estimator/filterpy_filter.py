"""filterpy's Kalman filter, loaded without SciPy's statistics and image filters.

filterpy imports ``scipy.stats`` for the densities of two distributions, and ``scipy.ndimage`` for two
functions of another filter. Its Kalman filter uses none of them: half a second of every start and 40 MB,
and another tenth. So while filterpy is imported, stand-ins are there in their place. They load the module
when they are used. filterpy itself is imported with the first filter, which not every command needs.
"""

import importlib
import sys
from functools import cache
from types import ModuleType
from typing import Any

UNUSED = {  # all that filterpy wants of each
    "scipy.stats": ("norm", "multivariate_normal"),
    "scipy.ndimage": ("convolve", "shift"),
}


@cache
def kalman_filter_class() -> Any:
    """Return ``filterpy.kalman.KalmanFilter``, which has no types."""
    left_out = (
        [] if "filterpy" in sys.modules else [name for name in UNUSED if name not in sys.modules]
    )
    stand_ins: list[_StandIn] = []
    for module in left_out:
        sys.modules[module] = ModuleType(module)
        for name in UNUSED[module]:
            stand_ins.append(_StandIn(module, name))
            setattr(sys.modules[module], name, stand_ins[-1])
    try:
        made = importlib.import_module("filterpy.kalman").KalmanFilter
    finally:
        for module in left_out:
            del sys.modules[module]
        for one in stand_ins:
            one.loads = True
    return made


class _StandIn:
    """A part of SciPy that is loaded when it is used.

    Args:
        module: Where it is.
        name: Its name there.

    Attributes:
        loads: False while filterpy is imported: it asks then whether a density can be computed, and
            looks at no number.
    """

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name, self.loads = module, name, False

    def __getattr__(self, attribute: str) -> Any:
        return getattr(self._real(), attribute) if self.loads else _not_yet

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        return self._real()(*arguments, **named)

    def _real(self) -> Any:
        return getattr(importlib.import_module(self._module), self._name)


def _not_yet(*arguments: Any, **named: Any) -> None:
    del arguments, named
