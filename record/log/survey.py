"""What a log holds, found in one quick pass that decodes nothing but the first bytes of each tick."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.records import Channel, Message, Schema

from model.errors import RecordError
from record.log.cdr import HEADER
from record.log.damage import Damage, Pass
from record.log.reader import LogContents, note_content
from record.log.salvage import read_records
from record.log.writer import RATE_KEY, TICK_TOPIC

_TICK_HEAD = struct.Struct("<qq")  # t_ns and index, behind the CDR header


@dataclass(frozen=True, slots=True)
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


@dataclass(slots=True)
class _Count:
    name: str
    kind: str
    count: int = 0
    size: int = 0


@dataclass(slots=True)
class _Ticks:
    unix_ns: list[int] = field(default_factory=list)
    index: list[int] = field(default_factory=list)


def survey_log(path: Path, progress: Pass | None = None) -> LogSurvey:
    """Look through a log.

    Args:
        path: The log.
        progress: Filled on the way.

    Raises:
        RecordError: The file cannot be opened, or holds no message.
    """
    contents = LogContents(progress=progress if progress is not None else Pass())
    counts: dict[int, _Count] = {}
    kinds: dict[int, str] = {}
    ticks = _Ticks()
    first_ns, last_ns = -1, -1
    for record in read_records(path, contents.progress):
        if isinstance(record, Message):
            count = counts[record.channel_id]
            count.count += 1
            count.size += len(record.data)
            first_ns = record.log_time if first_ns < 0 else min(first_ns, record.log_time)
            last_ns = max(last_ns, record.log_time)
            if count.name == TICK_TOPIC and len(record.data) >= len(HEADER) + _TICK_HEAD.size:
                ticks.unix_ns.append(record.log_time)
                ticks.index.append(_TICK_HEAD.unpack_from(record.data, len(HEADER))[1])
        elif isinstance(record, Schema):
            kinds[record.id] = record.name
        elif isinstance(record, Channel):
            counts[record.id] = _Count(record.topic, kinds.get(record.schema_id, "?"))
        else:
            note_content(record, contents)
    if first_ns < 0:
        reason = contents.damage or "it holds no messages"
        raise RecordError(f"{path} is no log of ours, or nothing of it is left: {reason}")
    period_s, skipped, lost = _gaps(ticks, contents.metadata.get(RATE_KEY, ""))
    return LogSurvey(
        path=path,
        size=contents.progress.size,
        finished=contents.progress.finished,
        first_unix_ns=first_ns,
        last_unix_ns=last_ns,
        start_unix_ns=contents.start_unix_ns(first_ns),
        ticks=len(ticks.index),
        period_s=period_s,
        skipped=skipped,
        lost=lost,
        topics=tuple(
            Topic(c.name, c.kind, c.count, c.size)
            for c in sorted(counts.values(), key=lambda c: (c.name, c.kind))
        ),
        config_text=contents.config_text,
        metadata=contents.metadata,
        damages=contents.damages,
    )


def _gaps(ticks: _Ticks, rate: str) -> tuple[float, int, int]:
    """Return period [s], periods without a tick, and ticks run that are not there.

    Args:
        ticks: The ticks.
        rate: Of the loop, as the log says it. A loop that is late all the time does not show it.
    """
    if len(ticks.unix_ns) < 2:
        return np.nan, 0, 0
    steps_ns = np.diff(np.array(ticks.unix_ns, dtype=np.int64))
    period_ns = 1e9 / float(rate) if rate.isdecimal() and int(rate) else float(np.median(steps_ns))
    if period_ns <= 0:
        return np.nan, 0, 0
    absent = np.maximum(np.rint(steps_ns / period_ns).astype(np.int64) - 1, 0)
    lost = np.maximum(np.diff(np.array(ticks.index, dtype=np.int64)) - 1, 0)
    # a tick that was run took a period at least, so what is lost explains that much of a gap
    return period_ns * 1e-9, int(np.maximum(absent - lost, 0).sum()), int(lost.sum())
