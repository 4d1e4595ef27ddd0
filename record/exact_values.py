"""Frozen values to bytes and back without a bit lost: dataclasses, named tuples, enumerations and arrays.

For what a program remembers, such as the controller's state in a log. Equal values give equal bytes, so
bytes can be compared in place of values. Bytes from a file make nothing but values of the classes that a
reader expects: those in the annotations of the class that is read (``classes_in``).

The format: length of a JSON text, the text, the arrays' numbers one behind the other.
"""

import json
import struct
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np

from model.values.arrays import readonly

# What begins a list in the text: the kind of value that its other elements are.
ARRAY, OBJECT, MEMBER, TUPLE, NAMED = "array", "object", "member", "tuple", "named"
_LENGTH = struct.Struct("<I")
_KINDS = frozenset("biuf")  # of numpy: bool, int, unsigned, float
Classes = Mapping[str, type]
NameOf = Callable[[object], str | None]


def no_name(_value: object) -> None:
    """No value is known by a name alone."""


def classes_in(kind: Any) -> Classes:
    """Return every class that a value of this class can hold, by its name, as its annotations say.

    Raises:
        TypeError: Two of them have one name.
    """
    classes: dict[str, type] = {}
    _collect(kind, classes)
    return classes


def _collect(kind: Any, classes: dict[str, type]) -> None:
    if get_origin(kind) is not None or not isinstance(kind, type):
        for part in get_args(kind):
            _collect(part, classes)
        return
    if not (is_dataclass(kind) or _is_named_tuple(kind) or issubclass(kind, Enum)):
        return
    known = classes.get(kind.__name__)
    if known is not None and known is not kind:
        raise TypeError(f"{known} and {kind} have one name")
    if known is None:
        classes[kind.__name__] = kind
        for hint in get_type_hints(kind).values():
            _collect(hint, classes)


def _is_named_tuple(kind: type) -> bool:
    return issubclass(kind, tuple) and hasattr(kind, "_fields")


def encode_values(value: object, name_of: NameOf = no_name) -> bytes:
    """Return a value as bytes.

    Args:
        value: Nested dataclasses, named tuples, tuples, enumerations, arrays of numbers and plain values.
        name_of: The name of what is written as a name alone, None for all else.

    Raises:
        TypeError: There is something else in it.
    """
    arrays: list[bytes] = []
    tree = _Encoder(arrays, name_of).tree(value)
    text = json.dumps(tree, separators=(",", ":")).encode("utf-8")
    return b"".join((_LENGTH.pack(len(text)), text, *arrays))


class _Encoder:
    def __init__(self, arrays: list[bytes], name_of: NameOf) -> None:
        self._arrays, self._name_of = arrays, name_of

    def tree(self, value: object) -> Any:
        kind = type(value)
        if value is None or kind in {bool, int, float, str}:
            return value
        if kind is np.ndarray or isinstance(value, np.generic):
            return self._array(np.asarray(value), scalar=kind is not np.ndarray)
        name = self._name_of(value)
        if name is not None:
            return [NAMED, name]
        if isinstance(value, Enum):
            return [MEMBER, kind.__name__, value.name]
        if isinstance(value, tuple):
            begin = [OBJECT, kind.__name__] if _is_named_tuple(kind) else [TUPLE]
            return [*begin, *map(self.tree, value)]
        if is_dataclass(value) and not isinstance(value, type):
            parts = (self.tree(getattr(value, field.name)) for field in fields(value))
            return [OBJECT, kind.__name__, *parts]
        raise TypeError(f"a {kind.__name__} has no bytes of its own")

    def _array(self, array: np.ndarray, *, scalar: bool) -> list[Any]:
        if array.dtype.kind not in _KINDS:
            raise TypeError(f"an array of {array.dtype} has no bytes of its own")
        # products of matrices are rounded by the order that their numbers lie in
        turned = array.flags.f_contiguous and not array.flags.c_contiguous
        order: Literal["C", "F"] = "F" if turned else "C"
        self._arrays.append(array.tobytes(order))
        return [ARRAY, array.dtype.str, order, scalar, *array.shape]


def decode_values(data: bytes, classes: Classes, named: Callable[[str], object]) -> Any:
    """Return the value of which these are the bytes; its arrays are not to be written to.

    Args:
        data: Of ``encode_values``.
        classes: Those that may be made, of ``classes_in``.
        named: What a name stands for.

    Raises:
        ValueError: They are not such bytes, or there is a class in them that is not expected.
    """
    try:
        (size,) = _LENGTH.unpack_from(data)
        begin = _LENGTH.size + size
        decoder = _Decoder(data, begin, classes, named)
        value = decoder.value(json.loads(data[_LENGTH.size : begin]))
    except (struct.error, KeyError, IndexError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"not a value of this version: {error!r}") from error
    if decoder.at != len(data):
        raise ValueError("not a value of this version: its length is another")
    return value


class _Decoder:
    def __init__(
        self, data: bytes, at: int, classes: Classes, named: Callable[[str], object]
    ) -> None:
        self.at = at
        self._data, self._classes, self._named = data, classes, named

    def value(self, tree: Any) -> Any:
        if not isinstance(tree, list):
            return tree
        kind, *rest = tree
        if kind == ARRAY:
            return self._array(*rest)
        if kind == TUPLE:
            return tuple(map(self.value, rest))
        if kind == NAMED:
            return self._named(rest[0])
        made = self._classes[rest[0]]
        if kind == MEMBER:
            return getattr(made, rest[1])
        if kind != OBJECT:
            raise ValueError(f"not a value of this version: {kind!r}")
        return made(*map(self.value, rest[1:]))

    def _array(self, dtype: str, order: str, scalar: bool, *shape: int) -> Any:
        kind = np.dtype(dtype)
        if kind.kind not in _KINDS or min(shape, default=0) < 0:
            raise ValueError(f"not a value of this version: an array of {dtype}, {shape}")
        size = kind.itemsize * int(np.prod(shape, dtype=object))
        flat = np.frombuffer(self._data[self.at : self.at + size], dtype=kind)
        self.at += size
        array = flat.reshape(shape, order="F" if order == "F" else "C").copy("K")
        return array[()] if scalar else readonly(array)
