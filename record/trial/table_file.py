"""Tables as Parquet and CSV files: written block by block, read whole or column by column, exact numbers.

A sample that is missing is NaN in Parquet and an empty field in CSV.
"""

import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from model.errors import RecordError
from model.values.arrays import FloatArray
from model.values.machine_names import MachineNames
from record.trial.foreign_file import foreign_file
from record.whole_file import whole_file

SUFFIXES = (".parquet", ".csv")
BLOCK_ROWS = 10_000  # written at once: a table may be larger than what memory there is
BLOCK_BYTES = 1 << 22  # of a CSV file, read at once
MISSING_TEXTS = ("", "nan", "NaN", "NAN", "NA", "N/A", "null", "NULL", "None", "-nan", "#N/A")
Names = str | tuple[str, ...]
_PLACE = re.compile(r"\{(\w+)\}")
_COLUMN = re.compile(r"CSV column #(\d+)")


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


class StoredColumn:
    """A column of a Parquet file that is read each time its values are asked for.

    Args:
        file: The open file.
        path: Its name, for messages.
        name: The column.
    """

    def __init__(self, file: Any, path: Path, name: str) -> None:
        self.name = name
        self._file = file
        self._path = path

    @property
    def values(self) -> NDArray[Any]:
        """A value a row, (T,); texts are an object array.

        Raises:
            RecordError: It is damaged.
        """
        with foreign_file(f"the table {self._path} cannot be read"):
            return to_numpy(self._file.read(columns=[self.name], use_threads=False).column(0))


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
    """Writes a table block by block; made by ``table_writer``."""

    def __init__(self, part: Path) -> None:
        self.rows = 0
        self._part = part
        self._sink: Any = None

    def write(self, columns: Sequence[TableColumn]) -> None:
        """Write the next rows; every block has the same columns."""
        csv = self._part.suffix == ".csv"
        arrays = [_arrow(column.values, nan_is_null=csv) for column in columns]
        self.write_batch(pa.RecordBatch.from_arrays(arrays, names=[c.name for c in columns]))

    def write_batch(self, batch: Any) -> None:
        """Write rows that are Arrow's already."""
        if self._sink is None:
            self._sink = self._open(batch.schema)
        self._sink.write_batch(batch)
        self.rows += batch.num_rows

    def _open(self, schema: Any) -> Any:
        if self._part.suffix == ".csv":
            return pacsv.CSVWriter(str(self._part), schema)
        return pq.ParquetWriter(str(self._part), schema, compression="zstd")

    def close(self) -> None:
        """Finish the file."""
        if self._sink is not None:
            self._sink.close()


@contextmanager
def table_writer(path: Path) -> Iterator[TableWriter]:
    """Yield a writer of a table; the file appears under its name when the block is done.

    Args:
        path: A .parquet or .csv file.

    Raises:
        RecordError: It is neither, or cannot be written.
    """
    check_suffix(path)
    with whole_file(path) as part, closing(TableWriter(part)) as writer:
        yield writer


def _arrow(values: NDArray[Any], *, nan_is_null: bool) -> Any:
    if values.dtype.kind == "f":
        return pa.array(values, mask=np.isnan(values) if nan_is_null else None)
    return pa.array(values.tolist() if values.dtype.kind == "O" else values)


def write_table(path: Path, columns: Sequence[TableColumn]) -> None:
    """Write a table at once.

    Raises:
        RecordError: The file cannot be written.
    """
    rows = len(columns[0].values) if columns else 0
    with table_writer(path) as writer:
        for first in range(0, max(rows, 1), BLOCK_ROWS):
            block = slice(first, first + BLOCK_ROWS)
            writer.write([TableColumn(column.name, column.values[block]) for column in columns])


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    check_suffix(path)
    if not path.is_file():
        raise RecordError(f"the table {path} cannot be read: there is no such file")
    with foreign_file(f"the table {path} cannot be read"):
        yield


def _once_named(path: Path, names: list[str]) -> list[str]:
    for name in names:
        if names.count(name) > 1:
            raise RecordError(f"{path} has two columns {name}; name each column once")
    return names


def _converted(kinds: Mapping[str, Any]) -> Any:
    return pacsv.ConvertOptions(
        null_values=list(MISSING_TEXTS), strings_can_be_null=True, column_types=dict(kinds)
    )


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
            kinds = {}
            if numbers:
                with pacsv.open_csv(path) as reader:
                    kinds = dict.fromkeys(reader.schema.names, pa.float64())
            table = pacsv.read_csv(path, convert_options=_converted(kinds))
        else:
            table = pq.read_table(path)
        names = _once_named(path, table.column_names)
        columns = [TableColumn(name, to_numpy(table.column(at))) for at, name in enumerate(names)]
        return DataTable(tuple(columns), table.num_rows)


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
            source = path
            if path.suffix == ".csv":
                source = Path(folder) / "table.parquet"
                _copy_csv(path, source, delimiter)
            file = pq.ParquetFile(source)
            names = _once_named(path, file.schema_arrow.names)
        with file:
            yield DataTable(
                tuple(StoredColumn(file, path, name) for name in names), file.metadata.num_rows
            )


def _copy_csv(path: Path, target: Path, delimiter: str) -> None:
    """Copy a CSV file; a column whose kind changes on the way is read as the wider kind from its top."""
    kinds: dict[str, Any] = {}
    while True:
        with pacsv.open_csv(
            path,
            read_options=pacsv.ReadOptions(block_size=BLOCK_BYTES, use_threads=False),
            parse_options=pacsv.ParseOptions(delimiter=delimiter),
            convert_options=_converted(kinds),
        ) as reader:
            _once_named(path, reader.schema.names)
            try:
                with pq.ParquetWriter(target, reader.schema, compression="zstd") as writer:
                    for batch in reader:
                        writer.write_batch(batch)
            except pa.ArrowInvalid as error:
                place = _COLUMN.search(str(error))
                if place is None:
                    raise
                field = reader.schema.field(int(place.group(1)))
                if pa.types.is_string(field.type):
                    raise
                number = pa.types.is_integer(field.type) or pa.types.is_null(field.type)
                kinds[field.name] = pa.float64() if number else pa.string()
            else:
                return


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
    with table_writer(out) as writer:
        for batch in pq.ParquetFile(path).iter_batches(batch_size=4096, columns=list(names)):
            writer.write(
                [TableColumn(n, batch.column(n).to_numpy(zero_copy_only=False)) for n in names]
            )
