"""DuckDB, the library that reads and writes table files: one database in memory a process, no threads.

The files are what counts; nothing is kept in the database. Its errors come out as ``DatabaseError`` with
one line of words, or as ``OSError`` where a file cannot be written.
"""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from duckdb import DuckDBPyConnection

# No thread besides ours: campaigns and diagnoses have a process a core, and some of them are forked.
# No cache: it would take a file for another one of the same size and time stamp.
SETTINGS: Mapping[str, str] = {
    "threads": "1",
    "async_threads": "0",
    "temp_directory": "",
    "enable_external_file_cache": "false",
    "autoinstall_known_extensions": "false",
    "autoload_known_extensions": "false",
}
NO_TEXT = "it is not UTF-8 text"
_NO_TEXT = re.compile(r"(?i)invalid unicode|invalid string encoding|not valid utf|not utf-8")
_KIND = re.compile(r"^[A-Z][A-Za-z ]+ Error: ")
_CSV_LINE = re.compile(r"CSV Error on Line: (\d+)")
_FIELDS = re.compile(r"Expected Number of Columns: (\d+) Found: (\d+)")
_IO_WORDS = re.compile(r'"exception_message":"(.*?[^\\])"')
_GLOB = re.compile(r"[*?\[]")


class DatabaseError(Exception):
    """What DuckDB did not do, in one line."""


def rows_of(sql: str, *parameters: Any) -> list[tuple[Any, ...]]:
    """Run a query and return its rows.

    Raises:
        DatabaseError: It failed.
        OSError: A file cannot be read or written.
    """
    with _cursor() as cursor:
        return cursor.execute(sql, parameters).fetchall()


def arrays_of(sql: str, *parameters: Any) -> dict[str, NDArray[Any]]:
    """Run a query and return its columns by name; a column with values that are missing is a masked array.

    Raises:
        DatabaseError: It failed.
        OSError: A file cannot be read.
    """
    with _cursor() as cursor:
        return cursor.execute(sql, parameters).fetchnumpy()


def write(sql: str, arrays: Mapping[str, NDArray[Any]], *parameters: Any) -> None:
    """Run a COPY of arrays, which are the table ``arrays`` in it.

    Raises:
        DatabaseError: It failed.
        OSError: The file cannot be written.
    """
    with _cursor() as cursor:
        cursor.register("arrays", dict(arrays))
        try:
            cursor.execute(sql, parameters)
        finally:
            cursor.unregister("arrays")


def literal_path(path: Path) -> str:
    """Return a path as DuckDB takes it for a file to read: nothing in it is a pattern or a home folder."""
    return _GLOB.sub(lambda sign: f"[{sign.group()}]", str(path.absolute()))


def quoted(name: str) -> str:
    """Return a column's name as SQL has it."""
    return '"' + name.replace('"', '""') + '"'


def filled(values: NDArray[Any]) -> NDArray[Any]:
    """Return numbers with NaN where a masked array has none; integers then are floats."""
    if not isinstance(values, np.ma.MaskedArray):
        return values
    return np.where(np.ma.getmaskarray(values), np.nan, np.ma.getdata(values))


@contextmanager
def _cursor() -> Iterator["DuckDBPyConnection"]:
    """Yield a connection to this process's database; whatever it raises comes out as our errors."""
    cursor = _database(os.getpid()).cursor()
    import duckdb

    try:
        cursor.execute("SET enable_progress_bar = false")  # a notebook would show DuckDB's
        yield cursor
    except duckdb.IOException as error:
        raise OSError(_io_words(str(error))) from error
    except duckdb.InterruptException as error:
        raise KeyboardInterrupt from error
    except (duckdb.Error, ValueError) as error:
        raise DatabaseError(_words(str(error))) from error
    except RuntimeError as error:
        if "interrupted" in str(error):
            raise KeyboardInterrupt from error
        raise DatabaseError(_words(str(error))) from error
    finally:
        cursor.close()


@cache
def _database(process: int) -> "DuckDBPyConnection":
    """Return a database of one process: a forked one does not use its parent's."""
    import duckdb  # only here: many commands read no table, and it takes 60 ms

    return duckdb.connect(config=dict(SETTINGS))


def _words(text: str) -> str:
    """Return the line of an error that says what is wrong; the others propose options of DuckDB."""
    if _NO_TEXT.search(text):
        return NO_TEXT
    lines = [line for line in _KIND.sub("", text).splitlines() if line.strip()]
    if not lines:
        return "it is damaged"
    if (line := _CSV_LINE.search(lines[0])) is None:
        return lines[0]
    if (fields := _FIELDS.search(text)) is not None:
        return f"line {line.group(1)} has {fields.group(2)} fields, and the first line {fields.group(1)}"
    cause = next((x for x in lines[1:] if x.startswith("Value")), "it is no row of a CSV file")
    return f"line {line.group(1)}: {cause}"


def _io_words(text: str) -> str:
    system_words = _IO_WORDS.search(text)
    inner = system_words.group(1).replace('\\"', '"') if system_words else _KIND.sub("", text)
    return inner.splitlines()[0].rpartition('": ')[2]


def sql_list(texts: Sequence[str]) -> str:
    """Return texts as a list of SQL."""
    return "[" + ", ".join("'" + text.replace("'", "''") + "'" for text in texts) + "]"
