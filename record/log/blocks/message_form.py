"""Where the fields of a message lie: found once for all messages of one form, to read them as columns.

Two messages of one type have every field in the same place if all their sequences and texts are as long.
Nearly all ticks of a walk are of a few such forms, so that a field of two thousand ticks is a column of one
table of bytes, at a hundredth of the cost of taking each message apart.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import BoolArray, IntArray, readonly
from record.log.cdr import HEADER, CdrReader

_KINDS: dict[str, np.dtype[Any]] = {
    "bool": np.dtype(np.uint8),
    "uint8": np.dtype(np.uint8),
    "int64": np.dtype("<i8"),
    "float64": np.dtype("<f8"),
}
TEXT_LIMIT = 0x80  # bytes below it are text in any encoding that begins with ASCII


class FieldPlace(NamedTuple):
    """Where a field lies in a message.

    Attributes:
        at: First byte, of the message with its header.
        kind: Of its numbers; None for a text.
        flag: Whether they are flags, which a byte holds.
        numbers: How many, or bytes of a text; -1 for a single number.
    """

    at: int
    kind: np.dtype[Any] | None
    flag: bool
    numbers: int


@dataclass(frozen=True, slots=True, eq=False)
class MessageForm:
    """The form of messages.

    Attributes:
        size: Their length [bytes].
        places: Of each field by its name; fields of the second message in ``NAME[]`` are ``NAME.1.FIELD``.
        marks: Bytes that are the same in all of them, the header and the lengths of sequences and texts:
            where they lie, (C,), and what they are, (C,).
        counts: Of each sequence of messages, how many.
        begins: Of each, where it begins, counted from behind the header.
    """

    size: int
    places: Mapping[str, FieldPlace]
    marks: tuple[IntArray, NDArray[np.uint8]]
    counts: Mapping[str, int]
    begins: Mapping[str, int]

    def fits(self, table: NDArray[np.uint8]) -> BoolArray:
        """Which rows of a table, (B, size), are messages of this form, (B,)."""
        fitting: BoolArray = (table[:, self.marks[0]] == self.marks[1]).all(axis=1)
        return fitting


class Columns:
    """Messages of one form as columns.

    Args:
        form: The form.
        table: Their bytes, (B, size).

    Attributes:
        form: The same.
        table: The same.
    """

    def __init__(self, form: MessageForm, table: NDArray[np.uint8]) -> None:
        self.form, self.table = form, table

    def __len__(self) -> int:
        return len(self.table)

    def of(self, name: str) -> NDArray[Any]:
        """Return a field of all messages, (B,), or (B, n) if it is a sequence."""
        at, kind, flag, count = self.form.places[name]
        size = (kind.itemsize if kind is not None else 1) * abs(count)
        data = np.ascontiguousarray(self.table[:, at : at + size])
        numbers = data if kind is None or size == 0 else data.view(kind)
        if size == 0 and kind is not None:
            numbers = np.empty((len(data), 0), kind)
        if flag:
            numbers = numbers != 0  # of a damaged byte the same as of 1
        return readonly(numbers[:, 0] if count < 0 else numbers)

    def plain(self) -> BoolArray:
        """Which messages have no byte in their texts that may be damaged or not ASCII, (B,)."""
        plain = np.ones(len(self.table), dtype=bool)
        for name, place in self.form.places.items():
            if place.kind is None:
                plain &= (self.of(name) < TEXT_LIMIT).all(axis=1)
        return plain


def in_order(
    count: int, parts: Sequence[tuple[IntArray | list[int], NDArray[Any]]]
) -> NDArray[Any]:
    """Columns of several forms as one, each row at its place.

    Args:
        count: Rows of it; those of no part are 0.
        parts: Places, and a row for each; at least one part.
    """
    places, first = parts[0]
    if len(first) == count:
        return first
    whole = np.zeros((count, *first.shape[1:]), first.dtype)
    for places, column in parts:
        whole[places] = column
    return readonly(whole)


def form_of(data: bytes, definitions: Mapping[str, str], name: str) -> MessageForm:
    """Find the form of a message.

    Args:
        data: The message.
        definitions: Texts of its type and of the types in it, as ROS 2 writes them.
        name: Its type, one of them.

    Raises:
        ValueError: It ends too early, or is no CDR.
    """
    walk = _Walk(CdrReader(data), definitions)
    walk.message(name, "")
    at = np.concatenate([np.arange(2), np.add.outer(walk.lengths, np.arange(4)).ravel()])
    marks = at, np.frombuffer(data, np.uint8)[at]
    return MessageForm(len(data), walk.places, marks, walk.counts, walk.begins)


class _Walk:
    """One walk through a message."""

    def __init__(self, reader: CdrReader, definitions: Mapping[str, str]) -> None:
        self._reader = reader
        self._definitions = definitions
        self.places: dict[str, FieldPlace] = {}
        self.lengths: list[int] = []  # where they lie
        self.counts: dict[str, int] = {}
        self.begins: dict[str, int] = {}

    def message(self, name: str, prefix: str) -> None:
        for element, bracket, size, field in _fields(self._definitions[name]):
            whole = prefix + field
            if element in self._definitions:
                self.counts[whole] = self._length()
                self.begins[whole] = self._reader.at - 4
                for number in range(self.counts[whole]):
                    self.message(element, f"{whole}.{number}.")
            elif element == "string":
                count = self._length()
                self.places[whole] = FieldPlace(
                    self._step(count, 1), None, flag=False, numbers=count
                )
            else:
                kind = _KINDS[element]
                count = int(size) if size else self._length() if bracket else -1
                width = kind.itemsize
                at = self._step(abs(count) * width, width if count else 1)
                self.places[whole] = FieldPlace(at, kind, element == "bool", count)

    def _length(self) -> int:
        at = self._reader.at
        length = self._reader.count()
        self.lengths.append(self._reader.at - 4 + len(HEADER))
        if length > 1 << 24:
            raise ValueError(f"a length of {length} at byte {at}")
        return length

    def _step(self, size: int, alignment: int) -> int:
        return self._reader.skip(size, alignment) + len(HEADER)


@lru_cache
def _fields(text: str) -> Sequence[tuple[str, str, str, str]]:
    """Element, bracket, size and name of each field of a definition; constants are none."""
    fields = []
    for line in text.splitlines():
        if "=" not in line:
            kind, name = line.split()
            element, bracket, size = kind.removesuffix("]").partition("[")
            fields.append((element, bracket, size, name))
    return tuple(fields)
