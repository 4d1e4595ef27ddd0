"""Compilation of the hot path with numba, where numba is installed.

Without it the same functions run as plain Python, a few hundred times slower; ``COMPILED`` says which
it is, and ``bigant --version`` shows it. The first call of a process loads machine code from the user's
cache (``kernel_cache``); only the very first one on a machine compiles.
"""

import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from model.compile_notice import notify
from model.kernel_cache import KernelFiles, kernel_folder

Function = TypeVar("Function", bound=Callable[..., Any])

try:
    import numba
    from numba.core import event
except ImportError:  # no wheel for this interpreter yet: slow, and said so by COMPILED
    COMPILED = False
else:
    settings: Any = numba.config  # has no types
    COMPILED = not settings.DISABLE_JIT  # NUMBA_DISABLE_JIT=1: plain Python, for a debugger

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
        except RuntimeError:  # nowhere to keep the machine code: it is made again each time
            if not keep:
                raise
            keep = False
        else:
            if keep:
                # the compiler's own stamp is that of one file, and knows nothing of those it calls
                module = function.__module__
                made._cache._cache_file = KernelFiles(
                    f"{module}.{function.__qualname__}", _stamp(module), numba.__version__,
                    kernel_folder(),
                )  # fmt: skip
            typed: Function = made
            return typed


@cache
def _stamp(module: str) -> str:
    """A digest of a module and of all that it imports of ours: no machine code outlives a change."""
    digest = hashlib.sha256()
    for name, source in sorted(sources_of(module).items()):
        digest.update(name.encode() + source)
    return digest.hexdigest()


def sources_of(module: str) -> dict[str, bytes]:
    """Return the sources of a module and of every module of ``model`` or its own package that it imports.

    Where a name is imported from a package, all modules of that package count.
    """
    packages = {"model", module.split(".")[0]}
    sources: dict[str, bytes] = {}
    left = [module]
    while left:
        name = left.pop()
        if name in sources or name.split(".")[0] not in packages:
            continue
        sources[name], members = _source(name)
        left += members
        left += [(first or second).decode() for first, second in IMPORTS.findall(sources[name])]
    return sources


IMPORTS = re.compile(
    rb"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import|import[ \t]+([\w.]+))", re.MULTILINE
)


def _source(name: str) -> tuple[bytes, list[str]]:
    """Return a module's source, and the modules in it if it is a package below the first level."""
    top, *rest = name.split(".")
    entry: Traversable = files(top).joinpath(*rest)
    if not entry.is_dir():
        *folders, last = rest
        return files(top).joinpath(*folders, f"{last}.py").read_bytes(), []
    inside = [each.name[:-3] for each in entry.iterdir() if each.name.endswith(".py")]
    members = [f"{name}.{each}" for each in inside if each != "__init__"] if rest else []
    return entry.joinpath("__init__.py").read_bytes(), members


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
