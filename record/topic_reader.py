"""Reading single topics of a log fast: chunks are opened, all other messages are stepped over.

A log holds twenty messages a tick and a replay needs one of them; unpacking the others into objects
would take a fifth of the time of the replay.
"""

import struct
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from io import SEEK_CUR, SEEK_END, BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata
from mcap.stream_reader import get_chunk_data_stream, read_magic

from model.errors import RecordError
from model.wire import WireBytes
from record.reader import DAMAGE, LogContents
from record.wire_message import WIRE_TOPICS, decode_wire
from record.writer import CONFIG_NAME, METADATA_NAME, TICK_TOPIC

_RECORD = struct.Struct("<BQ")  # opcode, length
_OPENED = frozenset({Opcode.CHUNK, Opcode.METADATA, Opcode.ATTACHMENT})
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time


@dataclass(frozen=True, slots=True)
class RawMessage:
    """One message as it lies in the file.

    Attributes:
        topic: Its topic.
        sequence: Number that the writer gave it.
        data: Its bytes.
    """

    topic: str
    sequence: int
    data: bytes


def read_topics(path: Path, topics: Collection[str], contents: LogContents) -> Iterator[RawMessage]:
    """Yield the messages of some topics in the order of the file; ends quietly where it is cut.

    Args:
        path: The log.
        topics: The topics wanted.
        contents: Filled with robot file, metadata and damage on the way.

    Raises:
        RecordError: The file cannot be opened.
    """
    channels: dict[int, str] = {}
    try:
        stream = path.open("rb")
    except OSError as error:
        raise RecordError(f"the log {path} cannot be read: {error.strerror}") from error
    with stream:
        try:
            for opcode, data in _file_records(stream):
                if opcode == Opcode.CHUNK:
                    yield from _from_chunk(Chunk.read(_stream_of(data)), channels, topics)
                elif opcode == Opcode.METADATA:
                    metadata = Metadata.read(_stream_of(data))
                    if metadata.name == METADATA_NAME:
                        contents.metadata = MappingProxyType(dict(metadata.metadata))
                elif opcode == Opcode.ATTACHMENT:
                    attachment = Attachment.read(_stream_of(data))
                    if attachment.name == CONFIG_NAME:
                        contents.config_text = attachment.data.decode("utf-8", errors="replace")
        except DAMAGE as error:
            contents.damage = f"cut or damaged: {type(error).__name__} {error}".strip()


def _file_records(stream: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Yield opcode and bytes of the records of a file, up to the end of its data."""
    size = stream.seek(0, SEEK_END)
    stream.seek(0)
    read_magic(ReadDataStream(stream))
    while True:
        head = stream.read(_RECORD.size)
        if len(head) < _RECORD.size:
            raise EOFError("the end is missing")
        opcode, length = _RECORD.unpack(head)
        if opcode == Opcode.DATA_END:
            return
        if length > size - stream.tell():
            raise EOFError("the end is missing")
        if opcode in _OPENED:
            yield opcode, stream.read(length)
        else:
            stream.seek(length, SEEK_CUR)


def _from_chunk(
    chunk: Chunk, channels: dict[int, str], topics: Collection[str]
) -> Iterator[RawMessage]:
    opened, size = get_chunk_data_stream(chunk, validate_crc=True)
    data = opened.read(size)
    at = 0
    while at < size:
        opcode, length = _RECORD.unpack_from(data, at)
        at += _RECORD.size
        if opcode == Opcode.MESSAGE:
            topic = channels.get(data[at] | data[at + 1] << 8)
            if topic is not None:
                _, sequence, _, _ = _MESSAGE.unpack_from(data, at)
                yield RawMessage(topic, sequence, data[at + _MESSAGE.size : at + length])
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(_stream_of(data[at : at + length]))
            if channel.topic in topics:
                channels[channel.id] = channel.topic
        at += length


def _stream_of(data: bytes) -> ReadDataStream:
    return ReadDataStream(BytesIO(data))


def read_tick_messages(path: Path, contents: LogContents) -> Iterator[bytes]:
    """Yield the ticks of a log as messages, in order; see ``read_topics``."""
    for message in read_topics(path, (TICK_TOPIC,), contents):
        yield message.data


def read_wires(path: Path, contents: LogContents) -> tuple[WireBytes, ...]:
    """Return the recorded traffic of both devices in the order in which it passed.

    Raises:
        RecordError: The file cannot be opened, or holds no traffic.
    """
    found = list(read_topics(path, WIRE_TOPICS, contents))
    if not found:
        raise RecordError(
            f"{path} holds no bytes of the devices; record them with: bigant drive --record-bytes"
        )
    found.sort(key=lambda message: message.sequence)
    return tuple(decode_wire(message.data) for message in found)
