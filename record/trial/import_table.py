"""Bringing a table of measured data in: columns mapped, time put in order, everything odd reported.

Nothing is dropped without being listed. Values are not changed but for the units of the map; rows out of
order are put in order; rows without a time, second rows at one time, and rows that the map cuts off are
dropped and listed.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

import numpy as np

from model.errors import RecordError
from model.values.arrays import BoolArray, FloatArray, IntArray
from record.trial.body_pose import ORIENTATIONS, posed
from record.trial.column_map import ColumnMap, Source, complete_sources, summed
from record.trial.derive import with_speeds
from record.trial.header import LEGGED, TrialHeader, joints_of
from record.trial.header_constants import with_constants
from record.trial.header_file import read_header
from record.trial.imu_tilt import IMU_QUATERNION, levelled
from record.trial.raw_check import raw_findings
from record.trial.source_tables import SourceTable, open_tables
from record.trial.table_check import TableFinding, check_trial
from record.trial.table_file import DataTable, TableColumn
from record.trial.trial import Trial, build_trial, trial_places, trial_table

UNUSUAL = ("imu",)  # fields of a trial that nobody misses


@dataclass(frozen=True, slots=True)
class DroppedRow:
    """A row that was left out.

    Attributes:
        row: Number in the table, from 1, the heading not counted.
        reason: Why.
    """

    row: int
    reason: str


@dataclass(frozen=True, slots=True)
class ImportReport:
    """How an import went.

    Attributes:
        path: The table.
        name: Which of the file's tables; empty where it holds one.
        rows: Rows in it.
        kept: Rows in the trial.
        dropped: Rows left out.
        columns: Our columns that were filled.
        findings: Everything odd.
    """

    path: Path
    name: str
    rows: int
    kept: int
    dropped: tuple[DroppedRow, ...]
    columns: tuple[str, ...]
    findings: tuple[TableFinding, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Imported:
    """One table brought in.

    Attributes:
        trial: The trial; None where the map cuts off so much that none is left.
        report: How it went.
    """

    trial: Trial | None
    report: ImportReport


def import_tables(
    path: Path, given: ColumnMap, tell: Callable[[float], None] = lambda _: None
) -> Iterator[Imported]:
    """Read every table of a file into a trial of its own.

    Args:
        path: A trial's table or NAME.toml, or somebody else's .csv, .parquet or .npz.
        given: Which of its columns is which; empty if they have our names.
        tell: Told which share of a table has been taken, column by column.

    Raises:
        RecordError: It cannot be read, has no time, or nothing in it is known.
    """
    if path.suffix != ".npz":
        path = trial_table(path)
    with open_tables(path, given) as tables:
        for one in tables:
            yield completed(import_part(path, one, given, tell))


def completed(one: Imported) -> Imported:
    """Return what was brought in with what follows from it, and with a list of what is absent."""
    if one.trial is None:
        return one
    trial, derived = with_speeds(one.trial)
    absent = _absent(trial.header, trial.known_columns)
    names = tuple(dict.fromkeys([*one.report.columns, *trial.known_columns]))
    report = replace(one.report, columns=names, findings=(*absent, *derived, *one.report.findings))
    return Imported(trial, report)


def import_part(
    path: Path, one: SourceTable, given: ColumnMap, tell: Callable[[float], None]
) -> Imported:
    """Read one table, as far as it goes: what is absent in it may be in another one of the same run.

    Arguments and errors are those of ``import_tables``.
    """
    table = _with_time(one.table, given)
    findings: list[TableFinding] = [*one.findings]
    header = _header(path, one, given, findings)
    sources = complete_sources(given, header.names, table.names, path)
    mapped = given.form.from_arrays(one.arrays) if given.form else ()
    header = with_constants(header, one.arrays, sources, findings, mapped)
    names = tuple(dict.fromkeys(source.ours for source in sources))
    if "time_s" not in names:
        raise RecordError(
            f'{path} has no column time_s; name its time column in a map (--map): time_s = "name"; '
            f"its columns are {', '.join(table.names)}"
        )
    if len(names) < 2:
        raise RecordError(
            f"{path} has a time but no other known column; name its columns in a map (--map)"
        )
    used = {name: [s for s in sources if s.ours == name] for name in names}
    time_s = summed(table, used["time_s"], []).values
    in_time = _in_time(time_s)
    if len(in_time.order) == 0:
        raise RecordError(f"no row of {path} has a time")
    cut: list[TableFinding] = []
    order = _cut(table, given, in_time.order, cut)
    few = len(order) < max(given.cut.fewest_rows, 1)
    passed = _ColumnPass(in_time, tell)
    columns = levelled(passed.columns(table, used, order), findings)
    columns = posed(columns, given.body, findings)
    trial = None
    if few:
        for _ in columns:  # they are looked at all the same
            pass
        words = f"only {len(order)} rows are left by the map's [cut]: no trial"
        last = [TableFinding("short", "", len(order), 0, words)]
    else:
        trial = build_trial(header, columns)
        last = list(check_trial(trial, (order + 1).astype(np.float64)))
    findings += passed.unreadable
    findings += raw_findings(table, sources)
    findings += _unused(table, (*(s.theirs for s in sources), *given.cut.columns))
    names = tuple(name for name in names if name not in (*ORIENTATIONS, *IMU_QUATERNION))
    findings += [*passed.empty_rows(), *in_time.findings, *cut, *last]
    dropped = passed.dropped()
    report = ImportReport(path, one.name, table.rows, 0 if few else len(order), dropped, names,
                          tuple(findings))  # fmt: skip
    return Imported(trial, report)


def _with_time(table: DataTable, given: ColumnMap) -> DataTable:
    """Return the table with a column of times where the map has only their distance."""
    if not np.isfinite(given.period_s):
        return table
    time_s = np.arange(table.rows) * given.period_s
    return DataTable((TableColumn("time_s", time_s), *table.columns), table.rows)


def _cut(
    table: DataTable, given: ColumnMap, order: IntArray, findings: list[TableFinding]
) -> IntArray:
    """Return the rows that the map's cut leaves; the others are listed."""
    cut = given.cut
    if not cut.settled and not cut.moving:
        return order
    first, last = cut.rows(table)
    early, late = int((order < first).sum()), int((order >= last).sum())
    findings.append(TableFinding("cut", "", early + late, 1 if early else last + 1,
                            f"left out by the map's [cut]: {early} rows before it settled, {late} at "
                            "the end"))  # fmt: skip
    inside: IntArray = order[(order >= first) & (order < last)]
    return inside


def _header(
    path: Path, one: SourceTable, given: ColumnMap, findings: list[TableFinding]
) -> TrialHeader:
    header_file = path.with_suffix(".toml")
    ours = (*(source.ours for source in given.sources), *one.table.names)
    if given.form is not None:
        return given.form.header_of(path.stem, one.arrays)
    if given.header is not None:
        return given.header
    if header_file.is_file():
        return read_header(header_file, ours)
    words = f"no {header_file.name}: gait, rates, noise and machine are not known"
    findings.append(TableFinding("absent", "", 0, 0, words))
    return TrialHeader(LEGGED, joints_of({}, ours))


def _unused(table: DataTable, used: tuple[str, ...]) -> list[TableFinding]:
    words = "not a column of a trial, and the map does not name it"
    return [
        TableFinding("ignored", name, table.rows, 0, words)
        for name in table.names
        if name not in used
    ]


def _absent(header: TrialHeader, have: Collection[str]) -> list[TableFinding]:
    """Say which quantities are not there at all, and for which joints only some are missing."""
    findings = []
    for field, places in groupby(trial_places(header.names), key=lambda place: place.field):
        columns = [place.column for place in places]
        missing = [column for column in columns if column not in have]
        if missing and not (field in UNUSUAL and missing == columns):
            some = f"missing: {', '.join(missing)}"
            words = "not measured" if missing == columns else some
            findings.append(TableFinding("absent", field, len(missing), 0, words))
    return findings


@dataclass(frozen=True, slots=True, eq=False)
class _InTime:
    """Rows in order of time.

    Attributes:
        order: Rows to keep, in that order.
        timeless: Rows without a time.
        again: Rows at the time of another one that is kept, and
        first: those.
        findings: Whether they had to be put in order.
    """

    order: IntArray
    timeless: IntArray
    again: IntArray
    first: IntArray
    findings: tuple[TableFinding, ...]


def _in_time(time_s: FloatArray) -> _InTime:
    """Put rows in order of time, one at each time."""
    rows = np.flatnonzero(np.isfinite(time_s))
    back = np.diff(time_s[rows]) < 0
    findings = []
    if back.any():
        first = int(rows[1:][back][0]) + 1
        findings.append(TableFinding("order", "time_s", int(back.sum()), first,
                                "time goes back; rows were put in order of time"))  # fmt: skip
    order = rows[np.argsort(time_s[rows], kind="stable")]
    keep = np.concatenate([[True], np.diff(time_s[order]) > 0])[: len(order)]
    first_of = order[keep][np.cumsum(keep) - 1]
    timeless = np.flatnonzero(~np.isfinite(time_s))
    return _InTime(order[keep], timeless, order[~keep], first_of[~keep], tuple(findings))


class _ColumnPass:
    """Takes one column after the other into memory, and notes what is odd about them."""

    def __init__(self, in_time: _InTime, tell: Callable[[float], None]) -> None:
        self._tell = tell
        self.unreadable: list[TableFinding] = []
        self._in_time = in_time
        self._empty: BoolArray | None = None  # rows in which nothing was measured so far
        self._same = np.ones(len(in_time.again), dtype=bool)

    def columns(
        self, table: DataTable, used: Mapping[str, list[Source]], order: IntArray
    ) -> Iterator[TableColumn]:
        """Yield our columns in the order of their rows."""
        for number, (name, sources) in enumerate(used.items()):
            self._tell(number / len(used))
            values = summed(table, sources, self.unreadable).values
            if name != "time_s" and not name.startswith("command_"):
                absent = np.isnan(values)
                self._empty = absent if self._empty is None else self._empty & absent
            one, other = values[self._in_time.again], values[self._in_time.first]
            self._same &= (one == other) | (np.isnan(one) & np.isnan(other))
            yield TableColumn(name, values[order])

    def empty_rows(self) -> list[TableFinding]:
        """List rows with a time and nothing that was measured, once all columns have passed."""
        if self._empty is None or not self._empty.any():
            return []
        count, first = int(self._empty.sum()), int(np.argmax(self._empty)) + 1
        return [TableFinding("empty", "", count, first, "rows in which nothing was measured")]

    def dropped(self) -> tuple[DroppedRow, ...]:
        """Return the rows that were left out, once all columns have passed."""
        rows = [DroppedRow(row + 1, "it has no time") for row in self._in_time.timeless.tolist()]
        again = zip(self._in_time.again, self._in_time.first, self._same, strict=True)
        for row, original, same in again:
            words = "a copy of" if same else "another row at the time of"
            rows.append(DroppedRow(int(row) + 1, f"{words} row {original + 1}"))
        return tuple(sorted(rows, key=lambda item: item.row))
