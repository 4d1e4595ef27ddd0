"""Copying records of logs into a new log, without decoding what is in them."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from mcap.records import Attachment, Channel, Message, Metadata, Schema

from model.errors import RecordError
from record.log.damage import Damage, Pass
from record.log.salvage import Content, read_records
from record.log.writer import LIBRARY, mcap_writer, open_log_file
from record.whole_file import whole_file, writing


@dataclass(frozen=True, slots=True)
class Rewritten:
    """How a log was written from others.

    Attributes:
        kept: Number of messages in the new file.
        damages: What could not be read of the old ones.
    """

    kept: int
    damages: tuple[Damage, ...]


class LogCopy:
    """A new log that is filled with records of others.

    Args:
        out: Its name, for messages.
        file: Where it is written.
    """

    def __init__(self, out: Path, file: BinaryIO) -> None:
        self.messages = 0
        self._out = out
        self._writer = mcap_writer(file)
        self._writer.start(profile="ros2", library=LIBRARY)
        self._schemas: dict[tuple[str, bytes], int] = {}
        self._channels: dict[tuple[str, int], int] = {}
        self.begin_source()

    def begin_source(self) -> None:
        """Forget the numbers of schemas and channels: another file has its own."""
        self._schema_of: dict[int, int] = {}
        self._channel_of: dict[int, int] = {}

    def add(self, record: Content) -> None:
        """Write one record.

        Raises:
            RecordError: The disk is full.
        """
        try:
            self._add(record)
        except OSError as error:
            raise RecordError(
                f"the log {self._out} can no longer be written: {error.strerror}; make room"
            ) from error

    def _add(self, record: Content) -> None:
        if isinstance(record, Message):
            self.messages += 1
            self._writer.add_message(
                self._channel_of[record.channel_id],
                record.log_time,
                record.data,
                record.publish_time,
                record.sequence,
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

    def add_metadata(self, name: str, metadata: Mapping[str, str]) -> None:
        """Write metadata of our own."""
        self._writer.add_metadata(name, dict(sorted(metadata.items())))

    def finish(self) -> None:
        """Write index and summary."""
        self._writer.finish()  # type: ignore[no-untyped-call]


@contextmanager
def log_copy(out: Path, inputs: tuple[Path, ...]) -> Iterator[LogCopy]:
    """Yield a new log; it appears under its name only when it is complete.

    Args:
        out: The file to write.
        inputs: The files that are read meanwhile, which must not be overwritten.

    Raises:
        RecordError: The file cannot be written, or is one of the inputs.
    """
    if any(path.resolve() == out.resolve() for path in inputs):
        raise RecordError(f"{out} is the log itself; choose another file to write to")
    with writing(out), whole_file(out) as part:
        file = open_log_file(part, "--out")
        try:
            copy = LogCopy(out, file)
            yield copy
            copy.finish()
            file.close()
        except BaseException:
            with suppress(OSError):  # what cannot be flushed any more is thrown away
                file.close()
            raise


def repair(path: Path, out: Path, progress: Pass | None = None) -> Rewritten:
    """Copy what can be read of a cut or damaged log into a proper file, with index and summary.

    Args:
        path: The log, cut, damaged or whole.
        out: The file to write.
        progress: Filled on the way.

    Raises:
        RecordError: Nothing can be read, or the file cannot be written.
    """
    done = progress if progress is not None else Pass()
    with log_copy(out, (path,)) as copy:
        for record in read_records(path, done):
            copy.add(record)
        if copy.messages == 0:
            raise RecordError(f"nothing in {path} can be read")
    return Rewritten(copy.messages, tuple(done.damages))
