"""Compilation of the hot path with numba, where numba is installed.

Without it the same functions run as plain Python, a few hundred times slower; ``COMPILED`` says which
it is, and ``bigant --version`` shows it. The first call of a process loads machine code from a cache beside
the modules; only the very first one on a machine compiles.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from model.compile_notice import notify

Function = TypeVar("Function", bound=Callable[..., Any])

try:
    import numba
    from numba.core import event
except ImportError:  # no wheel for this interpreter yet: slow, and said so by COMPILED
    COMPILED = False
else:
    COMPILED = True

    class _Compiling(event.Listener):
        """Passes on that a function's compilation begins or ends."""

        def on_start(self, event: Any) -> None:
            notify(begins=True)

        def on_end(self, event: Any) -> None:
            notify(begins=False)

    register: Any = event.register  # has no types
    register("numba:compile", _Compiling())

# Loops that add up may add in any order; NaN and infinity keep their meaning.
ORDER_FREE = frozenset({"reassoc", "contract", "nsz"})


def compiled(function: Function) -> Function:
    """Compile a function of numbers and arrays; a division by zero gives inf or NaN, as in numpy."""
    return _compile(function, fastmath=False)


def compiled_sums(function: Function) -> Function:
    """Compile loops that add up, several terms at a time.

    Results differ from plain Python's in the last bits.
    """
    return _compile(function, fastmath=set(ORDER_FREE))


def _compile(function: Function, fastmath: Any) -> Function:
    if not COMPILED:
        return function
    keep = True
    njit: Any = numba.njit  # its types do not know of the wrapper
    while True:
        try:
            made: Any = njit(
                cache=keep, error_model="numpy", boundscheck=False, fastmath=fastmath,
                no_cfunc_wrapper=True,  # for calls from C, which nobody makes: a tenth of the time
            )(function)  # fmt: skip
        except RuntimeError:  # nowhere to keep the machine code: it is made anew each time
            if not keep:
                raise
            keep = False
        else:
            if keep:
                # the compiler's own stamp is that of one file, and knows nothing of those it calls; as part
                # of the version it is looked at before types are read, which may be gone
                file, stamp = made._cache._cache_file, _stamp(function.__module__.split(".")[0])
                file._source_stamp, file._version = stamp, f"{file._version} {stamp}"
            typed: Function = made
            return typed


@cache
def _stamp(package: str) -> str:
    """A digest of all sources of ``model`` and a package: no machine code outlives a change in any."""
    digest = hashlib.sha256()
    for folder in sorted({"model", package}):
        _digest(files(folder), digest.update)
    return digest.hexdigest()


def _digest(folder: Traversable, update: Callable[[bytes], None]) -> None:
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.name.endswith(".py"):
            update(entry.read_bytes())
        elif entry.is_dir() and entry.name != "__pycache__":
            _digest(entry, update)


NUMBER, COUNT, FLAG = "float64", "int64", "boolean"


@dataclass(frozen=True, slots=True)
class Rows:
    """Type of an array argument, rows one behind the other in memory.

    Attributes:
        axes: How many axes.
        kind: Of its elements.
        given: Whether it is only read; arrays that may be written fit too.
    """

    axes: int
    kind: str = NUMBER
    given: bool = False


def given(*axes: int, kind: str = NUMBER) -> tuple[Rows, ...]:
    """Types of arrays that are only read, one for each number of axes."""
    return tuple(Rows(count, kind, given=True) for count in axes)


def out(*axes: int, kind: str = NUMBER) -> tuple[Rows, ...]:
    """Types of arrays that are written, one for each number of axes."""
    return tuple(Rows(count, kind) for count in axes)


def compile_for(
    function: Callable[..., Any], *arguments: Rows | str | tuple[Any, ...] | NDArray[np.void]
) -> None:
    """Load or make the machine code for one set of types, and close the function to all others.

    It is closed in every case, also if another kernel that calls it has had it compiled before: a call
    with other types is then an error at once, and never a compiler's second in a tick. The type of a
    record or a named tuple is that of an example: each array in it has to be in rows and writable as it is
    there.
    """
    if not COMPILED:
        return
    from numba import types

    dispatcher: Any = function  # has no types
    typeof: Any = numba.typeof
    if dispatcher._can_compile:
        dispatcher.compile(tuple(
            getattr(types, of) if isinstance(of, str)
            else typeof(of) if isinstance(of, tuple | np.ndarray)
            else types.Array(getattr(types, of.kind), of.axes, "C", readonly=of.given)
            for of in arguments
        ))  # fmt: skip
        dispatcher.disable_compile()
