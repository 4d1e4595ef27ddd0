"""Bringing a table of measured data in: columns mapped, time put in order, everything odd reported.

Nothing is dropped without being listed. Values are not changed but for the units of the map; rows out of
order are put in order; rows without a time, second rows at one time, and rows that the map cuts off are
dropped and listed.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model.errors import RecordError
from model.signals import IntArray
from record.column_map import ColumnMap, Source, complete_sources
from record.column_values import summed
from record.raw_check import empty_rows, raw_findings
from record.source_tables import SourceTable, read_tables
from record.table_check import Finding, check_trial
from record.table_file import Column, Table
from record.trial import Trial, build_trial, trial_places, trial_table
from record.trial_toml import LEGGED, TrialHeader, TrialNoise, joints_of, read_header


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
    findings: tuple[Finding, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Imported:
    """One table brought in.

    Attributes:
        trial: The trial; None where the map cuts off so much that none is left.
        report: How it went.
    """

    trial: Trial | None
    report: ImportReport


def import_table(path: Path, given: ColumnMap) -> tuple[Trial, ImportReport]:
    """Read a file that holds one table into a trial.

    Args:
        path: A trial's table or NAME.toml, or somebody else's .csv, .parquet or .npz.
        given: Which of its columns is which; empty if they have our names.

    Raises:
        RecordError: It cannot be read, has no time, nothing in it is known, or it holds several tables.
    """
    (first, *more) = import_tables(path, given)
    if more:
        raise RecordError(f"{path} holds {1 + len(more)} tables; give a folder with --out FOLDER")
    if first.trial is None:
        raise RecordError(f"{path}: the map's [cut] leaves {first.report.kept} rows and no trial")
    return first.trial, first.report


def import_tables(path: Path, given: ColumnMap) -> Iterator[Imported]:
    """Read every table of a file into a trial of its own.

    Args:
        path: A trial's table or NAME.toml, or somebody else's .csv, .parquet or .npz.
        given: Which of its columns is which; empty if they have our names.

    Raises:
        RecordError: It cannot be read, has no time, or nothing in it is known.
    """
    if path.suffix != ".npz":
        path = trial_table(path)
    for one in read_tables(path, given):
        yield _import(path, one, given)


def _import(path: Path, one: SourceTable, given: ColumnMap) -> Imported:
    table = _with_time(one.table, given)
    findings: list[Finding] = [*one.findings]
    header = _header(path, table, given, findings)
    sources = complete_sources(given, header.joints, table.names, path)
    names = tuple(dict.fromkeys(source.ours for source in sources))
    if "time_s" not in names:
        raise RecordError(
            f'{path} has no column time_s; name theirs in a map (--map): time_s = "their name"; '
            f"there are {', '.join(table.names)}"
        )
    columns = [summed(table, [s for s in sources if s.ours == name], findings) for name in names]
    if len(columns) < 2:
        raise RecordError(f"{path} has a time and no column that we know; map its columns (--map)")
    findings += raw_findings(table, sources)
    findings += _unused(table, (*(s.theirs for s in sources), *given.cut.columns))
    findings += _absent(header, sources)
    findings += empty_rows(names, [column.values for column in columns])
    order, dropped = _in_time(columns, findings)
    if len(order) == 0:
        raise RecordError(f"no row of {path} has a time")
    order = _cut(table, given, order, findings)
    few = len(order) < max(given.cut.fewest_rows, 1)
    trial = None
    if few:
        words = f"only {len(order)} rows are left by the map's [cut]: no trial"
        findings.append(Finding("short", "", len(order), 0, words))
    else:
        trial = build_trial(header, tuple(Column(c.name, c.values[order]) for c in columns))
        findings += check_trial(trial, (order + 1).astype(np.float64))
    report = ImportReport(path, one.name, table.rows, 0 if few else len(order), dropped, names,
                          tuple(findings))  # fmt: skip
    return Imported(trial, report)


def _with_time(table: Table, given: ColumnMap) -> Table:
    """Return the table with a column of times where the map has only their distance."""
    if not np.isfinite(given.period_s):
        return table
    time_s = np.arange(table.rows) * given.period_s
    return Table((Column("time_s", time_s), *table.columns))


def _cut(table: Table, given: ColumnMap, order: IntArray, findings: list[Finding]) -> IntArray:
    """Return the rows that the map's cut leaves; the others are listed."""
    cut = given.cut
    if not cut.settled and not cut.moving:
        return order
    first, last = cut.rows(table)
    early, late = int((order < first).sum()), int((order >= last).sum())
    findings.append(Finding("cut", "", early + late, 1 if early else last + 1,
                            f"left out by the map's [cut]: {early} rows before it settled, {late} at "
                            "the end"))  # fmt: skip
    inside: IntArray = order[(order >= first) & (order < last)]
    return inside


def _header(path: Path, table: Table, given: ColumnMap, findings: list[Finding]) -> TrialHeader:
    beside = path.with_suffix(".toml")
    ours = (*(source.ours for source in given.sources), *table.names)
    if given.header is not None:
        return given.header
    if beside.is_file():
        return read_header(beside, ours)
    findings.append(Finding("absent", "", 0, 0,
                            f"no {beside.name}: gait, rates, noise and machine are not known"))  # fmt: skip
    nothing = float("nan")
    joints = joints_of({}, ours)
    return TrialHeader(LEGGED, joints, "", nothing, nothing, "", TrialNoise(), "", "")


def _unused(table: Table, used: tuple[str, ...]) -> list[Finding]:
    return [
        Finding(
            "ignored", name, table.rows, 0, "not a column of a trial, and the map does not name it"
        )
        for name in table.names
        if name not in used
    ]


def _absent(header: TrialHeader, sources: tuple[Source, ...]) -> list[Finding]:
    """Say which quantities are not there at all, and for which joints only some are missing."""
    have = {source.ours for source in sources}
    groups: dict[str, list[str]] = {}
    total: dict[str, int] = {}
    for place in trial_places(header.joints):
        total[place.field] = total.get(place.field, 0) + 1
        if place.column not in have:
            groups.setdefault(place.field, []).append(place.column)
    findings = []
    for field, columns in groups.items():
        words = "not measured" if len(columns) == total[field] else f"missing: {', '.join(columns)}"
        findings.append(Finding("absent", field, len(columns), 0, words))
    return findings


def _in_time(
    columns: list[Column], findings: list[Finding]
) -> tuple[IntArray, tuple[DroppedRow, ...]]:
    """Return the rows to keep in order of time, and those left out."""
    time_s = next(c.values for c in columns if c.name == "time_s")
    dropped = [
        DroppedRow(int(row) + 1, "it has no time") for row in np.flatnonzero(~np.isfinite(time_s))
    ]
    rows = np.flatnonzero(np.isfinite(time_s))
    back = np.diff(time_s[rows]) < 0
    if back.any():
        first = int(rows[1:][back][0]) + 1
        findings.append(Finding("order", "time_s", int(back.sum()), first,
                                "time goes back; rows were put in order of time"))  # fmt: skip
    order = rows[np.argsort(time_s[rows], kind="stable")]
    keep = np.concatenate([[True], np.diff(time_s[order]) > 0])[: len(order)]
    first_of = order[keep][np.cumsum(keep) - 1]
    for row, original in zip(order[~keep], first_of[~keep], strict=True):
        same = all(
            np.array_equal(c.values[row], c.values[original], equal_nan=True) for c in columns
        )
        words = "a copy of" if same else "another row at the time of"
        dropped.append(DroppedRow(int(row) + 1, f"{words} row {original + 1}"))
    kept: IntArray = order[keep]
    return kept, tuple(sorted(dropped, key=lambda item: item.row))
