"""When a run was and which file keeps it, for the line below a page's heading."""

import time
from collections.abc import Mapping
from pathlib import Path

from record.log.reader import whole_number
from record.log.writer import START_UNIX_KEY


def run_words(path: Path, metadata: Mapping[str, str]) -> str:
    """Return file and date of a log.

    Args:
        path: The log.
        metadata: Its metadata texts.
    """
    return f"{path}, {date_words(metadata)}"


def date_words(metadata: Mapping[str, str]) -> str:
    """Return when a run began; a run in virtual time has no date, whatever its stamps say."""
    if metadata.get("time") == "virtual":
        return "in virtual time, so without a date"
    begun_ns = whole_number(metadata.get(START_UNIX_KEY, ""), -1)
    if begun_ns < 0:
        return "of unknown date"
    return utc_words(begun_ns)


def utc_words(unix_ns: int) -> str:
    """Return a UNIX time [ns] as date and time."""
    return time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(unix_ns // 10**9))


def software_words(metadata: Mapping[str, str]) -> str:
    """Return which program wrote a log."""
    return metadata.get("software", "written by an unknown program")
