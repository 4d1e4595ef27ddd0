"""Compilation of the hot path with numba, where numba is installed.

Without it the same functions run as plain Python, a few hundred times slower; ``COMPILED`` says which
it is, and ``bigant --version`` shows it. The first call
of a process loads machine code from a cache beside the modules; only the very first one on a machine
compiles.
"""

from collections.abc import Callable
from typing import TypeVar

Function = TypeVar("Function", bound=Callable[..., object])

try:
    import numba
except ImportError:  # no wheel for this interpreter yet: slow, and said so by COMPILED
    COMPILED = False
else:
    COMPILED = True


def compiled(function: Function) -> Function:
    """Compile a function of numbers and arrays; errors of arithmetic give NaN, as in numpy."""
    if not COMPILED:
        return function
    fast: Function = numba.njit(cache=True, error_model="numpy", boundscheck=False)(function)
    return fast


def compiled_sums(function: Function) -> Function:
    """Compile loops that add up: terms may be added in any order, so that several go at a time.

    NaN and infinity keep their meaning. Results differ from plain Python's in the last bits.
    """
    if not COMPILED:
        return function
    order_free = {"reassoc", "contract", "nsz"}
    fast: Function = numba.njit(
        cache=True, error_model="numpy", boundscheck=False, fastmath=order_free
    )(function)
    return fast
