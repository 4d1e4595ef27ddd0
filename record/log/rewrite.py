"""Copying records of logs into a new log, without decoding what is in them; a damaged one made whole."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema

from model.errors import RecordError
from record.log.damage import Damage, Pass
from record.log.mcap_file import McapFile
from record.log.salvage import Content, read_records
from record.log.writer import LIBRARY
from record.whole_file import whole_file


class LogCopy:
    """A new log that is filled with records of others; made by ``log_copy``."""

    def __init__(self, writer: McapFile) -> None:
        self.messages = 0
        self._writer = writer
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._channels: dict[tuple[str, int], int] = {}
        self.begin_source()

    def begin_source(self) -> None:
        """Forget the numbers of schemas and channels: another file has its own."""
        self._schema_of: dict[int, int] = {}
        self._channel_of: dict[int, int] = {}

    def add(self, record: Content) -> None:
        """Write one record."""
        if isinstance(record, Message):
            self.messages += 1
            message = self._channel_of[record.channel_id], record.data
            self._writer.add_messages(
                record.log_time, (message,), record.sequence, record.publish_time
            )
        elif isinstance(record, Schema):
            self._add_schema(record)
        elif isinstance(record, Channel):
            self._add_channel(record)
        elif isinstance(record, Metadata):
            self._writer.add_metadata(record.name, record.metadata)
        elif isinstance(record, Attachment):
            self._writer.add_attachment(
                record.create_time, record.log_time, record.name, record.media_type, record.data
            )

    def _add_schema(self, record: Schema) -> None:
        key = (record.name, record.data)
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(
                record.name, record.encoding, record.data
            )
        self._schema_of[record.id] = self._schemas[key]

    def _add_channel(self, record: Channel) -> None:
        schema = self._schema_of[record.schema_id]
        key = (record.topic, schema)
        if key not in self._channels:
            self._channels[key] = self._writer.register_channel(
                record.topic, record.message_encoding, schema, record.metadata
            )
        self._channel_of[record.id] = self._channels[key]


@contextmanager
def log_copy(out: Path, inputs: tuple[Path, ...]) -> Iterator[LogCopy]:
    """Yield a new log; it appears under its name when the block is done.

    Args:
        out: The file to write.
        inputs: The files that are read meanwhile, which must not be overwritten.

    Raises:
        RecordError: The file cannot be written, or is one of the inputs.
    """
    if any(path.resolve() == out.resolve() for path in inputs):
        raise RecordError(f"{out} is the log itself; choose another file to write to")
    with whole_file(out) as part, part.open("wb") as file:
        writer = McapFile(file)
        writer.start(profile="ros2", library=LIBRARY)
        yield LogCopy(writer)
        writer.finish()


@dataclass(frozen=True, slots=True)
class Rewritten:
    """How a log was written from others.

    Attributes:
        kept: Number of messages in the new file.
        damages: What could not be read of the old ones.
    """

    kept: int
    damages: tuple[Damage, ...]


def repair(path: Path, out: Path, progress: Pass | None = None) -> Rewritten:
    """Copy what can be read of a log into a proper file.

    Args:
        path: The log, cut, damaged or whole.
        out: The file to write.
        progress: Filled on the way.

    Raises:
        RecordError: Nothing can be read, or the file cannot be written.
    """
    done = progress or Pass()
    with log_copy(out, inputs=(path,)) as copy:
        for record in read_records(path, done):
            copy.add(record)
        if copy.messages == 0:
            raise RecordError(f"nothing in {path} can be read")
    return Rewritten(copy.messages, tuple(done.damages))
