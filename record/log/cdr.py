"""CDR, the byte format of ROS 2 messages: a writer and a reader of just what our messages need.

Our own because the log is written between two ticks: a tick is encoded in 34 us, by rosbags in 107 from
a message that is made already; decoded in 147 us to a tick, by rosbags in 123 to its message (medians of
200 rounds in turn). Tests hold the bytes against two independent decoders. Little endian, plain CDR
(XCDR1): every value aligned to its own size behind the four-byte header. Source: OMG CORBA/IIOP "CDR
transfer syntax", DDS-RTPS encapsulation.
"""

import struct
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from model.values.arrays import BoolArray, FloatArray, IntArray

HEADER = b"\x00\x01\x00\x00"
_U32 = struct.Struct("<I")
_I32 = struct.Struct("<i")
_I64 = struct.Struct("<q")
_F64 = struct.Struct("<d")
# made once: numpy would take the text apart at every call
_FLOATS, _INTS, _BOOLS = np.dtype("<f8"), np.dtype("<i8"), np.dtype(np.bool_)
_COUNT_AND_GAP = struct.Struct("<I4x")
# length of a sequence and the gap behind it, for the lengths that occur
_COUNTS = tuple(_COUNT_AND_GAP.pack(count) for count in range(256))
_PADDING = (b"", b"\0", b"\0\0", b"\0\0\0", b"\0" * 4, b"\0" * 5, b"\0" * 6, b"\0" * 7)


@cache
def _record(kinds: str, at: int) -> struct.Struct:
    """Numbers of different sizes (``struct``'s letters) from a place on, each with its gap before it."""
    codes, place = [], at
    for kind in kinds:
        size = struct.calcsize("<" + kind)
        gap = -place % size
        codes.append(f"{gap}x{kind}")
        place += gap + size
    return struct.Struct("<" + "".join(codes))


@cache
def _row(kind: str, count: int) -> struct.Struct:
    """So many numbers of a kind, one behind the other."""
    return struct.Struct(f"<{count}{kind}")


class CdrWriter:
    """Builds one message.

    Args:
        at: Place in a message that has been begun elsewhere, to build only what follows; alignment
            counts from the message's beginning.
    """

    def __init__(self, at: int = 0) -> None:
        self._parts: list[bytes] = [] if at else [HEADER]
        self._size = at  # without the header, which alignment does not count

    def _put(self, data: bytes, alignment: int) -> None:
        gap = -self._size % alignment
        if gap:
            self._parts.append(_PADDING[gap])
        self._parts.append(data)
        self._size += gap + len(data)

    def record(self, kinds: str, *values: float) -> None:
        """Write numbers of different kinds, ``struct``'s letters, at once: ``?`` bool, ``q`` int64, ..."""
        packed = _record(kinds, self._size & 7)
        self._parts.append(packed.pack(*values))
        self._size += packed.size

    def u8(self, value: int) -> None:
        """Write a byte."""
        self._put(bytes((value,)), 1)

    def flag(self, value: bool) -> None:
        """Write a bool."""
        self._put(b"\1" if value else b"\0", 1)

    def i32(self, value: int) -> None:
        """Write an int32."""
        self._put(_I32.pack(value), 4)

    def u32(self, value: int) -> None:
        """Write a uint32; also the length of a sequence."""
        self._put(_U32.pack(value), 4)

    def _put8(self, data: bytes) -> None:
        """Put numbers of eight bytes: ``_put`` without its questions."""
        gap = -self._size & 7
        if gap:
            self._parts.append(_PADDING[gap])
        self._parts.append(data)
        self._size += gap + len(data)

    def i64(self, *values: int) -> None:
        """Write int64s, one or a row of them."""
        self._put8(_row("q", len(values)).pack(*values))

    def f64(self, *values: float) -> None:
        """Write float64s, one or a row of them."""
        self._put8(_row("d", len(values)).pack(*values))

    def text(self, value: str) -> None:
        """Write a string: length with its closing zero, then the bytes."""
        data = value.encode("utf-8") + b"\0"
        self._put(_U32.pack(len(data)) + data, 4)

    def texts(self, values: Sequence[str]) -> None:
        """Write a sequence of strings."""
        self.u32(len(values))
        for value in values:
            self.text(value)

    def f64_array(self, values: FloatArray) -> None:
        """Write a fixed array of float64, any shape, row by row."""
        if values.dtype is not _FLOATS:  # asking costs less than a cast that changes nothing
            values = values.astype(_FLOATS)
        self._put8(values.tobytes())

    def f64s(self, *rows: FloatArray) -> None:
        """Write sequences of float64, one behind the other."""
        for values in rows:
            if values.dtype is not _FLOATS:
                values = values.astype(_FLOATS)
            self._sequence(values.tobytes())

    def _sequence(self, data: bytes) -> None:
        """Put the length of a sequence of eight-byte numbers, the gap behind it, and the numbers."""
        count = len(data) >> 3
        if not self._size & 7 and 0 < count < len(_COUNTS):
            self._parts += _COUNTS[count], data
            self._size += 8 + len(data)
            return
        self.u32(count)
        if count:
            self._put8(data)

    def i64_array(self, values: IntArray) -> None:
        """Write a fixed array of int64."""
        if values.dtype is not _INTS:
            values = values.astype(_INTS)
        self._put8(values.tobytes())

    def i64s(self, *rows: IntArray) -> None:
        """Write sequences of int64, one behind the other."""
        for values in rows:
            if values.dtype is not _INTS:
                values = values.astype(_INTS)
            self._sequence(values.tobytes())

    def flag_array(self, values: BoolArray) -> None:
        """Write a fixed array of bool."""
        if values.dtype is not _BOOLS:
            values = values.astype(_BOOLS)
        self._put(values.tobytes(), 1)  # numpy keeps a bool in a byte that is 0 or 1

    def flags(self, values: BoolArray) -> None:
        """Write a sequence of bool."""
        if values.dtype is not _BOOLS:
            values = values.astype(_BOOLS)
        self._put(_U32.pack(values.size) + values.tobytes(), 4)

    def raw(self, data: bytes, alignment: int) -> None:
        """Write bytes made beforehand, which begin at an alignment."""
        self._put(data, alignment)

    def done(self) -> bytes:
        """Return the message."""
        return b"".join(self._parts)


class CdrReader:
    """Takes one message apart, in the order in which it was written.

    Args:
        data: The message.

    Raises:
        ValueError: It is no little-endian CDR, or ends too early (from any method).
    """

    def __init__(self, data: bytes) -> None:
        if data[:2] != HEADER[:2]:
            raise ValueError("not little-endian CDR")
        # a copy, four bytes further down: numbers of eight bytes then lie where a processor likes them
        self._data = data[len(HEADER) :]
        self._size = len(self._data)
        self._at = 0

    @property
    def at(self) -> int:
        """Bytes read so far, without the header."""
        return self._at

    def go_on_at(self, place: int) -> None:
        """Go on where ``at`` once was."""
        self._at = place

    def _skip(self, size: int, alignment: int) -> int:
        """Step over the next so many bytes; return where they begin."""
        begin = self._at + -self._at % alignment
        self._at = begin + size
        if self._at > self._size:
            raise ValueError("the message ends too early")
        return begin

    def record(self, kinds: str) -> tuple[Any, ...]:
        """Read numbers of different kinds, ``struct``'s letters, at once."""
        packed = _record(kinds, self._at & 7)
        return packed.unpack_from(self._data, self._skip(packed.size, 1))

    def u8(self) -> int:
        """Read a byte."""
        return self._data[self._skip(1, 1)]

    def flag(self) -> bool:
        """Read a bool."""
        return self._data[self._skip(1, 1)] != 0

    def u32(self) -> int:
        """Read a uint32."""
        value: int = _U32.unpack_from(self._data, self._skip(4, 4))[0]
        return value

    def i64(self) -> int:
        """Read an int64."""
        value: int = _I64.unpack_from(self._data, self._skip(8, 8))[0]
        return value

    def f64(self) -> float:
        """Read a float64."""
        value: float = _F64.unpack_from(self._data, self._skip(8, 8))[0]
        return value

    def text(self) -> str:
        """Read a string."""
        return self.octets()[:-1].decode("utf-8")

    def octets(self) -> bytes:
        """Read a sequence of bytes."""
        count = self.u32()
        begin = self._skip(count, 1)
        return bytes(self._data[begin : begin + count])

    def f64_array(self, count: int) -> FloatArray:
        """Read a fixed array of float64."""
        return np.frombuffer(self._data, _FLOATS, count, self._skip(8 * count, 8))

    def f64s(self) -> FloatArray:
        """Read a sequence of float64."""
        count, begin = self._sequence()
        return np.frombuffer(self._data, _FLOATS, count, begin) if count else np.zeros(0)

    def _sequence(self) -> tuple[int, int]:
        """Step over a sequence of eight-byte numbers; return how many they are and where they begin."""
        at = self._at + -self._at % 4
        if at + 4 > self._size:
            raise ValueError("the message ends too early")
        count: int = _U32.unpack_from(self._data, at)[0]
        at += 4
        if count:
            at += -at % 8
        self._at = at + 8 * count
        if self._at > self._size:
            raise ValueError("the message ends too early")
        return count, at

    def f64_rows(self, rows: int) -> list[FloatArray]:
        """Read so many sequences of float64."""
        numbers = self._rows(rows, _FLOATS)
        return [self.f64s() for _ in range(rows)] if numbers is None else list(numbers)

    def i64_rows(self, rows: int) -> list[IntArray]:
        """Read so many sequences of int64."""
        numbers = self._rows(rows, _INTS)
        return [self.i64s() for _ in range(rows)] if numbers is None else list(numbers)

    def _rows(self, rows: int, kind: Any) -> Any:
        """Step over sequences of eight-byte numbers that are all of one length; None if they are not.

        In a message they are then the rows of a table, whose first column is their length.
        """
        at = self._at
        if at & 7 or at + 4 > self._size:
            return None
        count: int = _U32.unpack_from(self._data, at)[0]
        end = at + 8 * rows * (count + 1)
        if not count or end > self._size:
            return None
        table = np.frombuffer(self._data, _INTS, rows * (count + 1), at).reshape(rows, count + 1)
        if any(length & 0xFFFFFFFF != count for length in table[:, 0].tolist()):
            return None
        self._at = end
        return table.view(kind)[:, 1:]

    def i64_array(self, count: int) -> IntArray:
        """Read a fixed array of int64."""
        return np.frombuffer(self._data, _INTS, count, self._skip(8 * count, 8))

    def i64s(self) -> IntArray:
        """Read a sequence of int64."""
        count, begin = self._sequence()
        if not count:
            return np.zeros(0, dtype=np.int64)
        return np.frombuffer(self._data, _INTS, count, begin)

    def pass_numbers(self, count: int) -> None:
        """Step over so many numbers of eight bytes."""
        self._skip(8 * count, 8)

    def pass_sequence(self) -> None:
        """Step over a sequence of numbers of eight bytes."""
        self._sequence()

    def pass_flags(self, count: int) -> None:
        """Step over so many bools."""
        self._skip(count, 1)

    def flag_array(self, count: int) -> BoolArray:
        """Read a fixed array of bool."""
        flags: BoolArray = np.frombuffer(self._data, np.uint8, count, self._skip(count, 1)) != 0
        return flags

    def flags(self) -> BoolArray:
        """Read a sequence of bool."""
        return self.flag_array(self.u32())
