"""MuJoCo without what it does beside stepping: its profiler, and its own log of warnings.

MuJoCo's Python package reads a clock about twenty times a step and keeps the sums in ``MjData.timer``: a
tenth of a step and more. It takes any function of C in the clock's place, but offers none that is quick; so
one is compiled here. Of a run that becomes unstable, which a candidate may well do, it writes a warning to
the terminal and a file MUJOCO_LOG.TXT into the user's folder; here the candidate pays for it instead.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import mujoco

from model.compiled import compiles


@contextmanager
def quiet() -> Iterator[None]:
    """Let MuJoCo step without its profiler and its warnings; what somebody set instead is left alone.

    Without a compiler the profiler goes on. Steps of other threads meanwhile count as having taken no time.
    """
    clock = None if mujoco.get_mjcb_time() is not None else _still_clock()
    silent = mujoco.get_mju_user_warning() is None
    if clock is not None:
        mujoco.set_mjcb_time(clock)
    if silent:
        mujoco.set_mju_user_warning(_say_nothing)
    try:
        yield
    finally:
        if clock is not None:
            mujoco.set_mjcb_time(None)  # its own again
        if silent:
            mujoco.set_mju_user_warning(None)


def _say_nothing(words: str) -> None:
    del words


@cache
def _still_clock() -> Any:
    """A function of C that always returns 0; None without a compiler."""
    if not compiles():
        return None
    import numba

    @numba.cfunc("float64()")
    def still() -> float:
        return 0.0

    return still.ctypes
