"""The runs of a day: which files, the summary of each, and the reason where there is none."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from model.errors import BigantError, RecordError
from model.values.faults import StopReason
from record.log.reader import whole_number
from record.log.writer import START_UNIX_KEY
from robot.console.table import number_text
from robot.control.stops import STOPS
from robot.report.run_date import date_words, has_date
from robot.report.summary import Summary, read_summary, reason_of

LOG, TABLES = "*.mcap", ("*.parquet",)
OK_SHARE = 0.999  # of the ticks: an estimator that was ok in fewer was not ok


@dataclass(frozen=True, slots=True)
class DayRun:
    """One run of a day.

    Attributes:
        path: Its log.
        summary: Its figures; None where it could not be read.
        reason: Why it could not be read, in words; empty if it could.
        begun: When it began, in words; a dash where it has no date, as in virtual time.
        begun_ns: The same, for the order of runs.
    """

    path: Path
    summary: Summary | None
    reason: str = ""
    begun: str = ""
    begun_ns: int = -1

    @property
    def end_error(self) -> float:
        """Error of the estimated place at the end of the walk over its distance [%]; NaN without truth."""
        s = self.summary
        if s is None or not s.truth or not s.distance_m > 0.0:
            return math.nan
        return 100 * s.estimate_walk_drift_m / s.distance_m

    @property
    def slip_words(self) -> str:
        """Slip of loaded feet, from the 5 to the 95 percentile [mm/s]."""
        s = self.summary
        if s is None or not math.isfinite(s.slip_percentiles_m_s[0]):
            return "-"
        low, high = (number_text(s.slip_percentiles_m_s[at] * 1e3, 0) for at in (0, -1))
        return f"{low} to {high}"

    @property
    def health_words(self) -> str:
        """Health of the estimator."""
        s = self.summary
        if s is None or not math.isfinite(s.estimate_health[0]):
            return "-"
        ok, _, lost = s.estimate_health
        if ok >= OK_SHARE:
            return "ok"
        return f"ok {100 * ok:.0f} %" + (f", lost {100 * lost:.0f} %" if lost > 0 else "")

    @property
    def end_words(self) -> str:
        """How the run ended."""
        s = self.summary
        if s is None:
            return "not read"
        going = reason_of(s.stop_reason) is StopReason.NONE
        return "not ended in this log" if going else s.stop_reason

    @property
    def stopped_by_fault(self) -> bool:
        """Whether it ended in another way than the operator wished."""
        s = self.summary
        return s is not None and not STOPS[reason_of(s.stop_reason)].wished

    @property
    def fault_words(self) -> str:
        """What went wrong in it; empty if nothing did."""
        s = self.summary
        if s is None:
            return self.reason
        faults = ", ".join(f"{kind} in {n} tick{'s' * (n > 1)}" for kind, n in s.faults)
        return "; ".join(one for one in (s.stop_cause, faults, s.damage) if one)


def logs_of(paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return the logs that are named, and those in the folders that are named.

    Raises:
        RecordError: A folder holds none.
    """
    return _files(paths, (LOG,), "logs (.mcap)")


def references_of(paths: Sequence[Path]) -> tuple[Path, ...]:
    """Return the logs and trials that are named, and those in the folders that are named.

    Raises:
        RecordError: A folder holds none.
    """
    return _files(paths, (LOG, *TABLES), "logs (.mcap) or trials (.parquet)")


def _files(paths: Sequence[Path], patterns: Iterable[str], what: str) -> tuple[Path, ...]:
    everything: list[Path] = []
    for path in paths:
        if not path.is_dir():
            everything.append(path)
            continue
        inside = sorted(one for pattern in patterns for one in path.glob(pattern))
        if not inside:
            raise RecordError(f"{path} holds no {what}; name the folder of the day's runs")
        everything += inside
    return tuple(dict.fromkeys(everything))


def read_runs_of_day(
    paths: Sequence[Path], progress: Callable[[int, Path], None]
) -> tuple[DayRun, ...]:
    """Read each log; one that cannot be read has its reason. In order of time, unread ones at the end.

    Args:
        paths: Logs.
        progress: Gets the number and path of the log that is read.
    """
    runs = []
    for at, path in enumerate(paths):
        progress(at, path)
        runs.append(_read(path))
    return tuple(sorted(runs, key=lambda one: (one.summary is None, one.begun_ns, one.path)))


def _read(path: Path) -> DayRun:
    try:
        summary, log = read_summary(path)
    except BigantError as error:
        return DayRun(path, None, str(error))
    except (ValueError, IndexError) as error:  # what no reader of logs has foreseen
        return DayRun(path, None, f"{path} cannot be summarised: {error}")
    dated = has_date(log.metadata)
    begun = date_words(log.metadata) if dated else "-"
    return DayRun(path, summary, "", begun, whole_number(log.metadata.get(START_UNIX_KEY, ""), -1))
