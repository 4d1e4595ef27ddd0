"""MuJoCo without its profiler, whose clock takes a tenth of a step and more.

MuJoCo's Python package reads a clock about twenty times a step and keeps the sums in ``MjData.timer``. It
takes any function of C in the clock's place, but offers none that is quick; so one is compiled here.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import mujoco

from model.compiled import COMPILED


@contextmanager
def untimed() -> Iterator[None]:
    """Let MuJoCo step without its profiler; a clock that somebody set is left alone.

    Without a compiler nothing changes. Steps of other threads meanwhile count as having taken no time.
    """
    clock = _still_clock()
    if clock is None or mujoco.get_mjcb_time() is not None:
        yield
        return
    mujoco.set_mjcb_time(clock)
    try:
        yield
    finally:
        mujoco.set_mjcb_time(None)  # its own again


@cache
def _still_clock() -> Any:
    """A function of C that always returns 0; None without a compiler."""
    if not COMPILED:
        return None
    import numba

    @numba.cfunc("float64()")
    def still() -> float:
        return 0.0

    return still.ctypes
