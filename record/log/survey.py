"""What a log holds, found in one quick pass that decodes nothing but the first bytes of each tick."""

import struct
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.records import Channel, Message, Schema

from record.log.cdr import HEADER
from record.log.damage import Damage, Pass
from record.log.reader import LogContents, note_content, nothing_left
from record.log.salvage import read_records
from record.log.writer import RATE_KEY
from record.topics import TICK_TOPIC

_TICK_HEAD = struct.Struct("<qq")  # t_ns and index, behind the CDR header


@dataclass(frozen=True, slots=True, order=True)
class Topic:
    """One topic of a log.

    Attributes:
        name: Topic.
        kind: Message type.
        count: Number of messages.
        size: Bytes of all its messages before compression.
    """

    name: str
    kind: str
    count: int
    size: int


@dataclass(frozen=True, slots=True)
class LogSurvey:
    """What a log holds.

    Attributes:
        path: The file.
        size: Its size [bytes].
        finished: Whether the file has its proper end and index.
        first_unix_ns: UNIX time of the first message.
        last_unix_ns: UNIX time of the last message.
        start_unix_ns: UNIX time of the beginning of the run, 0 s of the log.
        ticks: Number of ticks.
        period_s: Of the loop; where the log does not say, median of the time between ticks, or NaN.
        skipped: Periods without a tick: torque was being switched on, the loop late, or logs merged.
        lost: Ticks that were run and are not in the file (damage, or a disk too slow).
        topics: Topics in order of name.
        config_text: The robot file.
        metadata: Metadata texts.
        damages: What could not be read.
    """

    path: Path
    size: int
    finished: bool
    first_unix_ns: int
    last_unix_ns: int
    start_unix_ns: int
    ticks: int
    period_s: float
    skipped: int
    lost: int
    topics: tuple[Topic, ...]
    config_text: str
    metadata: Mapping[str, str]
    damages: tuple[Damage, ...]

    @property
    def duration_s(self) -> float:
        """Time from first to last message."""
        return (self.last_unix_ns - self.first_unix_ns) * 1e-9


def survey_log(path: Path, progress: Pass | None = None) -> LogSurvey:
    """Look through a log.

    Args:
        path: The log.
        progress: Filled on the way.

    Raises:
        RecordError: The file cannot be opened, or holds no message.
    """
    contents = LogContents(progress=progress or Pass())
    channels: dict[int, Channel] = {}
    kinds: dict[int, str] = {}
    counts, sizes = Counter[int](), Counter[int]()  # messages of a channel, and their bytes
    ticks: list[tuple[int, int]] = []  # UNIX time and number
    first_ns, last_ns = -1, -1
    for record in read_records(path, contents.progress):
        if isinstance(record, Message):
            counts[record.channel_id] += 1
            sizes[record.channel_id] += len(record.data)
            first_ns = record.log_time if first_ns < 0 else min(first_ns, record.log_time)
            last_ns = max(last_ns, record.log_time)
            of_tick = channels[record.channel_id].topic == TICK_TOPIC
            if of_tick and len(record.data) >= len(HEADER) + _TICK_HEAD.size:
                index = _TICK_HEAD.unpack_from(record.data, len(HEADER))[1]
                ticks.append((record.log_time, index))
        elif isinstance(record, Schema):
            kinds[record.id] = record.name
        elif isinstance(record, Channel):
            channels[record.id] = record
        else:
            note_content(record, contents)
    if first_ns < 0:
        raise nothing_left(path, contents, "messages")
    period_s, skipped, lost = _gaps(ticks, contents.metadata.get(RATE_KEY, ""))
    return LogSurvey(
        path=path,
        size=contents.progress.size,
        finished=contents.progress.finished,
        first_unix_ns=first_ns,
        last_unix_ns=last_ns,
        start_unix_ns=contents.start_unix_ns(first_ns),
        ticks=len(ticks),
        period_s=period_s,
        skipped=skipped,
        lost=lost,
        topics=tuple(
            sorted(
                Topic(channel.topic, kinds.get(channel.schema_id, "?"), counts[at], sizes[at])
                for at, channel in channels.items()
            )
        ),
        config_text=contents.config_text,
        metadata=contents.metadata,
        damages=contents.damages,
    )


def _gaps(ticks: list[tuple[int, int]], rate: str) -> tuple[float, int, int]:
    """Return period [s], periods without a tick, and ticks run that are not there.

    Args:
        ticks: UNIX time and number of each.
        rate: Of the loop, as the log says it. A loop that is late all the time does not show it.
    """
    if len(ticks) < 2:
        return np.nan, 0, 0
    steps_ns, steps = np.diff(np.array(ticks, dtype=np.int64), axis=0).T
    period_ns = 1e9 / float(rate) if rate.isdecimal() and int(rate) else float(np.median(steps_ns))
    if period_ns <= 0:
        return np.nan, 0, 0
    absent = np.maximum(np.rint(steps_ns / period_ns).astype(np.int64) - 1, 0)
    lost = np.maximum(steps - 1, 0)
    # a tick that was run took a period at least, so what is lost explains that much of a gap
    return period_ns * 1e-9, int(np.maximum(absent - lost, 0).sum()), int(lost.sum())
