"""Which rows of a table make the trial: the rows after the last one in which something still moves.

    [cut]
    settled = [{ columns = ["7", "8", "9"], norm_below = 1.5 }, { columns = ["6"], from_end_below = 0.003 }]
    moving = [{ columns = ["10", "11"], norm_above = 0.05 }]
    fewest_rows = 24

The trial begins behind the last row in which one of ``settled`` does not hold, and ends with the last row
in which ``moving`` holds. A table with fewer rows than ``fewest_rows`` in between gives no trial, and is
listed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.errors import ConfigError
from model.parameters.toml_table import Table as TomlTable
from model.values.arrays import BoolArray
from record.trial.table_file import DataTable

# What is compared: the norm of the columns, or how far they are from their median over the last rows.
TESTS = ("norm_below", "norm_above", "from_end_below")
LAST_ROWS = 5


@dataclass(frozen=True, slots=True)
class RowCondition:
    """One condition on a row.

    Attributes:
        columns: Their columns.
        test: One of ``TESTS``.
        limit: What it compares with, in their unit.
    """

    columns: tuple[str, ...]
    test: str
    limit: float

    def holds(self, table: DataTable) -> BoolArray:
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

    settled: tuple[RowCondition, ...] = ()
    moving: tuple[RowCondition, ...] = ()
    fewest_rows: int = 0

    @property
    def columns(self) -> tuple[str, ...]:
        """Their columns that it looks at."""
        return tuple(dict.fromkeys(c for one in (*self.settled, *self.moving) for c in one.columns))

    def rows(self, table: DataTable) -> tuple[int, int]:
        """Return the first row and the one behind the last."""
        calm = _all(self.settled, table)
        last_unsettled = np.flatnonzero(~calm)
        first = int(last_unsettled[-1]) + 1 if len(last_unsettled) else 0
        live = np.flatnonzero(_all(self.moving, table)[first:])
        return first, first + int(live[-1]) + 1 if len(live) else first


def _all(conditions: Sequence[RowCondition], table: DataTable) -> BoolArray:
    held = np.ones(table.rows, dtype=np.bool_)
    for one in conditions:
        held &= one.holds(table)
    return held


def read_cut(table: TomlTable) -> Cut:
    """Read the table [cut].

    Raises:
        ConfigError: Something in it means nothing.
    """
    settled, moving = (
        tuple(_condition(one) for one in table.tables(key)) for key in ("settled", "moving")
    )
    fewest = table.integer("fewest_rows", minimum=0, maximum=10**9, otherwise=0)
    table.done()
    return Cut(settled, moving, fewest)


def _condition(table: TomlTable) -> RowCondition:
    columns = table.texts("columns")
    tests = [name for name in TESTS if table.has(name)]
    if not columns or len(tests) != 1:
        raise ConfigError(
            table.name("columns"), f"needs columns = [...] and one of {', '.join(TESTS)}"
        )
    condition = RowCondition(columns, tests[0], table.number(tests[0]))
    table.done()
    return condition
