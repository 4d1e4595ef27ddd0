"""CDR, the byte format of ROS 2 messages: a writer and a reader of just what our messages need.

Our own because the log is written between two ticks: a tick is encoded in 34 us, by rosbags in 107 from
a message that is made already; decoded in 147 us to a tick, by rosbags in 123 to its message (medians of
200 rounds in turn). Tests hold the bytes against two independent decoders. Little endian, plain CDR
(XCDR1): every value aligned to its own size behind the four-byte header. Source: OMG CORBA/IIOP "CDR
transfer syntax", DDS-RTPS encapsulation.
"""

import struct
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

HEADER = b"\x00\x01\x00\x00"
_U32 = struct.Struct("<I")
# made once: numpy would take the text apart at every call
FLOATS, INTS, BOOLS = np.dtype("<f8"), np.dtype("<i8"), np.dtype(np.bool_)
# length of a sequence and the gap behind it, for the lengths that occur
_COUNTS = tuple(struct.pack("<I4x", count) for count in range(256))
_PADDING = (b"", b"\0", b"\0\0", b"\0\0\0", b"\0" * 4, b"\0" * 5, b"\0" * 6, b"\0" * 7)


class _Packings(dict[str, tuple[struct.Struct, ...]]):
    """Numbers of different sizes (``struct``'s letters), each with its gap before it, from any place on."""

    def __missing__(self, kinds: str) -> tuple[struct.Struct, ...]:
        self[kinds] = tuple(_packing(kinds, place) for place in range(8))
        return self[kinds]


def _packing(kinds: str, place: int) -> struct.Struct:
    codes = []
    for kind in kinds:
        size = struct.calcsize("<" + kind)
        gap = -place % size
        codes.append(f"{gap}x{kind}")
        place += gap + size
    return struct.Struct("<" + "".join(codes))


_PACKINGS = _Packings()


@lru_cache(maxsize=256)
def text_bytes(value: str) -> bytes:
    """A string: length with its closing zero, then the bytes. Most texts of a tick were in the last one."""
    data = value.encode("utf-8") + b"\0"
    return _U32.pack(len(data)) + data


class CdrWriter:
    """Builds one message.

    Args:
        at: Place in a message that has been begun elsewhere, to build only what follows; alignment
            counts from the message's beginning.
    """

    def __init__(self, at: int = 0) -> None:
        self._parts: list[bytes] = [] if at else [HEADER]
        self._size = at  # without the header, which alignment does not count

    def raw(self, data: bytes, alignment: int) -> None:
        """Write bytes made beforehand, which begin at an alignment."""
        gap = -self._size % alignment
        if gap:
            self._parts.append(_PADDING[gap])
        self._parts.append(data)
        self._size += gap + len(data)

    def record(self, kinds: str, *values: float) -> None:
        """Write numbers of different kinds, ``struct``'s letters: ``?`` bool, ``q`` int64, ..."""
        packed = _PACKINGS[kinds][self._size & 7]
        self._parts.append(packed.pack(*values))
        self._size += packed.size

    def octets(self, data: bytes) -> None:
        """Write a sequence of bytes; its length alone is the count of any sequence."""
        self.raw(_U32.pack(len(data)) + data, 4)

    def count(self, value: int) -> None:
        """Write a uint32: the length of a sequence."""
        self.raw(_U32.pack(value), 4)

    def texts(self, *values: str) -> None:
        """Write strings."""
        for value in values:
            self.raw(text_bytes(value), 4)

    def arrays(self, kind: np.dtype[Any], *arrays: NDArray[Any]) -> None:
        """Write fixed arrays of ``FLOATS``, ``INTS`` or ``BOOLS``, any shape, row by row."""
        for values in arrays:
            if values.dtype is not kind:  # asking costs less than a cast that changes nothing
                values = values.astype(kind)
            self.raw(values.tobytes(), kind.itemsize)  # numpy keeps a bool in a byte that is 0 or 1

    def sequences(self, kind: np.dtype[Any], *rows: NDArray[Any]) -> None:
        """Write sequences of ``FLOATS``, ``INTS`` or ``BOOLS``, one behind the other."""
        add, counts = self._parts.append, len(_COUNTS)
        for values in rows:
            data = values.tobytes() if values.dtype is kind else values.astype(kind).tobytes()
            if kind is BOOLS:
                self.octets(data)
                continue
            count = len(data) >> 3
            if not self._size & 7 and 0 < count < counts:
                add(_COUNTS[count])
                add(data)
                self._size += 8 + len(data)
            else:
                self.count(count)
                if data:
                    self.raw(data, 8)

    def done(self) -> bytes:
        """Return the message."""
        return b"".join(self._parts)


class CdrReader:
    """Takes one message apart, in the order in which it was written.

    Args:
        data: The message.

    Attributes:
        at: Bytes read so far, without the header; may be set to where it once was.

    Raises:
        ValueError: It is no little-endian CDR, or ends too early (from any method).
    """

    def __init__(self, data: bytes) -> None:
        if data[:2] != HEADER[:2]:
            raise ValueError("not little-endian CDR")
        # a copy, four bytes further down: numbers of eight bytes then lie where a processor likes them
        self._data = data[len(HEADER) :]
        self._size = len(self._data)
        self.at = 0

    def skip(self, size: int, alignment: int) -> int:
        """Step over the next so many bytes; return where they begin."""
        begin = self.at + -self.at % alignment
        self.at = begin + size
        if self.at > self._size:
            raise ValueError("the message ends too early")
        return begin

    def skip_sequences(self, item_bytes: int, rows: int) -> None:
        """Step over so many sequences of numbers."""
        for _ in range(rows):
            count = self.count()
            if count:
                self.skip(count * item_bytes, item_bytes)

    def record(self, kinds: str) -> tuple[Any, ...]:
        """Read numbers of different kinds, ``struct``'s letters, at once."""
        packed = _PACKINGS[kinds][self.at & 7]
        return packed.unpack_from(self._data, self.skip(packed.size, 1))

    def count(self) -> int:
        """Read the length of a sequence."""
        value: int = _U32.unpack_from(self._data, self.skip(4, 4))[0]
        return value

    def octets(self) -> bytes:
        """Read a sequence of bytes."""
        count = self.count()
        begin = self.skip(count, 1)
        return self._data[begin : begin + count]

    def texts(self, count: int) -> list[str]:
        """Read so many strings."""
        return [self.octets()[:-1].decode("utf-8") for _ in range(count)]

    def array(self, kind: np.dtype[Any], size: int) -> NDArray[Any]:
        """Read a fixed array of ``FLOATS``, ``INTS`` or ``BOOLS``."""
        if kind is BOOLS:  # of a damaged byte the same as of 1
            flags: NDArray[Any] = np.frombuffer(self._data, np.uint8, size, self.skip(size, 1)) != 0
            return flags
        return np.frombuffer(self._data, kind, size, self.skip(8 * size, 8))

    def sequence(self, kind: np.dtype[Any]) -> NDArray[Any]:
        """Read a sequence of ``FLOATS``, ``INTS`` or ``BOOLS``."""
        count = self.count()
        return self.array(kind, count) if count else np.zeros(0, kind)

    def arrays(self, kind: np.dtype[Any], *sizes: int) -> list[NDArray[Any]]:
        """Read fixed arrays."""
        return [self.array(kind, size) for size in sizes]

    def sequences(self, kind: np.dtype[Any], rows: int) -> list[NDArray[Any]]:
        """Read so many sequences."""
        table = self._table(rows) if rows > 1 and kind is not BOOLS else None
        return [self.sequence(kind) for _ in range(rows)] if table is None else [*table.view(kind)]

    def _table(self, rows: int) -> NDArray[np.int64] | None:
        """Step over sequences of eight-byte numbers that are all of one length; None if they are not.

        In a message they are then the rows of a table, whose first column is their length.
        """
        at = self.at
        if at & 7 or at + 4 > self._size:
            return None
        count: int = _U32.unpack_from(self._data, at)[0]
        end = at + 8 * rows * (count + 1)
        if not count or end > self._size:
            return None
        table = np.frombuffer(self._data, INTS, rows * (count + 1), at).reshape(rows, count + 1)
        if any(length & 0xFFFFFFFF != count for length in table[:, 0].tolist()):
            return None
        self.at = end
        return table[:, 1:]
