"""Frozen dataclasses that are made in every tick, in half the time or less.

The ``__init__`` that ``dataclass`` writes for a frozen class stores each field with ``object.__setattr__``,
which looks the field up in the class once more. With slots each field has a descriptor, which stores at
once. Where there are many fields, an object is of a class with the same slots that is not frozen while they
are stored, as the interpreter stores those fastest. A tick makes fifty such objects with three hundred
fields. Nothing else changes: the class stays frozen, with the same arguments, defaults and annotations.
"""

from dataclasses import MISSING, fields
from typing import Any, TypeVar

T = TypeVar("T")
MANY_FIELDS = 5  # from so many on it pays to change the class of an object twice


def quick(kind: type[T]) -> type[T]:
    """Give a frozen dataclass with slots an ``__init__`` that stores through the slots.

    Raises:
        TypeError: A field has a factory, or the class does something after its ``__init__``.
    """
    made: Any = kind
    if any(one.default_factory is not MISSING for one in fields(made)) or hasattr(
        kind, "__post_init__"
    ):
        raise TypeError(f"{kind.__name__} does more in its __init__ than store its fields")
    names = [one.name for one in fields(made)]
    lines = [f"def __init__(self, {', '.join(names)}):"]
    scope: dict[str, Any]
    if len(names) >= MANY_FIELDS and kind.__bases__ == (object,):
        thawed = type(kind.__name__, (), {"__slots__": tuple(names)})
        scope = {"change_": vars(object)["__class__"].__set__, "thawed_": thawed, "frozen_": kind}
        stored = [f" self.{name} = {name}" for name in names]
        lines += [" change_(self, thawed_)", *stored, " change_(self, frozen_)"]
    else:
        scope = {f"store_{name}": vars(kind)[name].__set__ for name in names}
        lines += [f" store_{name}(self, {name})" for name in names]
    exec("\n".join(lines), scope)
    init, written = scope["__init__"], made.__init__
    init.__defaults__ = written.__defaults__
    init.__annotations__ = written.__annotations__
    init.__qualname__, init.__module__ = written.__qualname__, kind.__module__
    made.__init__ = init
    return kind
