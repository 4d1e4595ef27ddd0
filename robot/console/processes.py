"""Whether a log is worth several processes, and how many this computer has cores for."""

import os
from pathlib import Path

from record.log.tick_message import LAYOUT

LEAST_BYTES = 30_000_000  # of a file; a shorter log is done before processes pay for their start


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0))


def worth_processes(path: Path, layout: int) -> bool:
    """Whether a log is long enough, of today's layout, and there is a second core."""
    return cores() > 1 and layout == LAYOUT and is_long(path)


def is_long(path: Path) -> bool:
    """Whether a log is so long that it pays to start, or to load, something for it."""
    return path.stat().st_size >= LEAST_BYTES
