"""When a run was, in words."""

import time
from collections.abc import Mapping

from record.log.reader import whole_number
from record.log.writer import START_UNIX_KEY

A_DAY_NS = 86_400_000_000_000


def date_words(metadata: Mapping[str, str]) -> str:
    """Return when a run began; a run in virtual time has no date, whatever its stamps say."""
    if metadata.get("time") == "virtual":
        return "in virtual time, so without a date"
    begun_ns = whole_number(metadata.get(START_UNIX_KEY, ""), -1)
    if begun_ns < A_DAY_NS:  # an imported table whose time begins with itself
        return "of unknown date"
    return utc_words(begun_ns)


def has_date(metadata: Mapping[str, str]) -> bool:
    """Whether it is known when a run began: not in virtual time, nor of a table that begins with itself."""
    begun_ns = whole_number(metadata.get(START_UNIX_KEY, ""), -1)
    return metadata.get("time") != "virtual" and begun_ns >= A_DAY_NS


def utc_words(unix_ns: int) -> str:
    """Return a UNIX time [ns] as date and time."""
    return time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(unix_ns // 10**9))
