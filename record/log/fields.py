"""A dataclass as fields of a message: one table gives its ROS 2 definition, its encoder and its decoder."""

from collections.abc import Callable, Sequence
from dataclasses import fields
from enum import EnumMeta
from itertools import groupby
from typing import Any, Generic, NamedTuple, TypeVar, get_type_hints

from record.log.cdr import BOOLS, FLOATS, INTS, CdrReader, CdrWriter
from record.message_form import MessagePart

T = TypeVar("T")
KINDS = {"BOOLS": BOOLS, "FLOATS": FLOATS, "INTS": INTS}
_LETTERS = {"bool": "?", "uint8": "B", "int64": "q", "float64": "d"}
_ARRAYS = {"bool": "BOOLS", "int64": "INTS", "float64": "FLOATS"}
_BYTES = {"bool": 1, "uint8": 1, "int64": 8, "float64": 8}


class _Field(NamedTuple):
    """One field of a message; neighbours with equal ``take`` are read in one call."""

    part: MessagePart
    take: tuple[str, str]  # method of CdrReader, kind of numbers in an array
    size: str  # what CdrReader has to know of the field
    name: str
    made: str  # the value of the dataclass
    item_bytes: int  # of one number, to step over them; 0 for a text
    items: int  # how many of them, 0 for a sequence


class Fields(Generic[T]):
    """Writes and reads the values of a dataclass.

    As those of a dataclass's own methods, the sources of both functions are put together once and compiled:
    between two ticks there is no time to walk through a table.

    Args:
        make: The dataclass.
        lines: Type and name of each field in the message as ROS 2 writes them, in the dataclass's order.
            A third word is the length of a row, for an array of two axes.

    Attributes:
        text: These lines in the message's definition.
        pairs: Name of each field in the dataclass, and in the message.
        parts: What is written of a value.
        write: Writes a value.
        read: Reads a value; raises ValueError where the message is damaged.
        skip: Steps over a value; raises ValueError where the message ends too early.
    """

    write: Callable[[CdrWriter, T], None]
    read: Callable[[CdrReader], T]
    skip: Callable[[CdrReader], None]

    def __init__(self, make: type[T], *lines: str) -> None:
        self.text = "".join(" ".join(line.split()[:2]) + "\n" for line in lines)
        self.pairs = tuple(
            (field.name, line.split()[1])
            for field, line in zip(fields(make), lines, strict=True)  # type: ignore[arg-type]
        )
        types = get_type_hints(make)
        columns = [
            _field(field.name, types[field.name], *line.split())
            for field, line in zip(fields(make), lines, strict=True)  # type: ignore[arg-type]
        ]
        scope: dict[str, Any] = {"make": make, **KINDS}
        scope |= {kind.__name__: kind for kind in types.values() if isinstance(kind, EnumMeta)}
        self.parts = tuple(column.part for column in columns)
        exec("\n".join(_reading(columns)), scope)
        self.write = writer_of(self.parts, scope)
        self.read, self.skip = scope["read"], scope["skip"]

    def write_all(self, w: CdrWriter, values: Sequence[T]) -> None:
        """Write a sequence of values."""
        w.count(len(values))
        for value in values:
            self.write(w, value)

    def read_all(self, r: CdrReader) -> tuple[T, ...]:
        """Read a sequence of values; raises ValueError where the message is damaged."""
        count = r.count()
        return tuple([self.read(r) for _ in range(count)]) if count else ()


def _field(name: str, kind: Any, ros_type: str, _: str, width: str = "") -> _Field:
    element, bracket, size = ros_type.removesuffix("]").partition("[")
    letter, sent, made = _LETTERS.get(element, ""), f"value.{name}", name
    item_bytes, items = _BYTES.get(element, 0), int(size or 0)
    if isinstance(kind, EnumMeta):
        sent, made = f"{sent}.value", f"{kind.__name__}({name})"
    if width:
        made = f"{name}.reshape(-1, {width})"
    if not bracket:
        call = ("texts", "") if element == "string" else ("record", "")
        return _Field(MessagePart(call, letter, sent), call, letter, name, made, item_bytes, 1)
    call = ("arrays" if size else "sequences", _ARRAYS[element])
    if element == "float64" and 0 < items < 5:  # packed with the numbers beside it
        part = MessagePart(("record", ""), letter * items, f"*{sent}.tolist()")
        return _Field(part, call, size, name, made, item_bytes, items)
    return _Field(MessagePart(call, "", sent), call, size, name, made, item_bytes, items)


def writer_of(
    parts: Sequence[MessagePart], scope: dict[str, Any]
) -> Callable[[CdrWriter, Any], None]:
    """Return ``write(w, value)``.

    Args:
        parts: What to write.
        scope: What their expressions need, and the kinds of numbers.
    """
    lines = ["def write(w, value):"]
    for (method, kind), run in groupby(parts, key=lambda part: part.put):
        _, letters, sent = zip(*run, strict=True)
        first = {"record": repr("".join(letters)), "texts": ""}.get(method, kind)
        lines.append(f" w.{method}({', '.join(filter(None, (first, *sent)))})")
    exec("\n".join(lines), scope)
    write: Callable[[CdrWriter, Any], None] = scope["write"]
    return write


def _reading(columns: list[_Field]) -> list[str]:
    """Return the source of ``read(r)`` and ``skip(r)``."""
    lines = ["def read(r):"]
    for (method, kind), run in groupby(columns, key=lambda field: field.take):
        *_, sizes, names, _, _, _ = zip(*run, strict=True)
        how = {
            "record": repr("".join(sizes)),
            "texts": f"{len(names)}",
            "arrays": f"{kind}, {', '.join(sizes)}",
            "sequences": f"{kind}, {len(names)}",
        }
        if kind and len(names) == 1:
            lines.append(
                f" {names[0]} = r.{method[:-1]}({', '.join(filter(None, (kind, *sizes)))})"
            )
        else:
            lines.append(f" {', '.join(names)}, = r.{method}({how[method]})")
    lines.append(f" return make({', '.join(field.made for field in columns)})")
    lines.append("def skip(r):")
    for (item_bytes, fixed), run in groupby(columns, key=lambda f: (f.item_bytes, f.items > 0)):
        items = [field.items for field in run]
        if not item_bytes:
            lines.append(f" r.texts({len(items)})")
        elif fixed:
            lines.append(f" r.skip({item_bytes * sum(items)}, {item_bytes})")
        else:
            lines.append(f" r.skip_sequences({item_bytes}, {len(items)})")
    return lines
