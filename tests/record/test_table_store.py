"""A table column by column is the table as a whole."""

import random
import zlib
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz.damage import damaged
from model.errors import RecordError
from record.trial.column_map import ColumnMap, read_column_map
from record.trial.source_tables import open_tables
from record.trial.table_file import TableColumn, open_table, read_table
from record.trial.table_writer import write_table


def test_columns_that_change_their_kind_far_down_are_read_as_of_the_whole(tmp_path: Path) -> None:
    path = tmp_path / "theirs.csv"
    rows = [f"{i},{i},,{i}" for i in range(50_000)]
    rows[45_000] = "45000,0.25,7.5,early"
    path.write_text("count,then_float,empty_first,then_text\n" + "\n".join(rows) + "\n", "utf-8")
    whole = read_table(path)
    with open_table(path) as table:
        assert (table.names, table.rows) == (whole.names, 50_000)
        for ours, theirs in zip(table.columns, whole.columns, strict=True):
            values = ours.values
            assert values.dtype == theirs.values.dtype
            if values.dtype == object:
                assert values.tolist() == theirs.values.tolist()
            else:
                np.testing.assert_array_equal(values, theirs.values)


def test_a_parquet_file_and_its_mistakes(tmp_path: Path) -> None:
    path = tmp_path / "ours.parquet"
    write_table(path, [TableColumn("time_s", np.arange(5.0)), TableColumn("n", np.arange(5))])
    with open_table(path) as table:
        assert table.names == ("time_s", "n")
        np.testing.assert_array_equal(table.numbers("n"), np.arange(5.0))
    path.write_bytes(b"no table")
    with pytest.raises(RecordError, match="cannot be read"), open_table(path):
        pass
    twice = tmp_path / "twice.csv"
    twice.write_text("a,a\n1,2\n", "utf-8")
    with pytest.raises(RecordError, match="two columns a"), open_table(twice):
        pass
    with pytest.raises(RecordError, match="no such file"), open_table(tmp_path / "none.csv"):
        pass


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_names_and_texts_that_are_no_text(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"theirs{suffix}"
    words = np.array(["early", "later"], dtype=object)
    for good, bad in ((b"name", b"n\x9bme"), (b"early", b"e\x9bely")):
        write_table(path, [TableColumn("name", words), TableColumn("n", np.arange(2))])
        path.write_bytes(path.read_bytes().replace(good, bad[:2] + good[2:]))
        with pytest.raises(RecordError, match="it is not UTF-8 text"):
            read_table(path)
        with (
            pytest.raises(RecordError, match="it is not UTF-8 text"),
            open_table(path) as table,
        ):
            assert table.columns[0].values is not None


def test_whatever_is_damaged_in_arrays_is_one_error(tmp_path: Path) -> None:
    path, source = tmp_path / "theirs.npz", random.Random(3)
    given = read_map(tmp_path)
    np.savez_compressed(path, t=np.arange(50.0), pos=np.ones((50, 6)))
    good = path.read_bytes()
    with open_tables(path, given) as tables:
        assert tables[0].table.rows == 50
    kinds: set[type | None] = set()
    for _ in range(300):
        path.write_bytes(damaged(good, source))
        try:
            with open_tables(path, given) as tables:
                kinds.add(type(tables))
        except RecordError as error:
            kinds.add(type(error.__cause__))
    assert zlib.error in kinds, "and not only what numpy says itself"


def read_map(folder: Path) -> ColumnMap:
    """Return the smallest map."""
    path = folder / "map.toml"
    path.write_text('[columns]\nt = "time_s"\n')
    return read_column_map(path)
