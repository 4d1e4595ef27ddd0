"""Which rows of a table make the trial: behind the last one where things still move otherwise.

    [cut]
    settled = [{ columns = ["7", "8", "9"], norm_below = 1.5 }, { columns = ["6"], from_end_below = 0.003 }]
    moving = [{ columns = ["10", "11"], norm_above = 0.05 }]
    fewest_rows = 24

The trial begins behind the last row in which one of ``settled`` does not hold, and ends with the last row
in which ``moving`` holds. A table with fewer rows than ``fewest_rows`` in between gives no trial, and is
listed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from model.errors import RecordError
from model.values.arrays import BoolArray
from record.trial.header import check_keys
from record.trial.table_file import Table

# What is compared: the norm of the columns, or how far they are from their median over the last rows.
TESTS = ("norm_below", "norm_above", "from_end_below")
LAST_ROWS = 5


@dataclass(frozen=True, slots=True)
class Condition:
    """One condition on a row.

    Attributes:
        columns: Their columns.
        test: One of ``TESTS``.
        limit: What it compares with, in their unit.
    """

    columns: tuple[str, ...]
    test: str
    limit: float

    def holds(self, table: Table) -> BoolArray:
        """Return whether it holds in each row, (T,); false where a value is missing."""
        values = np.column_stack([table.numbers(name) for name in self.columns])
        if self.test == "from_end_below":
            values = values - np.nanmedian(values[-LAST_ROWS:], axis=0)
        size = np.linalg.norm(values, axis=1)
        held = size > self.limit if self.test == "norm_above" else size < self.limit
        return np.asarray(held, dtype=np.bool_)


@dataclass(frozen=True, slots=True)
class Cut:
    """The rows that make a trial.

    Attributes:
        settled: All of them hold from the first row on.
        moving: All of them hold in the last row.
        fewest_rows: With fewer rows there is no trial.
    """

    settled: tuple[Condition, ...] = ()
    moving: tuple[Condition, ...] = ()
    fewest_rows: int = 0

    @property
    def columns(self) -> tuple[str, ...]:
        """Their columns that it looks at."""
        return tuple(dict.fromkeys(c for one in (*self.settled, *self.moving) for c in one.columns))

    def rows(self, table: Table) -> tuple[int, int]:
        """Return the first row and the one behind the last."""
        calm = _all(self.settled, table)
        last_unsettled = np.flatnonzero(~calm)
        first = int(last_unsettled[-1]) + 1 if len(last_unsettled) else 0
        live = np.flatnonzero(_all(self.moving, table)[first:])
        return first, first + int(live[-1]) + 1 if len(live) else first


def _all(conditions: Sequence[Condition], table: Table) -> BoolArray:
    held = np.ones(table.rows, dtype=np.bool_)
    for one in conditions:
        held &= one.holds(table)
    return held


def parse_cut(data: Any, path: Path) -> Cut:
    """Read the table [cut].

    Raises:
        RecordError: Something in it means nothing.
    """
    check_keys(data, ("settled", "moving", "fewest_rows"), path, "cut.")
    fewest = data.get("fewest_rows", 0)
    if isinstance(fewest, bool) or not isinstance(fewest, int) or fewest < 0:
        raise RecordError(f"{path}: cut.fewest_rows must be a whole number from 0, not {fewest!r}")
    settled, moving = (_conditions(data, key, path) for key in ("settled", "moving"))
    return Cut(settled, moving, fewest)


def _conditions(data: Mapping[str, Any], key: str, path: Path) -> tuple[Condition, ...]:
    entries = data.get(key, [])
    if not isinstance(entries, list):
        raise RecordError(f"{path}: cut.{key} must be a list of conditions")
    return tuple(_condition(entry, f"cut.{key}", path) for entry in entries)


def _condition(entry: Any, place: str, path: Path) -> Condition:
    check_keys(entry, ("columns", *TESTS), path, f"{place}.")
    columns = entry.get("columns")
    tests = [name for name in TESTS if name in entry]
    if not isinstance(columns, list) or not columns or len(tests) != 1:
        raise RecordError(f"{path}: {place} needs columns = [...] and one of {', '.join(TESTS)}")
    limit = entry[tests[0]]
    if isinstance(limit, bool) or not isinstance(limit, int | float):
        raise RecordError(f"{path}: {place}.{tests[0]} must be a number, not {limit!r}")
    return Condition(tuple(str(name) for name in columns), tests[0], float(limit))
