"""Tables as Parquet and CSV files: written a block at a time, read whole, numbers exact.

A sample that is missing is NaN in Parquet and an empty field in CSV.
"""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from model.errors import RecordError
from model.values.arrays import FloatArray
from record.whole_file import whole_file, writing

SUFFIXES = (".parquet", ".csv")
BLOCK_ROWS = 10_000  # written at once: a table may be larger than what memory there is
MISSING_TEXTS = ("", "nan", "NaN", "NAN", "NA", "N/A", "null", "NULL", "None", "-nan", "#N/A")


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """One column: its name and a value a row, (T,); texts are an object array."""

    name: str
    values: NDArray[Any]


class AnyColumn(Protocol):
    """A column in memory, or one that is read when its values are asked for."""

    @property
    def name(self) -> str:
        """Its name."""
        ...

    @property
    def values(self) -> NDArray[Any]:
        """A value a row, (T,)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A table of numbers and texts.

    Attributes:
        columns: Columns in the order of the file.
        rows: Number of rows.
    """

    columns: tuple[AnyColumn, ...]
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
                        f"column {name} holds text that is no number; correct it, or map another"
                    )
                return values.astype(np.float64)
        raise RecordError(f"there is no column {name}; there are {', '.join(self.names)}")


def check_suffix(path: Path) -> None:
    """Refuse a file that is no table.

    Raises:
        RecordError: It ends in something else.
    """
    if path.suffix not in SUFFIXES:
        raise RecordError(f"{path} must end in .parquet or .csv")


class TableWriter:
    """Writes a table block by block; the file appears under its name when it is complete.

    Args:
        path: A .parquet or .csv file.

    Raises:
        RecordError: It is neither, or cannot be written (from any method).
    """

    def __init__(self, path: Path) -> None:
        check_suffix(path)
        self.rows = 0
        self._path = path
        self._closing = ExitStack()
        self._sink: Any = None

    def write(self, columns: Sequence[Column]) -> None:
        """Write the next rows; every block has the same columns."""
        csv = self._path.suffix == ".csv"
        arrays = [_arrow(column.values, nan_is_null=csv) for column in columns]
        self.write_batch(pa.RecordBatch.from_arrays(arrays, names=[c.name for c in columns]))

    def write_batch(self, batch: Any) -> None:
        """Write rows that are Arrow's already."""
        with writing(self._path):
            if self._sink is None:
                self._sink = self._closing.enter_context(self._open(batch.schema))
            self._sink.write_batch(batch)
        self.rows += batch.num_rows

    def _open(self, schema: Any) -> Any:
        if self._path.suffix == ".csv":
            return pacsv.CSVWriter(str(self._part), schema)
        return pq.ParquetWriter(str(self._part), schema, compression="zstd")

    def __enter__(self) -> "TableWriter":
        self._part = self._closing.enter_context(whole_file(self._path))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Finish the file, or leave none behind after an error."""
        with writing(self._path):
            self._closing.__exit__(kind, error, trace)


def _arrow(values: NDArray[Any], *, nan_is_null: bool) -> Any:
    if values.dtype.kind == "f":
        return pa.array(values, mask=np.isnan(values) if nan_is_null else None)
    return pa.array(values.tolist() if values.dtype.kind == "O" else values)


def write_table(path: Path, columns: Sequence[Column]) -> None:
    """Write a table at once.

    Raises:
        RecordError: The file cannot be written.
    """
    rows = len(columns[0].values) if columns else 0
    with TableWriter(path) as writer:
        for first in range(0, max(rows, 1), BLOCK_ROWS):
            block = slice(first, first + BLOCK_ROWS)
            writer.write([Column(column.name, column.values[block]) for column in columns])


def read_table(path: Path, delimiter: str = ",", *, numbers: bool = False) -> Table:
    """Read a table.

    Args:
        path: A .parquet or .csv file.
        delimiter: Between the fields of a CSV file.
        numbers: Every column of a CSV file is numbers, which are then exact (-0 and 20 digits too); else
            its kind is found from what it holds.

    Raises:
        RecordError: It cannot be read, or has two columns of one name.
    """
    check_suffix(path)
    if not path.is_file():
        raise RecordError(f"the table {path} cannot be read: there is no such file")
    try:
        csv = path.suffix == ".csv"
        table = _read_csv(path, delimiter, numbers=numbers) if csv else pq.read_table(path)
    except (OSError, pa.ArrowException) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise RecordError(f"the table {path} cannot be read: {reason}") from error
    names = once_named(path, table.column_names)
    columns = (Column(name, to_numpy(table.column(at))) for at, name in enumerate(names))
    return Table(tuple(columns), table.num_rows)


def once_named(path: Path, names: list[str]) -> list[str]:
    """Return the names of columns.

    Raises:
        RecordError: Two are the same.
    """
    for name in names:
        if names.count(name) > 1:
            raise RecordError(f"{path} has two columns {name}; name each column once")
    return names


def _read_csv(path: Path, delimiter: str, *, numbers: bool) -> Any:
    parse = pacsv.ParseOptions(delimiter=delimiter)
    kinds = {}
    if numbers:
        with pacsv.open_csv(path, parse_options=parse) as reader:
            kinds = dict.fromkeys(reader.schema.names, pa.float64())
    return pacsv.read_csv(
        path,
        parse_options=parse,
        convert_options=pacsv.ConvertOptions(
            null_values=list(MISSING_TEXTS), strings_can_be_null=True, column_types=kinds
        ),
    )


def to_numpy(column: Any) -> NDArray[Any]:
    """Return Arrow's column as numbers, NaN where there is none, or as texts."""
    kind = column.type
    if pa.types.is_integer(kind) and column.null_count == 0:
        return np.asarray(column.to_numpy(), dtype=np.int64)
    if pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_null(kind):
        return np.asarray(column.cast(pa.float64()).to_numpy(), dtype=np.float64)
    if pa.types.is_boolean(kind):
        return np.asarray(column.cast(pa.int8()).cast(pa.float64()).to_numpy(), dtype=np.float64)
    values = np.empty(len(column), dtype=object)
    values[:] = [str(value) if value is not None else "" for value in column.to_pylist()]
    return values


def copy_table(path: Path, out: Path, names: Sequence[str]) -> None:
    """Copy some columns of a Parquet file into another table, in bounded memory.

    Raises:
        RecordError: The file cannot be written.
    """
    with TableWriter(out) as writer:
        for batch in pq.ParquetFile(path).iter_batches(batch_size=4096, columns=list(names)):
            writer.write([Column(n, batch.column(n).to_numpy(zero_copy_only=False)) for n in names])
