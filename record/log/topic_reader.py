"""Reading single topics of a log as the messages they are: ticks to be replayed, bytes of the wires.

A log holds twenty messages a tick and a replay needs one of them, and of that one its inputs.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Channel, Message, Schema

from model.errors import RecordError
from model.values.wire import WireBytes
from record.log.reader import LogContents, note_content, tick_layout
from record.log.salvage import read_records
from record.log.wire_message import WIRE_TOPICS, decode_wire
from record.log.writer import TICK_TOPIC


@dataclass(frozen=True, slots=True)
class TickMessage:
    """A tick as it stands in a log.

    Attributes:
        data: The message.
        layout: Its layout.
    """

    data: bytes
    layout: int


def read_tick_messages(path: Path, contents: LogContents) -> Iterator[TickMessage]:
    """Yield the ticks of a log as messages, in order; damage is stepped over and told in ``contents``.

    Args:
        path: The log.
        contents: Filled with robot file, metadata and damage on the way.

    Raises:
        RecordError: The file cannot be opened, or its ticks have a layout that is not known.
    """
    schemas: dict[int, Schema] = {}
    layouts: dict[int, int] = {}
    for record in read_records(path, contents.progress, topics={TICK_TOPIC}):
        if isinstance(record, Message):
            yield TickMessage(record.data, layouts[record.channel_id])
        elif isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            if record.topic == TICK_TOPIC:
                schema = schemas.get(record.schema_id)
                layouts[record.id] = tick_layout(path, schema, contents)
        else:
            note_content(record, contents)


def read_wires(path: Path, contents: LogContents) -> tuple[WireBytes, ...]:
    """Return the recorded traffic of both devices in the order in which it passed.

    Raises:
        RecordError: The file cannot be opened, or holds no traffic.
    """
    found: list[Message] = []
    for record in read_records(path, contents.progress, topics=WIRE_TOPICS):
        if isinstance(record, Message):
            found.append(record)
        elif not isinstance(record, Schema | Channel):
            note_content(record, contents)
    if not found:
        raise RecordError(
            f"{path} holds no bytes of the devices; record them with: bigant drive --record-bytes"
        )
    found.sort(key=lambda message: message.sequence)
    return tuple(decode_wire(message.data) for message in found)
