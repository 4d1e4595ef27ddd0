"""Following a log that is still being written: its ticks as they reach the file, nothing locked or touched.

The writer flushes twice a second, and a chunk reaches the file when it is full or flushed, so ticks come in
bursts about half a second late. What is damaged ends it: a log to be mended is for ``record.salvage``.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import get_chunk_data_stream

from model.errors import RecordError
from model.signals import Tick
from record.reader import LogContents, note_content, tick_layout
from record.salvage import DAMAGE, FRAME, MAGIC, MESSAGE, SINGLE, split_records, stream_of
from record.tick_message import decode_tick
from record.topic_reader import TickMessage
from record.writer import TICK_TOPIC


class Follower:
    """Reads what has been added to a log since the last look.

    Args:
        path: The log.
        contents: Filled with robot file and metadata.

    Raises:
        RecordError: It cannot be opened.
    """

    def __init__(self, path: Path, contents: LogContents) -> None:
        self._path = path
        self._contents = contents
        try:
            self._file = path.open("rb")
        except OSError as error:
            raise RecordError(f"the log {path} cannot be read: {error.strerror}") from error
        self._place = 0
        self._schemas: dict[int, Schema] = {}
        self._layouts: dict[int, int] = {}
        self.finished = False

    def read(self) -> Iterator[TickMessage]:
        """Yield the ticks that are new.

        Raises:
            RecordError: The file is none of ours, or damaged.
        """
        if self._place == 0:
            head = self._read_at(0, len(MAGIC))
            if len(head) < len(MAGIC):
                return
            if head != MAGIC:
                raise RecordError(f"{self._path} is no log of ours: it does not begin like one")
            self._place = len(MAGIC)
        while not self.finished:
            head = self._read_at(self._place, FRAME.size)
            if len(head) < FRAME.size:
                return
            opcode, length = FRAME.unpack(head)
            data = self._read_at(self._place + FRAME.size, length)
            if len(data) < length:
                return  # the rest comes with the next flush
            self._place += FRAME.size + length
            try:
                yield from self._record(opcode, data)
            except DAMAGE as error:
                raise RecordError(
                    f"{self._path} is damaged at byte {self._place}: {error}; see bigant log repair"
                ) from error

    def _read_at(self, place: int, size: int) -> bytes:
        self._file.seek(place)
        return self._file.read(size)

    def _record(self, opcode: int, data: bytes) -> Iterator[TickMessage]:
        if opcode == Opcode.DATA_END:
            self.finished = True
        elif opcode == Opcode.CHUNK:
            chunk = Chunk.read(stream_of(data))
            for inner, piece in split_records(get_chunk_data_stream(chunk, validate_crc=True)[0]):
                yield from self._record(inner, piece)
        elif opcode == Opcode.MESSAGE:
            channel = MESSAGE.unpack_from(data)[0]
            if channel in self._layouts:
                yield TickMessage(data[MESSAGE.size :], self._layouts[channel])
        elif opcode in SINGLE:
            record = SINGLE[opcode](data)
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                if record.topic == TICK_TOPIC:
                    schema = self._schemas.get(record.schema_id)
                    self._layouts[record.id] = tick_layout(self._path, schema, self._contents)
            else:
                note_content(record, self._contents)

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()


def follow_ticks(path: Path, contents: LogContents, wait: Callable[[], bool]) -> Iterator[Tick]:
    """Yield the ticks of a log from its beginning, and those to come, until it is closed.

    Args:
        path: The log.
        contents: Filled with robot file and metadata.
        wait: Called when nothing is new; False ends it.

    Raises:
        RecordError: The file cannot be read.
    """
    follower = Follower(path, contents)
    try:
        while True:
            for message in follower.read():
                yield decode_tick(message.data, message.layout)
            if follower.finished or not wait():
                return
    finally:
        follower.close()
