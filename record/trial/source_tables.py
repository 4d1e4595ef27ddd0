"""Tables as others leave them: .csv, .parquet, and the arrays of a .npz file.

In a .npz file the columns are its arrays: ``t`` of shape (T,) is a column of that name, ``pos`` of shape
(T, 6) are the columns ``pos[0]`` to ``pos[5]``. Or every array is a table of its own, with columns ``0``,
``1`` and so on (``each_array`` of the map). An array of another length than the longest is left out and
listed; one with a number a joint goes with the trial as a constant of its log.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from model.errors import RecordError
from model.values.arrays import FloatArray
from record.trial.column_map import ColumnMap
from record.trial.foreign_file import foreign_file
from record.trial.table_check import TableFinding
from record.trial.table_file import DataTable, TableColumn, open_table

ARRAYS = ".npz"


@dataclass(frozen=True, slots=True, eq=False)
class SourceTable:
    """One table of a file.

    Attributes:
        name: Which of the file's tables; empty where it holds one.
        table: The table.
        findings: What is odd about it already.
        arrays: What the file has besides samples: numbers in a row of another length, by name.
    """

    name: str
    table: DataTable
    findings: tuple[TableFinding, ...] = ()
    arrays: Mapping[str, FloatArray] = field(default_factory=dict)


@contextmanager
def open_tables(path: Path, given: ColumnMap) -> Iterator[tuple[SourceTable, ...]]:
    """Open every table of a file for as long as the context lasts.

    Raises:
        RecordError: It cannot be read, or holds nothing.
    """
    if path.suffix != ARRAYS:
        if given.each_array:
            raise RecordError(f"{path}: table.each_array of the map is for .npz files")
        with open_table(path, given.delimiter) as table:
            yield (SourceTable("", table),)
        return
    yield _of_arrays(path, given)


def _of_arrays(path: Path, given: ColumnMap) -> tuple[SourceTable, ...]:
    with (
        foreign_file(f"the arrays of {path} cannot be read"),
        np.load(path, allow_pickle=False) as file,
    ):
        arrays = [(name, np.asarray(file[name])) for name in file.files]
    arrays = [
        (name, one) for name, one in arrays if one.ndim in {1, 2} and one.dtype.kind in "fiub"
    ]
    if not arrays:
        raise RecordError(f"{path} holds no arrays of numbers with one row a sample")
    if not given.each_array:
        return (_joined(arrays),)
    width = max(len(name) for name, _ in arrays)
    return tuple(
        SourceTable(
            name.zfill(width) if name.isdigit() else name,
            DataTable(tuple(_split("", one)), len(one)),
        )
        for name, one in arrays
    )


def _joined(arrays: list[tuple[str, np.ndarray]]) -> SourceTable:
    first, rows = max(((name, len(one)) for name, one in arrays), key=lambda pair: pair[1])
    columns, findings, others = [], [], {}
    for name, one in arrays:
        if len(one) == rows:
            columns += _split(name, one)
            continue
        if one.ndim == 1:
            others[name] = one.astype(np.float64)
        words = f"has {len(one)} rows where {first} has {rows}"
        findings.append(TableFinding("ignored", name, len(one), 0, words))
    return SourceTable("", DataTable(tuple(columns), rows), tuple(findings), others)


def _split(name: str, one: np.ndarray) -> list[TableColumn]:
    values = one.astype(np.float64) if one.dtype.kind in "fb" else one.astype(np.int64)
    if values.ndim == 1:
        return [TableColumn(name or "0", values)]
    label = f"{name}[{{}}]" if name else "{}"
    return [TableColumn(label.format(at), values[:, at]) for at in range(values.shape[1])]
