"""An MCAP file in small compressed chunks, written as the mcap library writes one, byte for byte.

The library makes an object of every message and writes it number by number: of twenty messages a tick that
is half the price of the log. Here a message is one packing; all other records are the library's own.
Tests hold the bytes against the library's writer. Source: the MCAP format specification,
https://mcap.dev/spec.
"""

import struct
import zlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, BinaryIO, Protocol

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdCompressor

CHUNK_BYTES = 64 * 1024
COMPRESSION, LEVEL = "zstd", 3  # the library's level
# Opcode and length of a record; of a message with its channel, number and two times; of an index with its
# channel and length.
_RECORD, _MESSAGE, _INDEX = struct.Struct("<BQ"), struct.Struct("<BQHIQQ"), struct.Struct("<BQHI")
_RECORD_BYTES = _RECORD.size
_MESSAGE_OPCODE, _INDEX_OPCODE = int(Opcode.MESSAGE), int(Opcode.MESSAGE_INDEX)


class _Record(Protocol):
    def write(self, stream: RecordBuilder) -> Any:
        """Write the record."""


def _bytes(*records: _Record) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


class McapFile:
    """Writes one file, with a checksum over the whole besides those of the chunks.

    Args:
        stream: Where it goes, from its present place on.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self._at = stream.tell()
        self._crc = 0
        self._zstd = ZstdCompressor(level=LEVEL)
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}  # messages of each channel
        self._times: tuple[int, int] | None = None  # of the first and the last message
        self._open: list[bytes] = []  # records of the open chunk
        self._size = 0  # their bytes
        self._index: dict[int, list[int]] = {}  # by channel: time and place of each message in it

    def start(self, profile: str, library: str) -> None:
        """Write the beginning."""
        self._put(MCAP0_MAGIC + _bytes(Header(profile, library)))

    def register_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Write a schema; return its number."""
        schema = Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name)
        self._schemas.append(schema)
        self._add(_bytes(schema))
        return schema.id

    def register_channel(
        self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]
    ) -> int:
        """Write a channel of messages; return its number."""
        channel = Channel(
            id=len(self._channels) + 1,
            topic=topic,
            message_encoding=encoding,
            schema_id=schema,
            metadata=dict(metadata),
        )
        self._channels.append(channel)
        self._add(_bytes(channel))
        return channel.id

    def _add(self, record: bytes) -> None:
        """Take a record into the open chunk."""
        self._open.append(record)
        self._size += len(record)
        if self._size > CHUNK_BYTES:
            self._end_chunk()

    def add_messages(
        self,
        log_ns: int,
        messages: Iterable[tuple[int, bytes]],
        sequence: int,
        publish_ns: int | None = None,
    ) -> None:
        """Write messages of one moment: channel and bytes of each.

        Args:
            log_ns: When they were recorded [ns].
            messages: The messages.
            sequence: Number of all of them.
            publish_ns: When they were sent, None for the same time [ns].
        """
        sent_ns = log_ns if publish_ns is None else publish_ns
        pack, place = _MESSAGE.pack, self._size
        pieces, index = self._open, self._index
        for channel, data in messages:
            size = 22 + len(data)
            pieces += (pack(_MESSAGE_OPCODE, size, channel, sequence, log_ns, sent_ns), data)
            entries = index.get(channel)
            if entries is None:
                index[channel] = [log_ns, place]
            else:
                entries += (log_ns, place)
            place += _RECORD_BYTES + size
            if place > CHUNK_BYTES:
                self._size = place
                self._end_chunk()
                place, pieces, index = self._size, self._open, self._index
        self._size = place

    def add_metadata(self, name: str, data: Mapping[str, str]) -> None:
        """Write texts by name."""
        record = _bytes(Metadata(name=name, metadata=dict(data)))
        self._metadata.append(MetadataIndex(offset=self._at, length=len(record), name=name))
        self._put(record)

    def add_attachment(
        self, create_ns: int, log_ns: int, name: str, media_type: str, data: bytes
    ) -> None:
        """Write a file."""
        record = _bytes(
            Attachment(
                create_time=create_ns, log_time=log_ns, name=name, media_type=media_type, data=data
            )
        )
        self._attachments.append(AttachmentIndex(
            offset=self._at, length=len(record), create_time=create_ns, log_time=log_ns,
            data_size=len(data), name=name, media_type=media_type,
        ))  # fmt: skip
        self._put(record)

    def _put(self, data: bytes) -> None:
        self._crc = zlib.crc32(data, self._crc)
        self._stream.write(data)
        self._at += len(data)

    def _end_chunk(self) -> None:
        """Write the open chunk and where its messages lie, if it has any."""
        if not self._index:
            return
        begin, end = self._chunk_times()
        raw = b"".join(self._open)
        data = self._zstd.compress(raw)
        chunk = _bytes(Chunk(
            compression=COMPRESSION, data=data, message_start_time=begin, message_end_time=end,
            uncompressed_crc=zlib.crc32(raw), uncompressed_size=len(raw),
        ))  # fmt: skip
        index, place = [], self._at + len(chunk)
        places: dict[int, int] = {}
        for channel, entries in self._index.items():
            size = 8 * len(entries)
            index.append(_INDEX.pack(_INDEX_OPCODE, 6 + size, channel, size))
            index.append(struct.pack(f"<{len(entries)}Q", *entries))
            places[channel] = place
            place += _INDEX.size + size
            self._counts[channel] = self._counts.get(channel, 0) + len(entries) // 2
        self._chunks.append(ChunkIndex(
            message_start_time=begin, message_end_time=end, chunk_start_offset=self._at,
            chunk_length=len(chunk), message_index_offsets=places,
            message_index_length=place - self._at - len(chunk), compression=COMPRESSION,
            compressed_size=len(data), uncompressed_size=len(raw),
        ))  # fmt: skip
        self._put(chunk + b"".join(index))
        self._open, self._size, self._index = [], 0, {}

    def _chunk_times(self) -> tuple[int, int]:
        """Return the times of the first and the last message of the open chunk; note them for the file."""
        begin = min(min(entries[::2]) for entries in self._index.values())
        end = max(max(entries[::2]) for entries in self._index.values())
        first, last = self._times or (begin, end)
        self._times = min(first, begin), max(last, end)
        return begin, end

    def flush(self) -> None:
        """End the open chunk, and let everything go to the file."""
        self._end_chunk()
        self._stream.flush()

    def finish(self) -> None:
        """Write the end: all schemas and channels again, counts, and where everything lies."""
        self._end_chunk()
        self._put(_bytes(DataEnd(self._crc)))
        groups: tuple[tuple[Opcode, Sequence[_Record]], ...] = (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, (self._statistics(),)),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.ATTACHMENT_INDEX, self._attachments),
            (Opcode.METADATA_INDEX, self._metadata),
        )
        summary, offsets = b"", []
        for opcode, records in groups:
            group, start = _bytes(*records), self._at + len(summary)
            offsets.append(
                SummaryOffset(group_opcode=opcode, group_start=start, group_length=len(group))
            )
            summary += group
        place = self._at, self._at + len(summary)
        summary += _bytes(*offsets)
        # the checksum of the summary goes on to the footer's two offsets
        footer = struct.pack("<BQQQ", Opcode.FOOTER, 8 + 8 + 4, *place)
        crc = zlib.crc32(footer, zlib.crc32(summary))
        end = Footer(summary_start=place[0], summary_offset_start=place[1], summary_crc=crc)
        self._stream.write(summary + _bytes(end) + MCAP0_MAGIC)

    def _statistics(self) -> Statistics:
        begin, end = self._times or (0, 0)
        return Statistics(
            attachment_count=len(self._attachments), channel_count=len(self._channels),
            channel_message_counts=self._counts, chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()), metadata_count=len(self._metadata),
            message_start_time=begin, message_end_time=end, schema_count=len(self._schemas),
        )  # fmt: skip
