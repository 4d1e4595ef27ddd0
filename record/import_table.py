"""Bringing a table of measured data in: columns mapped, time put in order, everything odd reported.

Nothing is dropped without being listed. Values are not changed but for the units of the map; rows out of
order are put in order; rows without a time, and second rows at one time, are dropped and listed.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model.errors import RecordError
from model.signals import FloatArray, IntArray
from record.column_map import ColumnMap, Source, complete_sources
from record.table_check import Finding, check_trial
from record.table_file import Column, Table, read_table
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
        rows: Rows in it.
        kept: Rows in the trial.
        dropped: Rows left out.
        columns: Our columns that were filled.
        findings: Everything odd.
    """

    path: Path
    rows: int
    kept: int
    dropped: tuple[DroppedRow, ...]
    columns: tuple[str, ...]
    findings: tuple[Finding, ...]


def import_table(path: Path, given: ColumnMap) -> tuple[Trial, ImportReport]:
    """Read a table into a trial.

    Args:
        path: A trial's table or NAME.toml, or somebody else's .csv or .parquet.
        given: Which of its columns is which; empty if they have our names.

    Raises:
        RecordError: It cannot be read, has no time, or nothing in it is known.
    """
    path = trial_table(path)
    table = read_table(path, given.delimiter)
    findings: list[Finding] = []
    header = _header(path, table, given, findings)
    sources = complete_sources(given, header.joints, table.names, path)
    if "time_s" not in {source.ours for source in sources}:
        raise RecordError(
            f'{path} has no column time_s; name theirs in a map (--columns): time_s = "their name"; '
            f"there are {', '.join(table.names)}"
        )
    columns = [_column(table, source, findings) for source in sources]
    if len(columns) < 2:
        raise RecordError(
            f"{path} has a time and no column that we know; map its columns (--columns)"
        )
    findings += _unused(table, sources)
    findings += _absent(header, sources)
    order, dropped = _in_time(columns, findings)
    if len(order) == 0:
        raise RecordError(f"no row of {path} has a time")
    trial = build_trial(header, tuple(Column(c.name, c.values[order]) for c in columns))
    findings += check_trial(trial, (order + 1).astype(np.float64))
    names = tuple(source.ours for source in sources)
    return trial, ImportReport(path, table.rows, len(order), dropped, names, tuple(findings))


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


def _column(table: Table, source: Source, findings: list[Finding]) -> Column:
    """Return a column in our unit; what is no number in it becomes NaN and is listed."""
    column = next(c for c in table.columns if c.name == source.theirs)
    if column.values.dtype.kind == "O":
        values = _parse(column, findings)
    else:
        values = column.values.astype(np.float64)
    return Column(source.ours, values * source.factor + source.offset)


def _parse(column: Column, findings: list[Finding]) -> FloatArray:
    values = np.full(len(column.values), np.nan)
    bad: list[int] = []
    for row, text in enumerate(column.values):
        try:
            values[row] = float(text) if text else np.nan
        except ValueError:
            bad.append(row)
    if bad:
        shown = ", ".join(f"row {row + 1} {column.values[row]!r}" for row in bad[:5])
        more = f" and {len(bad) - 5} more" if len(bad) > 5 else ""
        findings.append(Finding("unreadable", column.name, len(bad), bad[0] + 1,
                                f"no numbers, taken as missing: {shown}{more}"))  # fmt: skip
    return values


def _unused(table: Table, sources: tuple[Source, ...]) -> list[Finding]:
    used = {source.theirs for source in sources}
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
