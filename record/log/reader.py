"""Reading a log, whole, cut or damaged: every tick that is still there comes back."""

import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from itertools import chain, islice
from pathlib import Path
from types import MappingProxyType

from mcap.records import Attachment, Channel, Message, Metadata, Schema

from model.errors import RecordError
from model.values.machine_names import MachineNames
from model.values.quick import quick
from model.values.tick import Tick
from model.values.wire import WireBytes
from record.log.damage import Damage, Pass, damage_words
from record.log.salvage import DAMAGE, read_records
from record.log.tick_message import decode_tick
from record.log.wire_message import WIRE_TOPICS, decode_wire
from record.log.writer import (
    CONFIG_NAME,
    JOINTS_KEY,
    METADATA_NAME,
    NAMES_KEY,
    START_KEY,
    START_UNIX_KEY,
)
from record.topics import TICK_TOPIC

# Every layout of a tick that was ever written, by the SHA-256 of its definition's text. Whoever changes the
# message adds the new digest, and keeps reading the old one.
TICK_LAYOUTS: Mapping[str, int] = MappingProxyType({
    "ceb7071d66556ccbd75ba41874e19bdc2263bbc3daa277547a880aedce94cd93": 1,
    "66adf6cccffb1a8ca10215d6da78abaa78eee62b8d88ceb552652a780a6316c6": 2,
    "07ad6e8492b096df82ea7996ad847597fd5f08bea55f2f88a2831760d2ff1ac9": 3,
    "5c1fb05dd35ef33839190c8c2a3c8c0bdf37a2ab84716a5b26483e588e4bdec3": 4,
})  # fmt: skip


@dataclass(slots=True)
class LogContents:
    """What a pass over a log has found so far.

    Attributes:
        config_text: The robot file.
        metadata: Metadata texts.
        progress: How far the pass has come, and what it could not read.
    """

    config_text: str = ""
    metadata: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    progress: Pass = field(default_factory=Pass)

    @property
    def damages(self) -> tuple[Damage, ...]:
        """What could not be read, in file order."""
        return tuple(self.progress.damages)

    @property
    def damage(self) -> str:
        """Empty, or what could not be read, where and why, as one sentence."""
        return damage_words(self.progress.damages, self.start_unix_ns(0))

    def start_ns(self, otherwise: int) -> int:
        """Return the monotonic time of the log's beginning."""
        return whole_number(self.metadata.get(START_KEY, ""), otherwise)

    def start_unix_ns(self, otherwise: int) -> int:
        """Return the UNIX time of the log's beginning."""
        return whole_number(self.metadata.get(START_UNIX_KEY, ""), otherwise)

    def names(self, count: int) -> tuple[str, ...]:
        """Return the names of ``count`` legs; made up where the log does not tell."""
        text = self.metadata.get(NAMES_KEY, "")
        names = tuple(text.split(",")) if text else ()
        return names if len(names) == count else tuple(f"leg{i + 1}" for i in range(count))

    def machine(self, tick: Tick) -> MachineNames:
        """Return the names of the joints and legs of a tick; made up where the log does not tell."""
        legs, count = self.names(len(tick.feet.position_m)), len(tick.joints.angle_rad)
        text = self.metadata.get(JOINTS_KEY, "")
        joints = tuple(text.split(",")) if text else legs
        if len(joints) != count:
            joints = tuple(f"joint{i + 1}" for i in range(count))
        return MachineNames(joints, legs)


def whole_number(text: str, otherwise: int) -> int:
    """Return the number in a metadata text, or ``otherwise`` if it is none."""
    return int(text) if text.lstrip("-").isdecimal() else otherwise


@dataclass(frozen=True, slots=True)
class StampedTick:
    """A tick and when it was, which in a merged log is not its own clock's time.

    Attributes:
        unix_ns: UNIX time.
        tick: The tick.
    """

    unix_ns: int
    tick: Tick


@quick
@dataclass(frozen=True, slots=True)
class TopicMessage:
    """One message of a log as it is in the file.

    Attributes:
        topic: Its topic.
        schema: Its type, None where that was lost.
        unix_ns: UNIX time.
        sequence: Its number.
        data: The message, CDR.
    """

    topic: str
    schema: Schema | None
    unix_ns: int
    sequence: int
    data: bytes

    @property
    def kind(self) -> str:
        """Name of its type, for example ``nav_msgs/msg/Odometry``."""
        return self.schema.name if self.schema is not None else ""

    @property
    def layout(self) -> int:
        """Layout of a tick, 0 if it is not known."""
        return _layout_of(self.schema.data) if self.schema is not None else 0


def read_ticks(path: Path, contents: LogContents | None = None) -> Iterator[Tick]:
    """Yield the ticks of a log in order; what is damaged is left out and told in ``contents``.

    Args:
        path: The log.
        contents: Filled with robot file, metadata and damage on the way.

    Raises:
        RecordError: The file cannot be opened, or was written by a program that we do not know.
    """
    for stamped in read_stamped_ticks(path, contents):
        yield stamped.tick


def read_stamped_ticks(path: Path, contents: LogContents | None = None) -> Iterator[StampedTick]:
    """Yield the ticks of a log with their UNIX times; otherwise as ``read_ticks``.

    Raises:
        RecordError: As ``read_ticks``.
    """
    contents = contents or LogContents()
    for message in read_tick_messages(path, contents):
        try:
            tick = decode_tick(message.data, message.layout)
        except DAMAGE as error:
            at = contents.progress.position
            contents.progress.damages.append(damage_of(message, at, error))
            continue
        yield StampedTick(message.unix_ns, tick)


def damage_of(message: TopicMessage, position: int, error: Exception) -> Damage:
    """Return the damage of a tick that cannot be taken apart, found at a place in the file."""
    when = message.unix_ns
    return Damage(position, 0, when, when, f"a broken tick: {error}")


@cache
def _layout_of(definition: bytes) -> int:
    return TICK_LAYOUTS.get(hashlib.sha256(definition).hexdigest(), 0)


class MessageReader:
    """Makes messages of a log's records.

    Args:
        contents: Filled with robot file and metadata on the way.
    """

    def __init__(self, contents: LogContents) -> None:
        self._contents = contents
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}

    def messages(self, records: Iterable[object]) -> Iterator[TopicMessage]:
        """Yield the messages among more records of the log."""
        for record in records:
            if isinstance(record, Message):
                channel = self._channels[record.channel_id]
                schema = self._schemas.get(channel.schema_id)
                yield TopicMessage(
                    channel.topic, schema, record.log_time, record.sequence, record.data
                )
            elif isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._channels[record.id] = record
            else:
                note_content(record, self._contents)


def read_messages(
    path: Path,
    contents: LogContents,
    topics: Collection[str] | None = None,
    span: tuple[int, int] | None = None,
) -> Iterator[TopicMessage]:
    """Yield the messages of a log in file order, stepping over damage.

    Args:
        path: The log.
        contents: Filled with robot file, metadata and damage on the way.
        topics: Only these; None for all.
        span: As for ``read_records``.

    Raises:
        RecordError: The file cannot be opened.
    """
    records = read_records(path, contents.progress, topics, span)
    yield from MessageReader(contents).messages(records)


def read_tick_messages(path: Path, contents: LogContents) -> Iterator[TopicMessage]:
    """Yield the ticks of a log as messages: a replay need not take them apart; see ``read_messages``.

    Raises:
        RecordError: The file cannot be opened, or its ticks have a layout that is not known.
    """
    for message in read_messages(path, contents, {TICK_TOPIC}):
        check_layout(path, message, contents)
        yield message


def read_wires(path: Path, contents: LogContents) -> tuple[WireBytes, ...]:
    """Return the recorded traffic of both devices in the order in which it passed.

    Raises:
        RecordError: The file cannot be opened, or holds no traffic.
    """
    pieces = sorted(
        read_messages(path, contents, WIRE_TOPICS), key=lambda message: message.sequence
    )
    if not pieces:
        raise RecordError(
            f"{path} holds no bytes of the devices; record them with: bigant drive --record-bytes"
        )
    wires = []
    for message in pieces:
        with sound(path, message):
            wires.append(decode_wire(message.data))
    return tuple(wires)


@contextmanager
def sound(path: Path, message: TopicMessage) -> Iterator[None]:
    """Refuse a message that the block cannot take apart, where nothing may be left out.

    Raises:
        RecordError: The message is damaged.
    """
    try:
        yield
    except DAMAGE as error:
        raise damaged(path, message, error) from error


def damaged(path: Path, message: TopicMessage, error: Exception) -> RecordError:
    """Return the error for a message that cannot be taken apart."""
    return RecordError(
        f"{path}: message {message.sequence} of {message.topic} is damaged ({error}); leave its "
        "part of the run out with bigant log trim"
    )


def note_content(record: object, contents: LogContents) -> None:
    """Keep the robot file or the metadata, if this is one of them."""
    if isinstance(record, Metadata) and record.name == METADATA_NAME:
        contents.metadata = MappingProxyType(dict(record.metadata))
    elif isinstance(record, Attachment) and record.name == CONFIG_NAME:
        contents.config_text = record.data.decode("utf-8", errors="replace")


def check_layout(path: Path, message: TopicMessage, contents: LogContents) -> None:
    """Refuse a tick of a layout that is not known.

    Raises:
        RecordError: It is not.
    """
    if not message.layout:
        writer = contents.metadata.get("software", "another program")
        raise RecordError(
            f"{path} holds ticks of a layout that is not known here (written by {writer}); read it "
            "with the version of bigant that wrote it, or a newer one"
        )


def nothing_left(path: Path, contents: LogContents, what: str = "ticks") -> RecordError:
    """Return the error of a file in which nothing was to be read."""
    reason = contents.damage or f"it holds no {what}"
    return RecordError(f"{path} cannot be read as a log: {reason}")


def tick_blocks(
    path: Path, contents: LogContents, block_ticks: int
) -> Iterator[tuple[StampedTick, ...]]:
    """Yield the ticks of a log, so many at a time; otherwise as ``read_stamped_ticks``.

    Raises:
        RecordError: The file cannot be opened, or holds no tick that can be read.
    """
    stamped = read_stamped_ticks(path, contents)
    first = next(stamped, None)
    if first is None:
        raise nothing_left(path, contents)
    stamped = chain((first,), stamped)
    while block := tuple(islice(stamped, block_ticks)):
        yield block
