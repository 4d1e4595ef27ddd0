"""Making a cut log whole again: everything up to the cut, with index and summary."""

from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from model.errors import RecordError
from record.reader import DAMAGE
from record.writer import CHUNK_BYTES, LIBRARY, open_log_file


def recover(path: Path, out: Path) -> int:
    """Copy what can be read of a log into a proper file.

    Args:
        path: The log, cut or whole.
        out: The file to write.

    Returns:
        Number of messages kept.

    Raises:
        RecordError: Nothing can be read, or the file cannot be written.
    """
    if path.resolve() == out.resolve():
        raise RecordError(f"{out} is the log itself; choose another file to write to")
    kept = 0
    try:
        source = path.open("rb")
    except OSError as error:
        raise RecordError(f"the log {path} cannot be read: {error.strerror}") from error
    with source, open_log_file(out) as target:
        writer = McapWriter(target, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library=LIBRARY)
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        try:
            for record in StreamReader(source, validate_crcs=True, record_size_limit=None).records:
                kept += _copy(record, writer, schemas, channels)
        except DAMAGE:
            pass  # the cut: everything before it has been copied
        writer.finish()  # type: ignore[no-untyped-call]
    if kept == 0:
        raise RecordError(f"nothing in {path} can be read")
    return kept


def _copy(
    record: object, writer: McapWriter, schemas: dict[int, int], channels: dict[int, int]
) -> int:
    """Write one record; return 1 for a message."""
    if isinstance(record, Schema) and record.id not in schemas:
        schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
    elif isinstance(record, Channel) and record.id not in channels:
        channels[record.id] = writer.register_channel(
            record.topic, record.message_encoding, schemas[record.schema_id], record.metadata
        )
    elif isinstance(record, Metadata):
        writer.add_metadata(record.name, record.metadata)
    elif isinstance(record, Attachment):
        writer.add_attachment(
            record.create_time, record.log_time, record.name, record.media_type, record.data
        )
    elif isinstance(record, Message):
        writer.add_message(
            channels[record.channel_id],
            record.log_time,
            record.data,
            record.publish_time,
            record.sequence,
        )
        return 1
    return 0
