"""Reading single topics of a log as the messages they are: ticks to be replayed, bytes of the wires.

A log holds twenty messages a tick and a replay needs one of them, and of that one its inputs.
"""

from collections.abc import Iterator
from pathlib import Path

from mcap.records import Channel, Message, Schema

from model.errors import RecordError
from model.wire import WireBytes
from record.reader import LogContents, note_content, tick_decoder
from record.salvage import read_records
from record.tick_message import decode_tick
from record.wire_message import WIRE_TOPICS, decode_wire
from record.writer import TICK_TOPIC


def read_tick_messages(path: Path, contents: LogContents) -> Iterator[bytes]:
    """Yield the ticks of a log as messages, in order; damage is stepped over and told in ``contents``.

    Args:
        path: The log.
        contents: Filled with robot file, metadata and damage on the way.

    Raises:
        RecordError: The file cannot be opened, or its ticks have another layout than today's.
    """
    schemas: dict[int, Schema] = {}
    for record in read_records(path, contents.progress, topics={TICK_TOPIC}):
        if isinstance(record, Message):
            yield record.data
        elif isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            if record.topic == TICK_TOPIC:
                decoder = tick_decoder(path, schemas.get(record.schema_id), contents)
                if decoder is not decode_tick:
                    raise RecordError(
                        f"{path} holds ticks of an old layout, from which nothing can be replayed"
                    )
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
