"""Tables as Parquet and CSV files: written at once, or block by block in bounded memory."""

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.errors import RecordError
from record.trial.csv_file import parquet_to_csv, write_csv
from record.trial.database import DatabaseError
from record.trial.parquet_file import (
    join_parquet,
    parquet_table,
    rows_at_once,
    write_even_parquet,
    write_parquet,
)
from record.trial.table_file import TableColumn, check_suffix
from record.whole_file import whole_file


class TableWriter:
    """Writes a table block by block; made by ``table_writer``.

    Rows that are no longer held in memory are at the end of a CSV file, or, as nothing can be added to a
    Parquet file, wait in files of their own for the end.
    """

    def __init__(self, out: Path, folder: Path) -> None:
        self.rows = 0
        self._out = out
        self._folder = folder
        self._held: list[Sequence[TableColumn]] = []
        self._held_rows = 0
        self._parts: list[Path] = []
        self._kinds: set[tuple[np.dtype[Any], ...]] = set()

    def write(self, columns: Sequence[TableColumn]) -> None:
        """Write the next rows; every block has the same columns."""
        count = len(columns[0].values) if columns else 0
        self._held.append(columns)
        self._held_rows += count
        self.rows += count
        if self._held_rows >= rows_at_once(len(columns)):
            self._put_away()

    def _names(self) -> list[str]:
        return [column.name for column in self._held[0]]

    def _arrays(self) -> list[NDArray[Any]]:
        return [
            np.concatenate([column.values for column in same])
            for same in zip(*self._held, strict=True)
        ]

    def _put_away(self) -> None:
        names, arrays = self._names(), self._arrays()
        part = self._folder / f"{len(self._parts)}{self._out.suffix}"
        self._kinds.add(tuple(values.dtype for values in arrays))
        if self._out.suffix == ".csv":
            write_csv(part, names, arrays, head=not self._parts)
            with part.open("rb") as rows, self._out.open("ab") as out:
                shutil.copyfileobj(rows, out)
            part.unlink()
        else:
            write_parquet(part, names, arrays)
        self._parts.append(part)
        self._held, self._held_rows = [], 0

    def finish(self) -> None:
        """Write the file."""
        if not self._parts and self._held:
            _write(self._out, self._names(), self._arrays())
            return
        if self._held:
            self._put_away()
        if self._parts and self._out.suffix == ".parquet":
            names = parquet_table(self._parts[0]).names
            join_parquet(self._parts, self._out, names, mixed=len(self._kinds) > 1)


def _write(out: Path, names: Sequence[str], arrays: Sequence[NDArray[Any]]) -> None:
    (write_csv if out.suffix == ".csv" else write_parquet)(out, names, arrays)


@contextmanager
def _whole_table(path: Path) -> Iterator[Path]:
    """Yield the name to write to, as ``whole_file`` does."""
    check_suffix(path)
    with whole_file(path) as part:
        try:
            yield part
        except DatabaseError as error:
            raise RecordError(f"{path} cannot be written: {error}") from error


@contextmanager
def table_writer(path: Path) -> Iterator[TableWriter]:
    """Yield a writer of a table; the file appears under its name when the block is done.

    Args:
        path: A .parquet or .csv file.

    Raises:
        RecordError: It is neither, or cannot be written.
    """
    with (
        _whole_table(path) as part,
        tempfile.TemporaryDirectory(prefix=f".{path.stem}.", dir=path.parent) as folder,
    ):
        writer = TableWriter(part, Path(folder))
        yield writer
        writer.finish()


def write_table(path: Path, columns: Sequence[TableColumn]) -> None:
    """Write a table at once.

    Raises:
        RecordError: The file cannot be written.
    """
    with _whole_table(path) as part:
        _write(part, [c.name for c in columns], [c.values for c in columns])


def write_even_table(part: Path, columns: Sequence[TableColumn]) -> None:
    """Write columns of numbers to a .parquet file whose size does not depend on their values.

    Args:
        part: The file, as it is: what is there is lost.
        columns: Columns of floats.

    Raises:
        RecordError: It cannot be written so.
        OSError: It cannot be written.
    """
    try:
        write_even_parquet(part, [c.name for c in columns], [c.values for c in columns])
    except DatabaseError as error:
        raise RecordError(f"{part} cannot be written: {error}") from error


def copy_table(path: Path, out: Path, names: Sequence[str]) -> None:
    """Copy some columns of a Parquet file into another table, in bounded memory.

    Raises:
        RecordError: The file cannot be written.
    """
    with _whole_table(out) as part:
        if part.suffix == ".csv":
            parquet_to_csv(path, part, names)
        else:
            join_parquet([path], part, names, mixed=False)
