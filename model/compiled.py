"""Compilation of the hot path with numba, where numba is installed.

Without it the same functions run as plain Python, a few hundred times slower; ``compiles()`` says which
it is, and ``bigant --version`` shows it. The first call of a process loads machine code from the user's
cache (``kernel_cache``); only the very first one on a machine compiles. numba itself takes 70 MB and a
quarter of a second, so it is imported when the first kernel is called, and never by a command that
computes nothing.
"""

import hashlib
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache, update_wrapper
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from model.compile_notice import notify
from model.kernel_cache import KernelFiles, kernel_folder

Function = TypeVar("Function", bound=Callable[..., Any])


@cache
def compiles() -> bool:
    """Whether functions are compiled; the first call imports the compiler, if it is there."""
    try:
        import numba
        from numba.core import event
        from numba.extending import typeof_impl
    except ImportError:  # no wheel for this interpreter yet
        return False
    settings: Any = numba.config  # has no types
    if settings.DISABLE_JIT:  # NUMBA_DISABLE_JIT=1: plain Python, for a debugger
        return False

    class _Compiling(event.Listener):
        """Passes on that a function's compilation begins or ends."""

        def on_start(self, event: Any) -> None:
            notify(begins=True)

        def on_end(self, event: Any) -> None:
            notify(begins=False)

    register: Any = event.register  # has no types
    register("numba:compile", _Compiling())
    type_of: Any = typeof_impl
    type_of.register(Kernel)(_type_of_kernel)
    return True


# Loops that add up may add in any order; NaN and infinity keep their meaning.
ORDER_FREE = frozenset({"reassoc", "contract", "nsz"})


class Kernel:
    """A function that is compiled, or loaded as machine code, when it is first called.

    Attributes:
        py_func: The function as it was written.
        in_place: Of ``in_place``.
        __call__: What a call calls; in a slot, so that a call passes no function of Python.
    """

    __slots__ = ("__call__", "__dict__", "_fastmath", "in_place", "py_func")

    def __init__(self, function: Callable[..., Any], fastmath: Any) -> None:
        self.py_func, self._fastmath, self.in_place = function, fastmath, False
        self.__call__ = self._first_call
        update_wrapper(self, function)

    def dispatcher(self) -> Any:
        """Return numba's dispatcher, or the function itself where nothing is compiled."""
        if self.__call__ == self._first_call:
            self.__call__ = (
                _dispatcher(self.py_func, self._fastmath, counts=not self.in_place)
                if compiles()
                else self.py_func
            )
        return self.__call__

    def _first_call(self, *arguments: Any, **named: Any) -> Any:
        called = self.py_func if _spares_the_compiler() else self.dispatcher()
        return called(*arguments, **named)


_SPARED = ContextVar("few calls", default=False)


@contextmanager
def few_calls() -> Iterator[None]:
    """Inside, kernels are plain Python, unless something has imported the compiler already.

    For what needs some thousand poses and nothing more, such as a page: that takes no longer than to import
    numba and to load machine code, and 130 MB less. Results differ in the last bits at most.
    """
    token = _SPARED.set(True)
    try:
        with np.errstate(divide="ignore", invalid="ignore"):
            yield
    finally:
        _SPARED.reset(token)


def _spares_the_compiler() -> bool:
    return _SPARED.get() and "numba" not in sys.modules


def _type_of_kernel(kernel: Kernel, context: Any) -> Any:
    """Type of a kernel that another one calls."""
    del context
    from numba import types

    dispatcher_type: Any = types.Dispatcher  # has no types
    return dispatcher_type(kernel.dispatcher())


def compiled(function: Function) -> Function:
    """Compile a function of numbers and arrays; a division by zero gives inf or NaN, as in numpy."""
    return _kernel(function, fastmath=False)


def compiled_sums(function: Function) -> Function:
    """Compile loops that add up, several terms at a time.

    Results differ from plain Python's in the last bits.
    """
    return _kernel(function, fastmath=set(ORDER_FREE))


def in_place(function: Function) -> Function:
    """Say of a compiled function that it makes no array itself; an array made in it is an error.

    Its machine code does not count who holds the arrays that it works in: the caller does, as long as it
    takes. Counted is every view of a row, with a lock across all cores: a third of the model's time.
    """
    kernel: Any = function
    kernel.in_place = True
    return function


def _kernel(function: Function, fastmath: Any) -> Function:
    kernel: Any = Kernel(function, fastmath)
    typed: Function = kernel  # to those who call it, it is the function
    return typed


def _dispatcher(function: Callable[..., Any], fastmath: Any, *, counts: bool) -> Any:
    import numba

    keep = True
    njit: Any = numba.njit  # its types do not know of the wrapper
    while True:
        try:
            made: Any = njit(
                cache=keep, error_model="numpy", boundscheck=False, fastmath=fastmath,
                _nrt=counts,  # in either case, or it would be that of the kernel that calls it first
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
            made.get_call_template = _for_any_constant(made.get_call_template)
            return made


def _for_any_constant(template_of: Callable[..., Any]) -> Callable[..., Any]:
    """Let a kernel that is called with a constant use the machine code for any number of that type.

    The compiler would make one for each constant, and with it all that is called: a sixth of a first start.
    """
    from numba import types

    plain: Any = types.unliteral  # has no types

    def template(arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        return template_of(
            tuple(plain(each) for each in arguments),
            {name: plain(each) for name, each in named.items()},
        )

    return template


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
    if _spares_the_compiler() or not compiles():
        return
    from numba import typeof as type_of_example
    from numba import types

    kernel: Any = function
    dispatcher = kernel.dispatcher()
    typeof: Any = type_of_example  # has no types
    if dispatcher._can_compile:
        dispatcher.compile(tuple(
            getattr(types, of) if isinstance(of, str)
            else typeof(of) if isinstance(of, tuple | np.ndarray)
            else types.Array(getattr(types, of.kind), of.axes, "C", readonly=of.given)
            for of in arguments
        ))  # fmt: skip
        dispatcher.disable_compile()
