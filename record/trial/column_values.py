"""Values of somebody's column in our unit and with their sign."""

from datetime import UTC, datetime

import numpy as np

from model.values.arrays import FloatArray
from record.trial.column_map import Source
from record.trial.table_check import Finding
from record.trial.table_file import Column, Table


def summed(table: Table, sources: list[Source], findings: list[Finding]) -> Column:
    """Return one of our columns: the sum of what the map names for it.

    Args:
        table: Theirs.
        sources: What the map names for this column, at least one.
        findings: What is no number is added here.
    """
    values = np.zeros(table.rows)
    for one in sources:
        values += _values(table, one, findings)
    return Column(sources[0].ours, values)


def _values(table: Table, source: Source, findings: list[Finding]) -> FloatArray:
    """Return a column in our unit; what is no number in it becomes NaN and is listed."""
    given = next(c for c in table.columns if c.name == source.theirs).values
    if given.dtype.kind == "O":
        values = _parse(Column(source.theirs, given), findings, stamps=source.stamps)
    else:
        values = given.astype(np.float64)
    if source.sign_bit >= 0:
        level = 2.0**source.sign_bit
        values = np.where(values >= level, level - values, values)
    if source.signed_bits > 0:
        level = 2.0**source.signed_bits
        values = np.where(values >= 0.5 * level, values - level, values)
    if np.isfinite(source.beyond):
        away = values - source.rest
        side = np.where(np.abs(away) > source.beyond, np.sign(away), 0.0)
        values = np.where(np.isfinite(away), side, np.nan)
    elif source.stamps:
        known = values[np.isfinite(values)]
        values = values - (known[0] if len(known) else 0.0)
    return np.asarray(values * source.factor + source.offset)


def _parse(column: Column, findings: list[Finding], *, stamps: bool) -> FloatArray:
    values = np.full(len(column.values), np.nan)
    bad: list[int] = []
    for row, text in enumerate(column.values):
        try:
            if text:
                values[row] = _seconds(text) if stamps else float(text)
        except ValueError:
            bad.append(row)
    if bad:
        shown = ", ".join(f"row {row + 1} {column.values[row]!r}" for row in bad[:5])
        more = f" and {len(bad) - 5} more" if len(bad) > 5 else ""
        findings.append(Finding("unreadable", column.name, len(bad), bad[0] + 1,
                                f"no numbers, taken as missing: {shown}{more}"))  # fmt: skip
    return values


def _seconds(stamp: str) -> float:
    """Return UNIX seconds of a date with time; without a zone it is UTC."""
    when = datetime.fromisoformat(stamp)
    return (when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()
