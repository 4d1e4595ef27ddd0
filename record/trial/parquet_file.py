"""Parquet files: column by column, in blocks, or all of one size whatever is in them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.errors import RecordError
from record.trial.database import arrays_of, filled, literal_path, quoted, rows_of, write

GROUP_ROWS, WIDE_GROUP_ROWS, WIDE = 10_240, 4_096, 128  # rows; columns of a wide table
INTEGERS = frozenset(
    {"TINYINT", "SMALLINT", "INTEGER", "BIGINT", "UTINYINT", "USMALLINT", "UINTEGER"}
)
NUMBERS = ("FLOAT", "DOUBLE", "DECIMAL", "UBIGINT", "HUGEINT", '"NULL"')
PADDING = 20_000  # bytes; a text of 2^14 to 2^21 bytes has a length of three bytes in the file


def rows_at_once(columns: int) -> int:
    """Return how many rows are in memory at once while a file is written."""
    return GROUP_ROWS if columns <= WIDE else WIDE_GROUP_ROWS


def compressed(columns: int) -> str:
    """Return the options of COPY for a usual file."""
    rows = rows_at_once(columns)
    return f"(FORMAT parquet, COMPRESSION zstd, ROW_GROUP_SIZE {rows}, USE_TMP_FILE false)"


def files_source(*, mixed: bool) -> str:
    """Return SQL that reads a list of files one after the other.

    Args:
        mixed: A column may be of integers in one and of floats in another; takes more memory.
    """
    return f"read_parquet(?, hive_partitioning=false, union_by_name={mixed})"


@dataclass(frozen=True, slots=True)
class ParquetTable:
    """A Parquet file's table of contents.

    Attributes:
        path: The file.
        names: Names of its columns, as they are in the file.
        kinds: DuckDB's type of each.
        rows: Number of rows.
    """

    path: Path
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    rows: int

    def values(self, at: int) -> NDArray[Any]:
        """Return one column, read now, as ``all_values`` does."""
        return self._read([at])[0]

    def all_values(self) -> list[NDArray[Any]]:
        """Return all columns, (T,) each: integers, or floats with NaN where there is none, or texts.

        Raises:
            DatabaseError: The file is damaged.
            OSError: It cannot be read.
        """
        return self._read(range(len(self.names)))

    def _read(self, which: Sequence[int]) -> list[NDArray[Any]]:
        columns = ", ".join(f"c{at}" for at in range(len(self.names)))
        chosen = ", ".join(f"{_as_kind(f'c{at}', self.kinds[at])} AS c{at}" for at in which)
        sql = f"SELECT {chosen} FROM read_parquet(?, hive_partitioning=false) AS file({columns})"
        return [_plain(values) for values in arrays_of(sql, literal_path(self.path)).values()]


def _as_kind(column: str, kind: str) -> str:
    if kind in INTEGERS:
        return f"CAST({column} AS BIGINT)"
    if kind.startswith(NUMBERS) and not kind.endswith("]"):
        return f"CAST({column} AS DOUBLE)"
    if kind == "BOOLEAN":
        return f"CAST(CAST({column} AS TINYINT) AS DOUBLE)"
    return f"coalesce(CAST({column} AS VARCHAR), '')"


def _plain(values: NDArray[Any]) -> NDArray[Any]:
    return values if values.dtype == object else filled(values)


def parquet_table(path: Path) -> ParquetTable:
    """Open a Parquet file.

    Raises:
        DatabaseError: It is none, or damaged.
        OSError: It cannot be read.
    """
    file = literal_path(path)
    schema = rows_of("SELECT name, num_children, duckdb_type FROM parquet_schema(?)", file)
    columns = list(_top_level(schema))
    ((rows,),) = rows_of("SELECT num_rows FROM parquet_file_metadata(?)", file)
    return ParquetTable(
        path, tuple(name for name, _ in columns), tuple(kind for _, kind in columns), int(rows)
    )


def _top_level(schema: Sequence[tuple[Any, ...]]) -> Iterator[tuple[str, str]]:
    """Yield names and types of columns; below a column that is nested lie its parts."""
    at = 1
    while at < len(schema):
        name, _, kind = schema[at]
        yield name, str(kind)
        left = 1
        while left and at < len(schema):
            left += int(schema[at][1] or 0) - 1
            at += 1


def write_parquet(
    path: Path, names: Sequence[str], arrays: Sequence[NDArray[Any]], how: str = ""
) -> None:
    """Write columns at once.

    Args:
        path: The file.
        names: Names of the columns.
        arrays: Their values, (T,) each; objects are written as texts.
        how: Options of COPY; the usual ones if empty.

    Raises:
        RecordError: Two names differ in nothing but upper and lower case.
        OSError: The file cannot be written.
    """
    write_columns(
        path, names, arrays, lambda column, values, name: f"{_kept(column, values)} AS {name}",
        how or compressed(len(names)),
    )  # fmt: skip


def write_columns(
    path: Path,
    names: Sequence[str],
    arrays: Sequence[NDArray[Any]],
    choose: Callable[[str, NDArray[Any], str], str],
    options: str,
) -> None:
    """Write columns at once to a file of any kind; otherwise as ``write_parquet``.

    Args:
        path: The file.
        names: Names of the columns.
        arrays: Their values, (T,) each.
        choose: Makes what is written of an array's own name, its values, and its name in the file.
        options: Of COPY.
    """
    check_names(path, names)
    inputs = {f"c{at}": as_input(values) for at, values in enumerate(arrays)}
    chosen = ", ".join(
        choose(column, values, quoted(name))
        for name, (column, values) in zip(names, inputs.items(), strict=True)
    )
    write(f"COPY (SELECT {chosen} FROM arrays) TO ? {options}", inputs, str(path.absolute()))


def join_parquet(parts: Sequence[Path], out: Path, names: Sequence[str], *, mixed: bool) -> None:
    """Write some columns of Parquet files, one file after the other, into a new file.

    Args:
        parts: The files.
        out: The new file.
        names: The columns.
        mixed: A column may be of integers in one and of floats in another.

    Raises:
        DatabaseError: A part cannot be read.
        OSError: The file cannot be written.
    """
    chosen = f"SELECT {', '.join(map(quoted, names))} FROM {files_source(mixed=mixed)}"
    files = [literal_path(part) for part in parts]
    rows_of(f"COPY ({chosen}) TO ? {compressed(len(names))}", files, str(out.absolute()))


def write_even_parquet(path: Path, names: Sequence[str], arrays: Sequence[NDArray[Any]]) -> None:
    """Write columns of numbers as a file whose size depends on names and rows alone.

    Nothing is compressed. What else depends on the values are the smallest and largest value of each block,
    which a block with NaN does not have; a text of the missing length stands in the file's metadata.

    Raises:
        RecordError: Two names differ in nothing but upper and lower case.
        OSError: The file cannot be written.
    """
    write_parquet(path, names, [np.zeros_like(values) for values in arrays], _uncompressed(PADDING))
    size = path.stat().st_size
    write_parquet(path, names, arrays, _uncompressed(PADDING))
    write_parquet(path, names, arrays, _uncompressed(PADDING + size - path.stat().st_size))
    if path.stat().st_size != size:
        raise RecordError(f"{path} does not have the {size} bytes of all files like it")


def _uncompressed(padding: int) -> str:
    return (
        "(FORMAT parquet, COMPRESSION uncompressed, DICTIONARY_SIZE_LIMIT 0, USE_TMP_FILE false, "
        f"ROW_GROUP_SIZE {GROUP_ROWS}, KV_METADATA {{padding: '{'.' * padding}'}})"
    )


def as_input(values: NDArray[Any]) -> NDArray[Any]:
    """Return an array as DuckDB takes it: objects as texts, each in its own object."""
    if values.dtype.kind not in "OU":
        return values
    return np.array([None if v is None else str(v) for v in values.tolist()] or [], dtype=object)


def _kept(column: str, values: NDArray[Any]) -> str:
    """Return SQL that keeps NaN, which DuckDB takes for a value that is missing."""
    if values.dtype.kind == "f":
        kind = "FLOAT" if values.dtype.itemsize <= 4 else "DOUBLE"
        return f"coalesce(CAST({column} AS {kind}), 'nan'::{kind})"
    return f"CAST({column} AS VARCHAR)" if values.dtype == object else column


def check_names(path: Path, names: Sequence[str]) -> None:
    """Refuse names that DuckDB would take for one, and change."""
    seen: dict[str, str] = {}
    for name in names:
        if (other := seen.setdefault(name.lower(), name)) != name or names.count(name) > 1:
            raise RecordError(
                f"{path} cannot have columns {other} and {name}, which differ at most in upper and lower "
                "case; rename one of them"
            )
