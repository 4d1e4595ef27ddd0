"""Where ``bigant view`` and ``bigant view --ros2`` get their messages: a log, or one that is being written.

A live run is followed by reading its log (``record.log.follow``), half a second to a second behind. That
needs nothing of the control process: it cannot be slowed, stopped or commanded from here.
"""

import contextlib
import math
import os
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TypeVar

from drivers.clock import Clock
from model.errors import ConfigError, RecordError
from record.log.follow import LogFollower, is_log_of_run
from record.log.reader import TopicMessage

LOG_FOLDER = Path("runs")
POLL_NS = 100_000_000
SILENT_NS = 5_000_000_000
# What is shown of the time before the follower came: twenty messages a tick, ten seconds at 100 Hz.
BACKLOG = 20_000
# Whoever watches a live run on the robot's computer must not take time from the loop.
NICENESS = 10
Item = TypeVar("Item")


def log_path(path: Path | None, *, live: bool) -> Path:
    """Return the log that is meant.

    Args:
        path: The log that was named; None for the one that is being written.
        live: Whether to follow it.

    Raises:
        ConfigError: None was named, and none is to be followed.
        RecordError: There is none to follow.
    """
    if path is not None:
        return path
    if not live:
        raise ConfigError("LOG", "name a log, or give --live to follow a running bigant drive")
    return newest_log()


def newest_log() -> Path:
    """Return the log in ``runs/`` that was written to last.

    Raises:
        RecordError: There is none.
    """
    logs = sorted(LOG_FOLDER.glob("*.mcap"), key=lambda path: path.stat().st_mtime)
    for path in reversed(logs):
        if is_log_of_run(path):  # and not a viewer's file beside it
            return path
    raise RecordError(f"there is no log in {LOG_FOLDER}/ to follow; start bigant drive first")


def paced(
    items: Iterable[Item], unix_ns: Callable[[Item], int], clock: Clock, speed: float
) -> Iterator[Item]:
    """Yield items when their time has come.

    Args:
        items: In order of time.
        unix_ns: Time of an item.
        clock: Who waits.
        speed: Of the original; infinite does not wait.
    """
    begin_ns = first_ns = None
    for item in items:
        if begin_ns is None or first_ns is None:
            begin_ns, first_ns = clock.now_ns(), unix_ns(item)
        if math.isfinite(speed):
            clock.sleep_until_ns(begin_ns + round((unix_ns(item) - first_ns) / speed))
        yield item


def followed(follower: LogFollower, clock: Clock) -> Iterator[TopicMessage]:
    """Yield what comes into a log until it is finished, beginning a few seconds back.

    Raises:
        RecordError: The log is damaged.
    """
    yield from deque(follower.new_messages(), BACKLOG)
    grown_ns, warned = clock.now_ns(), False
    while not follower.finished:
        clock.sleep_until_ns(clock.now_ns() + POLL_NS)
        for message in follower.new_messages():
            grown_ns, warned = clock.now_ns(), False
            yield message
        if not warned and clock.now_ns() - grown_ns > SILENT_NS:
            warned = True
            print(
                f"{follower.path} has not grown for {SILENT_NS // 10**9} s: is bigant drive still "
                "running? Ctrl-C ends this",
                file=sys.stderr,
            )


def be_nice() -> None:
    """Let everything else on this computer go first."""
    with contextlib.suppress(OSError):  # a sandbox may forbid it, and then nothing is worse
        os.nice(NICENESS)
