"""The report of a day on a terminal: a row a run, then what went wrong, then the gap."""

import math
from collections.abc import Iterator, Sequence

from robot.console.screen_fit import shortened, wrapped
from robot.console.table import Column, table_lines
from robot.day.gap import DayGap
from robot.day.runs import DayRun

LONGEST_NAME = 22
COLUMNS = (
    Column("run"), Column("gait"), Column("walk s", ".1f"), Column("m", ".3f"),
    Column("slip mm/s"), Column("odom %", ".1f"), Column("health"), Column("C", ".0f"), Column("ended"),
)  # fmt: skip


def day_sentence(runs: Sequence[DayRun]) -> str:
    """Return what the day was in one sentence."""
    read = [one.summary for one in runs if one.summary is not None]
    walked = [s for s in read if s.walking_s > 0]
    metres = sum(s.distance_m for s in walked if math.isfinite(s.distance_m))
    seconds = sum(s.walking_s for s in walked)
    words = f"{_runs(len(read))}, {len(walked)} with walking: {metres:.2f} m in {seconds:.0f} s"
    stopped = sum(one.stopped_by_fault for one in runs)
    words += f"; {_runs(stopped)} stopped by a fault" if stopped else "; none stopped by a fault"
    unread = len(runs) - len(read)
    return f"{words}; {_runs(unread)} could not be read." if unread else f"{words}."


def _runs(count: int) -> str:
    return "1 run" if count == 1 else f"{count} runs"


def day_lines(runs: Sequence[DayRun], gap: DayGap, width: int) -> Iterator[str]:
    """Yield the lines of the report; the table may be wider than a narrow terminal."""
    yield from wrapped(day_sentence(runs), width)
    yield ""
    rows = [
        (
            shortened(one.path.stem, LONGEST_NAME), s.gait, s.walking_s, s.distance_m, one.slip_words,
            one.end_error, one.health_words, s.hottest_c, one.end_words,
        )
        for one in runs if (s := one.summary) is not None
    ]  # fmt: skip
    if rows:
        yield from table_lines(COLUMNS, rows)
    troubled = [one for one in runs if one.fault_words]
    if troubled:
        yield ""
    for one in troubled:
        label = "not read" if one.summary is None else "faults in"
        yield from wrapped(f"{label} {one.path}: {one.fault_words}", width)
    yield ""
    yield from wrapped(f"gap: {f'{gap.verdict}. ' if gap.verdict else ''}{gap.words}", width)
    for path, reason in gap.left_out:
        yield from wrapped(f"  not compared: {path.name}: {reason}", width)
