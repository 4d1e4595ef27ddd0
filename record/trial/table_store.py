"""A large table column by column: only the column that is asked for is in memory.

A Parquet file is read where it lies. A CSV file is first copied, a block at a time, to a Parquet file that
is removed afterwards: its columns lie across all of its lines.
"""

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from model.errors import RecordError
from record.trial.table_file import MISSING_TEXTS, Table, check_suffix, once_named, to_numpy

BLOCK_BYTES = 1 << 22
_COLUMN = re.compile(r"CSV column #(\d+)")


class StoredColumn:
    """A column that is read each time its values are asked for.

    Args:
        file: The file.
        name: The column.
    """

    def __init__(self, file: Any, name: str) -> None:
        self.name = name
        self._file = file

    @property
    def values(self) -> NDArray[Any]:
        """A value a row, (T,); texts are an object array."""
        return to_numpy(self._file.read(columns=[self.name], use_threads=False).column(0))


@contextmanager
def open_table(path: Path, delimiter: str = ",") -> Iterator[Table]:
    """Open a table for as long as the context lasts; numbers and texts as ``read_table`` finds them.

    Args:
        path: A .parquet or .csv file.
        delimiter: Between the fields of a CSV file.

    Raises:
        RecordError: It cannot be read, or has two columns of one name.
    """
    check_suffix(path)
    if not path.is_file():
        raise RecordError(f"the table {path} cannot be read: there is no such file")
    with tempfile.TemporaryDirectory(prefix="bigant-") as folder:
        try:
            source = path
            if path.suffix == ".csv":
                source = Path(folder) / "table.parquet"
                _copy(path, source, delimiter)
            file = pq.ParquetFile(source)
        except (OSError, pa.ArrowException) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise RecordError(f"the table {path} cannot be read: {reason}") from error
        names = once_named(path, file.schema_arrow.names)
        with file:
            yield Table(tuple(StoredColumn(file, name) for name in names), file.metadata.num_rows)


def _copy(path: Path, target: Path, delimiter: str) -> None:
    """Copy a CSV file; a column whose kind changes on the way is read as the wider kind from its top."""
    kinds: dict[str, Any] = {}
    while True:
        convert = pacsv.ConvertOptions(
            null_values=list(MISSING_TEXTS), strings_can_be_null=True, column_types=kinds
        )
        with pacsv.open_csv(
            path,
            read_options=pacsv.ReadOptions(block_size=BLOCK_BYTES, use_threads=False),
            parse_options=pacsv.ParseOptions(delimiter=delimiter),
            convert_options=convert,
        ) as reader:
            once_named(path, reader.schema.names)
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
