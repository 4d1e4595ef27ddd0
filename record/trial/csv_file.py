"""CSV files: what kind each column is, is found from all of its rows; numbers are exact both ways."""

import csv
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from record.trial.database import (
    NO_TEXT,
    DatabaseError,
    arrays_of,
    filled,
    literal_path,
    quoted,
    rows_of,
    sql_list,
)
from record.trial.parquet_file import compressed, files_source, parquet_table, write_columns

MISSING_TEXTS = ("", "nan", "NaN", "NAN", "NA", "N/A", "null", "NULL", "None", "-nan", "#N/A")
TRUE, FALSE = ("true", "True", "TRUE"), ("false", "False", "FALSE")
# How a file may have to be read, the usual way first: lines with different ends need the second, texts
# of Windows programs the third.
DIALECTS = (("utf-8", True), ("utf-8", False), ("latin-1", False))
Result = TypeVar("Result")


def csv_names(path: Path, delimiter: str) -> tuple[str, ...]:
    """Return what the first line of a CSV file calls its columns.

    Raises:
        DatabaseError: It is empty, or its first line is no text.
    """
    with path.open(encoding="utf-8-sig", errors="surrogateescape", newline="") as file:
        names = next(filter(None, csv.reader(file, delimiter=delimiter)), None)
    if names is None:
        raise DatabaseError("it is empty")
    if any("\ud800" <= letter <= "\udfff" for name in names for letter in name):
        raise DatabaseError(NO_TEXT)
    return tuple(names)


def read_csv(
    path: Path, names: Sequence[str], delimiter: str, *, numbers: bool
) -> list[NDArray[Any]]:
    """Return all columns, (T,) each: integers, or floats with NaN where there is none, or texts.

    Args:
        path: The file.
        names: Of its columns.
        delimiter: Between its fields.
        numbers: Columns of numbers are floats, integers too: -0 and 20 digits stay what they are.

    Raises:
        DatabaseError: Its rows are not those of a table.
        OSError: It cannot be read.
    """
    kinds = ["DOUBLE", "VARCHAR"] if numbers else ["BIGINT", "DOUBLE", "VARCHAR"]

    def run(source: str) -> dict[str, NDArray[Any]]:
        return arrays_of(f"SELECT * FROM {source}", literal_path(path))

    columns = _first_dialect(path, len(names), delimiter, kinds, run)
    return [values_of_texts(_without_mask(values)) for values in columns.values()]


def copy_csv(path: Path, target: Path, columns: int, delimiter: str) -> None:
    """Copy a CSV file, a block at a time, to a Parquet file whose columns are c0, c1 and so on.

    Raises:
        DatabaseError: Its rows are not those of a table.
        OSError: One of the files cannot be read or written.
    """

    def run(source: str) -> object:
        sql = f"COPY (SELECT * FROM {source}) TO ? {compressed(columns)}"
        return rows_of(sql, literal_path(path), str(target.absolute()))

    _first_dialect(path, columns, delimiter, ["BIGINT", "DOUBLE", "VARCHAR"], run)


def values_of_texts(values: NDArray[Any]) -> NDArray[Any]:
    """Return texts of a CSV file as numbers, if all of them are: true and false, +3, or nothing at all."""
    if values.dtype != object:
        return values
    texts = set(values.tolist()) - {""}
    if texts <= {*TRUE, *FALSE}:
        numbers = {"": np.nan} | dict.fromkeys(TRUE, 1.0) | dict.fromkeys(FALSE, 0.0)
        return np.array([numbers[text] for text in values], dtype=np.float64)
    try:
        return np.array([_number(text) for text in values], dtype=np.float64)
    except ValueError:
        return values


def _number(text: str) -> float:
    if "_" in text or not text.isascii():
        raise ValueError
    return float(text) if text else np.nan


def _first_dialect(
    path: Path, columns: int, delimiter: str, kinds: Sequence[str], run: Callable[[str], Result]
) -> Result:
    """Return what ``run`` makes of the file, read in the first way in which it can be."""
    first: DatabaseError | None = None
    for encoding, strict in DIALECTS:
        options = (
            f"names={sql_list([f'c{at}' for at in range(columns)])}, sample_size=-1, "
            f"auto_type_candidates={sql_list(kinds)}, encoding='{encoding}', strict_mode={strict}"
        )
        try:
            return run(_source(delimiter, options))
        except DatabaseError as error:
            first = first or error
    # Why it cannot be: said by a reading that searches for no kinds.
    texts = ", ".join(f"'c{at}': 'VARCHAR'" for at in range(columns))
    source = _source(delimiter, f"auto_detect=false, columns={{{texts}}}")
    rows_of(f"SELECT count(COLUMNS(*)) FROM {source}", literal_path(path))
    raise first or DatabaseError("its rows are not those of a table")


def _source(delimiter: str, options: str) -> str:
    mark = delimiter.replace("'", "''")
    return (
        f"read_csv(?, delim='{mark}', quote='\"', escape='\"', comment='', skip=0, header=true, "
        f"hive_partitioning=false, nullstr={sql_list(MISSING_TEXTS)}, {options})"
    )


def _without_mask(values: NDArray[Any]) -> NDArray[Any]:
    if values.dtype == object and isinstance(values, np.ma.MaskedArray):
        return np.asarray(values.filled(""))
    return filled(values)


def write_csv(
    path: Path, names: Sequence[str], arrays: Sequence[NDArray[Any]], *, head: bool = True
) -> None:
    """Write columns at once; a number that is missing is an empty field.

    Args:
        path: The file.
        names: Names of the columns.
        arrays: Their values, (T,) each; objects are written as texts.
        head: Begin with a line of the names.

    Raises:
        RecordError: Two names differ at most in upper and lower case.
        OSError: The file cannot be written.
    """
    write_columns(
        path, names, arrays,
        lambda column, values, name: _field(column, name, "DOUBLE" if values.dtype.kind == "f" else ""),
        f"(FORMAT csv, HEADER {head}, USE_TMP_FILE false)",
    )  # fmt: skip


def parquet_to_csv(path: Path, out: Path, names: Sequence[str]) -> None:
    """Write some columns of a Parquet file as CSV, a block at a time.

    Raises:
        DatabaseError: The Parquet file cannot be read.
        OSError: The CSV file cannot be written.
    """
    table = parquet_table(path)
    kinds = dict(zip(table.names, table.kinds, strict=True))
    chosen = ", ".join(_field(quoted(name), quoted(name), kinds[name]) for name in names)
    options = "(FORMAT csv, HEADER true, USE_TMP_FILE false)"
    sql = f"COPY (SELECT {chosen} FROM {files_source(mixed=False)}) TO ? {options}"
    rows_of(sql, [literal_path(path)], str(out.absolute()))


def _field(column: str, name: str, kind: str) -> str:
    value = f"nullif({column}, 'nan')" if kind in {"FLOAT", "DOUBLE"} else column
    return f"{value} AS {name}"
