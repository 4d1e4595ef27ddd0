"""The index at the end of an MCAP file: its channels, and where its chunks lie.

The mcap library reads it number by number: a third of a second for a log of five minutes, and a log in
stretches is opened two dozen times. Here a chunk's entry is two packings, and an index that was read is
known again by its bytes. Only an index that is sound in every byte is read here; the library judges all
others. Source: the MCAP format specification, https://mcap.dev/spec.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from types import MappingProxyType
from typing import Any, BinaryIO

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import (
    AttachmentIndex,
    Channel,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC

_RECORD = struct.Struct("<BQ")
_FOOTER = struct.Struct("<BQQQI")
# Of a chunk's entry: opcode, length, two times, where it begins and its length, bytes of the table of its
# channels; behind that table, the length of its message indexes and of the name of its compression; behind
# that name, two sizes.
_CHUNK, _BEHIND, _SIZES = struct.Struct("<BQQQQQI"), struct.Struct("<QI"), 16
_CHANNEL = struct.Struct("<HQ")
_CHUNK_INDEX, _END = int(Opcode.CHUNK_INDEX), int(Opcode.FOOTER)
_OTHERS: Mapping[int, Any] = MappingProxyType({
    int(Opcode.SCHEMA): Schema, int(Opcode.CHANNEL): Channel, int(Opcode.STATISTICS): Statistics,
    int(Opcode.ATTACHMENT_INDEX): AttachmentIndex, int(Opcode.METADATA_INDEX): MetadataIndex,
    int(Opcode.SUMMARY_OFFSET): SummaryOffset,
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class ChunkPlace:
    """Where a chunk lies.

    Attributes:
        begin: Its first byte.
        end: The first one behind it and its message indexes.
        channels: Numbers of the channels that it has messages of.
    """

    begin: int
    end: int
    channels: frozenset[int]


@dataclass(frozen=True, slots=True)
class FileIndex:
    """What the index says.

    Attributes:
        schemas: Types of messages.
        channels: Channels.
        chunks: In file order.
    """

    schemas: tuple[Schema, ...]
    channels: tuple[Channel, ...]
    chunks: tuple[ChunkPlace, ...]


def read_index(stream: BinaryIO) -> FileIndex | None:
    """Read the index of a file; None if it has none.

    Raises:
        Exception: It is broken: one of ``record.log.salvage.DAMAGE``.
    """
    size = stream.seek(0, 2)
    tail = _FOOTER.size + len(MCAP0_MAGIC)
    if size >= tail:
        stream.seek(size - tail)
        opcode, length, begin, _, _ = _FOOTER.unpack(stream.read(_FOOTER.size))
        if (opcode, length) == (_END, _FOOTER.size - _RECORD.size) and 0 < begin <= size - tail:
            stream.seek(begin)
            data = stream.read(size - begin)
            index = _sound_index(data) if data.endswith(MCAP0_MAGIC) else None
            if index is not None:
                return index
    return _by_the_library(stream)


def _by_the_library(stream: BinaryIO) -> FileIndex | None:
    stream.seek(0)
    read = SeekingReader(stream).get_summary()
    if read is None:
        return None
    places = [
        ChunkPlace(
            one.chunk_start_offset,
            one.chunk_start_offset + one.chunk_length + one.message_index_length,
            frozenset(one.message_index_offsets),
        )
        for one in read.chunk_indexes
    ]
    return _index(read.schemas, read.channels, places)


def _index(
    schemas: Mapping[int, Schema], channels: Mapping[int, Channel], chunks: list[ChunkPlace]
) -> FileIndex:
    in_order = sorted(chunks, key=lambda chunk: chunk.begin)
    return FileIndex(tuple(schemas.values()), tuple(channels.values()), tuple(in_order))


@lru_cache(maxsize=1)
def _sound_index(data: bytes) -> FileIndex | None:
    """Take an index apart, with footer and end of the file; None if anything about it is unusual."""
    end, at = len(data) - _FOOTER.size - len(MCAP0_MAGIC), 0
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    chunks: list[ChunkPlace] = []
    sets: dict[frozenset[int], frozenset[int]] = {}  # nearly all chunks have the same channels
    while at < end:
        opcode, length = _RECORD.unpack_from(data, at)
        behind = at + _RECORD.size + length
        if behind > end:
            return None
        if opcode == _CHUNK_INDEX:
            place = _chunk_place(data, at, behind)
            if place is None:
                return None
            own = sets.setdefault(place.channels, place.channels)
            chunks.append(ChunkPlace(place.begin, place.end, own))
        elif opcode not in _OTHERS:
            return None
        else:
            record = _as_written(_OTHERS[opcode], data[at:behind])
            if record is None:
                return None
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
        at = behind
    return _index(schemas, channels, chunks)


def _chunk_place(data: bytes, at: int, behind: int) -> ChunkPlace | None:
    """Read a chunk's entry; None unless its lengths are those of a chunk's entry."""
    if behind - at < _CHUNK.size + _BEHIND.size + _SIZES:
        return None
    _, _, _, _, begin, length, table = _CHUNK.unpack_from(data, at)
    first = at + _CHUNK.size
    last = first + table
    if table % _CHANNEL.size or last + _BEHIND.size + _SIZES > behind:
        return None
    indexes, name = _BEHIND.unpack_from(data, last)
    last += _BEHIND.size
    if last + name + _SIZES != behind or not data[last : last + name].isascii():
        return None
    own = frozenset(number for number, _ in _CHANNEL.iter_unpack(data[first : first + table]))
    return ChunkPlace(begin, begin + length + indexes, own)


def _as_written(kind: Any, data: bytes) -> Any:
    """Read a record by the library; None unless it writes the same bytes again."""
    try:
        record = kind.read(ReadDataStream(BytesIO(data[_RECORD.size :])))
        builder = RecordBuilder()
        record.write(builder)
        again: Any = builder.end()  # type: ignore[no-untyped-call]
    except (McapError, ValueError, OverflowError, MemoryError, struct.error):  # the library says so
        return None
    return record if again == data else None
