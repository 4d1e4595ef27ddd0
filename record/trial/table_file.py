"""Tables as Parquet and CSV files: read whole or column by column, exact numbers.

A sample that is missing is NaN in Parquet and an empty field in CSV.
"""

import re
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.errors import RecordError
from model.values.arrays import FloatArray
from model.values.machine_names import MachineNames
from record.trial.csv_file import (
    copy_csv,
    csv_names,
    read_csv,
    values_of_texts,
)
from record.trial.foreign_file import foreign_file
from record.trial.parquet_file import (
    ParquetTable,
    parquet_table,
)

SUFFIXES = (".parquet", ".csv")
BLOCK_ROWS = (
    10_000  # in memory before they are written: a table may be larger than what memory there is
)
Names = str | tuple[str, ...]
_PLACE = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True, slots=True, eq=False)
class TableColumn:
    """One column: its name and a value a row, (T,); texts are an object array."""

    name: str
    values: NDArray[Any]


def column_names(names: Names, machine: MachineNames) -> Iterator[str]:
    """Yield the names of an array's columns.

    Args:
        names: One name with a place in braces for every axis: ``{joint}`` for the joints, ``{leg}`` for the
            legs, other letters for each of themselves (``{xyz}``). Or the names of one axis.
        machine: Names of the joints and legs.
    """
    form = _PLACE.sub("{}", names) if isinstance(names, str) else "{}"
    return (form.format(*words) for words in product(*axis_words(names, machine)))


def axis_words(names: Names, machine: MachineNames) -> list[Sequence[str]]:
    """Return what the places along each axis are called; arguments as of ``column_names``."""
    if isinstance(names, tuple):
        return [names]
    parts = {"joint": machine.joints, "leg": machine.legs}
    return [parts.get(word, word) for word in _PLACE.findall(names)]


@dataclass(frozen=True, slots=True, eq=False)
class StoredColumn:
    """A column of a file that is read each time its values are asked for.

    Attributes:
        name: The column.
        at: Where it is among the file's columns.
        table: The open file.
        path: The file that was asked for, for messages.
    """

    name: str
    at: int
    table: ParquetTable
    path: Path

    @property
    def values(self) -> NDArray[Any]:
        """A value a row, (T,); texts are an object array.

        Raises:
            RecordError: It is damaged.
        """
        with foreign_file(f"the table {self.path} cannot be read"):
            values = self.table.values(self.at)
            return values_of_texts(values) if self.path.suffix == ".csv" else values


@dataclass(frozen=True, slots=True, eq=False)
class DataTable:
    """A table of numbers and texts.

    Attributes:
        columns: Columns in the order of the file.
        rows: Number of rows.
    """

    columns: tuple[TableColumn | StoredColumn, ...]
    rows: int

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(column.name for column in self.columns)

    def numbers(self, name: str) -> FloatArray:
        """Return a column of numbers, NaN where there is none.

        Raises:
            RecordError: There is no such column, or it holds text.
        """
        for column in self.columns:
            if column.name == name:
                values = column.values
                if values.dtype.kind not in "fiub":
                    raise RecordError(
                        f"column {name} holds text that is no number, {_first_text(values)!r}; correct it, "
                        "or map another"
                    )
                return values.astype(np.float64)
        raise RecordError(f"there is no column {name}; there are {', '.join(self.names)}")


def _first_text(values: NDArray[Any]) -> str:
    """Return the first of a column's texts that is no number."""
    for text in map(str, values):
        try:
            float(text or "nan")
        except ValueError:
            return text
    return ""


def check_suffix(path: Path) -> None:
    """Refuse a file that is no table.

    Raises:
        RecordError: It ends in something else.
    """
    if path.suffix not in SUFFIXES:
        raise RecordError(f"{path} must end in .parquet or .csv")


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    check_suffix(path)
    if not path.is_file():
        raise RecordError(f"the table {path} cannot be read: there is no such file")
    with foreign_file(f"the table {path} cannot be read"):
        yield


def _once_named(path: Path, names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if names.count(name) > 1:
            raise RecordError(f"{path} has two columns {name}; name each column once")
    return names


def read_table(path: Path, *, numbers: bool = False) -> DataTable:
    """Read a table into memory.

    Args:
        path: A .parquet or .csv file.
        numbers: Every column of a CSV file is numbers, which are then exact (-0 and 20 digits too); else
            its kind is found from what it holds.

    Raises:
        RecordError: It cannot be read, or has two columns of one name.
    """
    with _reading(path):
        if path.suffix == ".csv":
            names = _once_named(path, csv_names(path, ","))
            arrays = read_csv(path, names, ",", numbers=numbers)
        else:
            table = parquet_table(path)
            names, arrays = _once_named(path, table.names), table.all_values()
    return DataTable(tuple(map(TableColumn, names, arrays)), len(arrays[0]) if arrays else 0)


@contextmanager
def open_table(path: Path, delimiter: str = ",") -> Iterator[DataTable]:
    """Open a large table: only the column that is asked for is in memory.

    A Parquet file is read where it lies. A CSV file is first copied, a block at a time, to a Parquet file
    that is removed afterwards: its columns lie across all of its lines.

    Args:
        path: A .parquet or .csv file.
        delimiter: Between the fields of a CSV file.

    Raises:
        RecordError: It cannot be read, or has two columns of one name.
    """
    with tempfile.TemporaryDirectory(prefix="bigant-") as folder:
        with _reading(path):
            if path.suffix == ".csv":
                names = _once_named(path, csv_names(path, delimiter))
                source = Path(folder) / "table.parquet"
                copy_csv(path, source, len(names), delimiter)
                table = parquet_table(source)
            else:
                table = parquet_table(path)
                names = _once_named(path, table.names)
        columns = (StoredColumn(name, at, table, path) for at, name in enumerate(names))
        yield DataTable(tuple(columns), table.rows)
