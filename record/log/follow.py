"""Reading a log while another process writes it.

A writer's chunk is complete in the file at most half a second after its last tick (see
``record.log.writer``). A follower reads what has become complete since its last look and nothing else, so
it costs the writer nothing: no socket, no lock, no thread in the control process.
"""

import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, Self

from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.stream_reader import StreamReader

from model.errors import RecordError
from record.input_file import open_file
from record.log.reader import (
    LogContents,
    MessageReader,
    StampedTick,
    TopicMessage,
    check_layout,
    sound,
)
from record.log.salvage import DAMAGE, LARGEST_CHUNK, MAGIC
from record.log.tick_message import decode_tick
from record.log.writer import LIBRARY
from record.topics import TICK_TOPIC

_FRAME, _LENGTH = struct.Struct("<BQ"), struct.Struct("<I")
MOST_HEADER = 256  # bytes of an MCAP header: profile and library
# Read in pieces, so that catching up with an hour's log does not need an hour's memory.
MOST_BYTES = 4 << 20
# The library's reader wants an end; a piece of a growing file gets one of its own.
_END = _FRAME.pack(Opcode.FOOTER, 20) + bytes(20) + MAGIC


def is_log_of_run(path: Path) -> bool:
    """Whether a file is a log of a run, or one that is just being begun: by its header, not its name.

    A viewer's file or odometry as MCAP is none.
    """
    try:
        with open_file(path) as file:
            begin = file.read(len(MAGIC) + _FRAME.size + MOST_HEADER)
    except OSError:
        return False
    at = len(MAGIC) + _FRAME.size + _LENGTH.size
    if len(begin) < at:
        return MAGIC.startswith(begin[: len(MAGIC)])
    library = begin[at + _LENGTH.unpack_from(begin, at - _LENGTH.size)[0] :]
    return library.startswith(_LENGTH.pack(len(LIBRARY)) + LIBRARY.encode())


class LogFollower:
    """Yields what is new in a log each time it is asked.

    Args:
        path: The log; it must exist, and may be growing.

    Raises:
        RecordError: It cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.contents = LogContents()
        self.finished = False
        self._reader = MessageReader(self.contents)
        self._at = 0
        try:
            self._file: BinaryIO = open_file(path)
        except OSError as error:
            raise RecordError(f"the log {path} cannot be read: {error.strerror}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def new_messages(self) -> Iterator[TopicMessage]:
        """Yield the messages that have become complete since the last call, in file order.

        Raises:
            RecordError: What is in the file is no log, or is damaged.
        """
        while piece := self._complete_records():
            try:
                yield from self._reader.messages(_records(piece))
            except (McapError, *DAMAGE) as error:
                raise RecordError(
                    f"{self.path} is damaged near byte {self._at} ({error}); "
                    "what is left: bigant log repair"
                ) from error

    def new_ticks(self) -> Iterator[StampedTick]:
        """Yield the ticks that have become complete since the last call.

        Raises:
            RecordError: As ``new_messages``; or the ticks' layout is not known.
        """
        for message in self.new_messages():
            if message.topic == TICK_TOPIC:
                yield self.decode(message)

    def decode(self, message: TopicMessage) -> StampedTick:
        """Decode a message of the tick topic.

        Raises:
            RecordError: The ticks' layout is not known, or the tick is damaged.
        """
        check_layout(self.path, message, self.contents)
        with sound(self.path, message):
            return StampedTick(message.unix_ns, decode_tick(message.data, message.layout))

    def _complete_records(self) -> bytes:
        """Return the complete records behind the last one that was read, b"" if there is none yet."""
        if self.finished:
            return b""
        if self._at == 0:
            self._file.seek(0)
            head = self._file.read(len(MAGIC))
            if len(head) < len(MAGIC):
                return b""
            if head != MAGIC:
                raise RecordError(f"{self.path} does not begin like an MCAP file; is it a log?")
            self._at = len(MAGIC)
        size = self._file.seek(0, 2)
        begin = end = self._at
        while end - begin < MOST_BYTES and end + _FRAME.size <= size:
            self._file.seek(end)
            opcode, length = _FRAME.unpack(self._file.read(_FRAME.size))
            if length > LARGEST_CHUNK:
                raise RecordError(
                    f"{self.path} is damaged at byte {end}; what is left: bigant log repair"
                )
            if opcode == Opcode.DATA_END:
                self.finished = True
                break
            if end + _FRAME.size + length > size:
                break
            end += _FRAME.size + length
        self._file.seek(begin)
        self._at = end
        return self._file.read(end - begin)


def _records(piece: bytes) -> Iterator[object]:
    reader = StreamReader(BytesIO(piece + _END), skip_magic=True, validate_crcs=True)
    yield from reader.records
