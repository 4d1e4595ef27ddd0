"""Reading a log, whole or cut anywhere: everything up to the cut comes back."""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Message, Metadata
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from model.errors import RecordError
from model.signals import Tick
from record.recording import Recording, build_recording
from record.tick_message import decode_tick
from record.writer import CONFIG_NAME, METADATA_NAME, NAMES_KEY, START_KEY, TICK_TOPIC

# What reading past a cut or a damaged byte raises, by way of mcap, zstd and our own decoder.
DAMAGE = (McapError, ValueError, EOFError, OSError, MemoryError, KeyError, struct.error, ZstdError)


@dataclass(slots=True)
class LogContents:
    """What a pass over a log has found so far.

    Attributes:
        config_text: The robot file.
        metadata: Metadata texts.
        damage: Empty, or where and why reading ended early.
    """

    config_text: str = ""
    metadata: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    damage: str = ""


def read_ticks(path: Path, contents: LogContents | None = None) -> Iterator[Tick]:
    """Yield the ticks of a log in order; ends quietly where the file is cut.

    Args:
        path: The log.
        contents: Filled with robot file, metadata and damage on the way.

    Raises:
        RecordError: The file cannot be opened.
    """
    found = contents if contents is not None else LogContents()
    channels: dict[int, str] = {}
    try:
        stream = path.open("rb")
    except OSError as error:
        raise RecordError(f"the log {path} cannot be read: {error.strerror}") from error
    with stream:
        try:
            for record in StreamReader(stream, validate_crcs=True, record_size_limit=None).records:
                if isinstance(record, Channel):
                    channels[record.id] = record.topic
                elif isinstance(record, Metadata) and record.name == METADATA_NAME:
                    found.metadata = MappingProxyType(dict(record.metadata))
                elif isinstance(record, Attachment) and record.name == CONFIG_NAME:
                    found.config_text = record.data.decode("utf-8", errors="replace")
                elif isinstance(record, Message) and channels.get(record.channel_id) == TICK_TOPIC:
                    yield decode_tick(record.data)
        except DAMAGE as error:
            found.damage = f"cut or damaged: {type(error).__name__} {error}".strip()


def read_log(path: Path) -> Recording:
    """Read a log into arrays.

    Raises:
        RecordError: The file cannot be opened, or holds no tick that can be read.
    """
    contents = LogContents()
    ticks = list(read_ticks(path, contents))
    if not ticks:
        reason = contents.damage or "it holds no ticks"
        raise RecordError(f"{path} is no log of ours, or nothing of it is left: {reason}")
    names = tuple(contents.metadata.get(NAMES_KEY, "").split(","))
    if len(names) != len(ticks[0].joints.angle_rad):
        names = tuple(f"leg{i + 1}" for i in range(len(ticks[0].joints.angle_rad)))
    start_ns = int(contents.metadata.get(START_KEY, ticks[0].t_ns))
    return build_recording(
        ticks,
        names=names,
        start_ns=start_ns,
        config_text=contents.config_text,
        metadata=contents.metadata,
        damage=contents.damage,
    )
