"""The records of an MCAP file, in file order, past whatever is damaged.

A record is an opcode, a length and that many bytes, so a chunk whose content is broken can be stepped over:
it alone is lost. Where the framing itself is broken the index at the end of the file, if it is there, tells
where the next chunk begins; a file without one (cut, killed) is read up to that place. Our own because the
library's reader stops at the first broken byte, and because decoding all twenty topics to look at one costs
six times as much.
"""

import struct
import zlib
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Message, Metadata, Schema
from mcap.stream_reader import get_chunk_data_stream
from zstandard import ZstdError

from model.errors import RecordError
from record.input_file import open_file
from record.log.damage import Damage, Pass
from record.log.framing.chunk import FRAME, MESSAGE, MESSAGE_HEAD, believable_span, split_chunk
from record.log.framing.file_index import read_index

# What reading a damaged byte raises, by way of mcap, zstd, lz4 and our own decoder.
DAMAGE = (
    McapError, ValueError, EOFError, OSError, MemoryError, KeyError, OverflowError, RuntimeError,
    struct.error, ZstdError,
)  # fmt: skip
MAGIC = b"\x89MCAP0\r\n"
LARGEST_CHUNK = 1 << 30  # uncompressed; a larger one is a broken length
DATA_END_BYTES = 4

Content = Schema | Channel | Message | Metadata | Attachment


def read_records(
    path: Path,
    progress: Pass,
    topics: Collection[str] | None = None,
    span: tuple[int, int] | None = None,
) -> Iterator[Content]:
    """Yield schemas, channels, messages, metadata and attachments, stepping over damage.

    Args:
        path: The file.
        progress: Filled on the way.
        topics: Only messages of these topics; None for all.
        span: Where the first record and the first one left out begin, in bytes, of a file with an index;
            None for all.

    Raises:
        RecordError: The file cannot be opened.
    """
    try:
        stream = open_file(path)
    except OSError as error:
        raise RecordError(f"the log {path} cannot be read: {error.strerror}") from error
    with stream:
        try:
            yield from _Salvage(stream, progress, topics).records(span)
        except IsADirectoryError as error:
            raise RecordError(f"the log {path} cannot be read: {error.strerror}") from error


class _Salvage:
    """One pass over one file."""

    def __init__(self, stream: BinaryIO, progress: Pass, topics: Collection[str] | None) -> None:
        self._stream = stream
        self._progress = progress
        self._topics = topics
        self._wanted: dict[int, bool] = {}  # channel id to whether its messages are asked for
        self._schemas: set[int] = set()
        self._chunks: list[int] = []  # where chunks begin, as far as the index knows
        self._last_ns = -1
        self._crc = 0
        self._open_ended = False  # the last damage still waits for the message behind it
        progress.size = stream.seek(0, 2)

    def records(self, span: tuple[int, int] | None) -> Iterator[Content]:
        yield from self._index()
        self._stream.seek(0)
        if self._stream.read(len(MAGIC)) != MAGIC:
            self._lost(0, 0, "it does not begin like an MCAP file")
            return
        self._crc = zlib.crc32(MAGIC)
        end = None
        if span is not None:
            begin, end = span
            self._stream.seek(begin)
        while not self._progress.finished:
            offset = self._stream.tell()
            if offset == end:
                return
            self._progress.position = offset
            self._progress.tell()
            head = self._stream.read(FRAME.size)
            if len(head) < FRAME.size:
                self._lost(offset, 0, "the file ends early")
                return
            opcode, length = FRAME.unpack(head)
            known = opcode in _OPCODES and (opcode != Opcode.DATA_END or length == DATA_END_BYTES)
            if not known or length > self._progress.size - offset - FRAME.size:
                cut = known and offset > self._last_chunk()
                reason = "the file ends early" if cut else "the framing of records is broken"
                if not self._resynchronise(offset, reason):
                    return
                continue
            data = self._stream.read(length)
            if opcode != Opcode.DATA_END:
                self._crc = zlib.crc32(data, zlib.crc32(head, self._crc))
            yield from self._record(opcode, data, offset)
        self._progress.position = self._progress.size

    def _last_chunk(self) -> int:
        return self._chunks[-1] if self._chunks else -1

    def _index(self) -> Iterator[Content]:
        """Read the index at the end, if there is a sound one: it knows channels and chunks."""
        try:
            index = read_index(self._stream)
        except DAMAGE:
            return
        if index is None:
            return
        self._chunks = [chunk.begin for chunk in index.chunks]
        for schema in index.schemas:
            yield from self._once(schema)
        for channel in index.channels:
            yield from self._once(channel)

    def _once(self, record: Schema | Channel) -> Iterator[Content]:
        if isinstance(record, Schema):
            new = record.id not in self._schemas
            self._schemas.add(record.id)
        else:
            new = record.id not in self._wanted
            self._wanted[record.id] = self._topics is None or record.topic in self._topics
        if new:
            yield record

    def _resynchronise(self, offset: int, reason: str) -> bool:
        """Go to the next chunk that the index knows; return whether there is one."""
        following = [chunk for chunk in self._chunks if chunk > offset]
        self._lost(offset, following[0] - offset if following else 0, reason)
        if following:
            self._stream.seek(following[0])
        return bool(following)

    def _lost(
        self, offset: int, size: int, reason: str, span: tuple[int, int] | None = None
    ) -> None:
        from_ns, to_ns = span if span is not None else (self._last_ns, -1)
        self._progress.damages.append(Damage(offset, size, from_ns, to_ns, reason))
        self._open_ended = to_ns < 0 <= from_ns

    def _record(self, opcode: int, data: bytes, offset: int) -> Iterator[Content]:
        if opcode == Opcode.CHUNK:
            yield from self._chunk(data, offset)
        elif opcode in _SINGLE:
            try:
                record = _SINGLE[opcode](data)
            except DAMAGE as error:
                name = Opcode(opcode).name.lower()
                self._lost(offset, len(data) + FRAME.size, f"a broken {name}: {_words(error)}")
                return
            if isinstance(record, Schema | Channel):
                yield from self._once(record)
            else:
                yield record
        elif opcode == Opcode.MESSAGE:  # a file without chunks
            yield from self._message(data, 0, len(data))
        elif opcode == Opcode.DATA_END:
            self._end(data, offset)

    def _end(self, data: bytes, offset: int) -> None:
        """The end of the data: everything behind it is index. Its checksum covers what chunks do not."""
        self._progress.finished = True
        try:
            expected = DataEnd.read(_stream_of(data)).data_section_crc
        except DAMAGE:
            expected = 0
        if expected not in {0, self._crc} and not self._progress.damages:
            reason = "the checksum of the whole does not fit, those of all chunks do"
            self._progress.damages.append(Damage(offset, 0, -1, -1, reason, content=False))

    def _chunk(self, data: bytes, offset: int) -> Iterator[Content]:
        span = (self._last_ns, -1)
        try:
            chunk = Chunk.read(_stream_of(data))
            span = believable_span(chunk, self._last_ns)
            if chunk.uncompressed_size > LARGEST_CHUNK:
                raise ValueError(f"it claims {chunk.uncompressed_size} bytes")
            content = get_chunk_data_stream(chunk, validate_crc=True)[0].read(1 << 62)
            records, passed = split_chunk(content, self._unwanted())
        except DAMAGE as error:
            self._lost(offset, len(data) + FRAME.size, f"a broken chunk: {_words(error)}", span)
            return
        for opcode, at, end in records:
            if opcode == MESSAGE:
                yield from self._message(content, at, end)
            elif opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
                record = _SINGLE[opcode](content[at:end])
                if isinstance(record, Schema | Channel):
                    yield from self._once(record)
        if passed >= 0:
            self._last_ns = MESSAGE_HEAD.unpack_from(content, passed)[2]

    def _unwanted(self) -> frozenset[int]:
        """Channels whose messages may be passed by; none while damage waits for the message behind it."""
        if self._open_ended:
            return frozenset()
        return frozenset(number for number, wanted in self._wanted.items() if not wanted)

    def _message(self, data: bytes, at: int, end: int) -> Iterator[Content]:
        channel, sequence, log_ns, publish_ns = MESSAGE_HEAD.unpack_from(data, at)
        self._last_ns = log_ns
        if self._open_ended:
            damages = self._progress.damages
            damages[-1] = replace(damages[-1], to_ns=log_ns)
            self._open_ended = False
        if channel not in self._wanted:
            self._no_channel(log_ns)
        elif self._wanted[channel]:
            yield Message(
                channel_id=channel,
                log_time=log_ns,
                publish_time=publish_ns,
                sequence=sequence,
                data=data[at + MESSAGE_HEAD.size : end],
            )

    def _no_channel(self, log_ns: int) -> None:
        """Its channel was in a broken chunk, and there is no index to know it from."""
        reason = "messages whose channel was lost in a broken chunk"
        damages = self._progress.damages
        if damages and damages[-1].reason == reason:
            damages[-1] = replace(damages[-1], to_ns=log_ns)
        else:
            self._lost(self._progress.position, 0, reason, (log_ns, log_ns))


def _stream_of(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


def _attachment(data: bytes) -> Attachment:
    (expected,) = struct.unpack("<I", data[-4:])
    if expected not in {0, zlib.crc32(data[:-4])}:
        raise ValueError("its checksum does not fit")
    attachment: Attachment = Attachment.read(_stream_of(data))
    return attachment


_OPCODES = frozenset(int(opcode) for opcode in Opcode)
_SINGLE: dict[int, Callable[[bytes], Content]] = {
    Opcode.SCHEMA: lambda data: Schema.read(_stream_of(data)),
    Opcode.CHANNEL: lambda data: Channel.read(_stream_of(data)),
    Opcode.METADATA: lambda data: Metadata.read(_stream_of(data)),
    Opcode.ATTACHMENT: _attachment,
}


def _words(error: Exception) -> str:
    return f"{error}" or type(error).__name__
