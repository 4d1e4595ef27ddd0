"""Reading topics of a log as the messages they are: ticks to be replayed, bytes of the wires, ROS topics.

A log holds twenty messages a tick and a replay needs one of them, and of that one its inputs.
"""

from collections.abc import Collection, Iterator
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
class TopicMessage:
    """One message of a log as it is in the file.

    Attributes:
        topic: Its topic.
        kind: Its type, for example ``nav_msgs/msg/Odometry``.
        unix_ns: UNIX time.
        data: The message, CDR.
    """

    topic: str
    kind: str
    unix_ns: int
    data: bytes


@dataclass(frozen=True, slots=True)
class TickMessage:
    """A tick as it stands in a log.

    Attributes:
        data: The message.
        layout: Its layout.
    """

    data: bytes
    layout: int


def _messages(
    path: Path, contents: LogContents, topics: Collection[str] | None = None
) -> Iterator[tuple[Message, Channel, Schema | None]]:
    """Yield messages of a log with their channels and schemas, in file order, stepping over damage."""
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    for record in read_records(path, contents.progress, topics=topics):
        if isinstance(record, Message):
            channel = channels[record.channel_id]
            yield record, channel, schemas.get(channel.schema_id)
        elif isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            channels[record.id] = record
        else:
            note_content(record, contents)


def stored_messages(path: Path, contents: LogContents) -> Iterator[TopicMessage]:
    """Yield all messages of a finished log in file order, stepping over damage.

    Args:
        path: The log.
        contents: Filled with robot file, metadata and damage on the way.

    Raises:
        RecordError: The file cannot be opened.
    """
    for message, channel, schema in _messages(path, contents):
        kind = "" if schema is None else schema.name
        yield TopicMessage(channel.topic, kind, message.log_time, message.data)


def read_tick_messages(path: Path, contents: LogContents) -> Iterator[TickMessage]:
    """Yield the ticks of a log as messages; arguments and order as for ``stored_messages``.

    Raises:
        RecordError: The file cannot be opened, or its ticks have a layout that is not known.
    """
    layouts: dict[int, int] = {}
    for message, channel, schema in _messages(path, contents, {TICK_TOPIC}):
        if channel.id not in layouts:
            layouts[channel.id] = tick_layout(path, schema, contents)
        yield TickMessage(message.data, layouts[channel.id])


def read_wires(path: Path, contents: LogContents) -> tuple[WireBytes, ...]:
    """Return the recorded traffic of both devices in the order in which it passed.

    Raises:
        RecordError: The file cannot be opened, or holds no traffic.
    """
    messages = [message for message, _, _ in _messages(path, contents, WIRE_TOPICS)]
    if not messages:
        raise RecordError(
            f"{path} holds no bytes of the devices; record them with: bigant drive --record-bytes"
        )
    messages.sort(key=lambda message: message.sequence)
    return tuple(decode_wire(message.data) for message in messages)
