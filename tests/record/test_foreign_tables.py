"""Our tables in other people's programs, and theirs in ours."""

import os
import threading
from datetime import UTC, datetime
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
import pytest

from model.errors import RecordError
from record.trial.csv_file import write_csv
from record.trial.parquet_file import write_parquet
from record.trial.table_file import TableColumn, open_table, read_table
from record.trial.table_writer import table_writer, write_even_table, write_table

NUMBERS = np.array([0.1, np.nan, -0.0, np.inf, 1e-310, 1 / 3])


def ours() -> list[TableColumn]:
    """Every kind of column that we write."""
    return [
        TableColumn("time_s", NUMBERS),
        TableColumn("n", np.array([1, 2, 3, -(2**63), 2**63 - 1, 0])),
        TableColumn("half", NUMBERS.astype(np.float32)),
        TableColumn("valid", np.array([True, False, True, True, False, True])),
        TableColumn('a "b", c', np.array(["", "x", "é", "a,b", 'q"', "NA"], dtype=object)),
    ]


def assert_same_bits(one: Any, other: Any) -> None:
    np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(np.signbit(one), np.signbit(other))


def test_others_read_what_we_write(tmp_path: Path) -> None:
    path = tmp_path / "ours.parquet"
    write_table(path, ours())
    table = pq.read_table(path)
    assert table.column_names == [column.name for column in ours()]
    kinds = [pa.float64(), pa.int64(), pa.float32(), pa.bool_(), pa.string()]
    assert table.schema.types == kinds
    assert all(column.null_count == 0 for column in table.columns), "NaN is a number, as before"
    for column, theirs in zip(ours()[:4], table.columns, strict=False):
        assert_same_bits(column.values, theirs.to_numpy())
    assert table.column(4).to_pylist() == ours()[4].values.tolist()


def test_pandas_reads_what_we_write(tmp_path: Path) -> None:
    path = tmp_path / "ours.parquet"
    write_table(path, ours())
    frame = pandas.read_parquet(path)
    assert [str(kind) for kind in frame.dtypes[:4]] == ["float64", "int64", "float32", "bool"]
    assert_same_bits(frame["time_s"].to_numpy(), NUMBERS)


def test_a_table_in_many_blocks_is_one_table(tmp_path: Path) -> None:
    blocks = [
        [
            TableColumn("t", np.arange(4000.0) + at),
            TableColumn("s", np.full(4000, str(at), dtype=object)),
        ]
        for at in range(6)
    ]
    for suffix in (".parquet", ".csv"):
        with table_writer(tmp_path / f"ours{suffix}") as writer:
            for block in blocks:
                writer.write(block)
    expected = np.concatenate([block[0].values for block in blocks])
    assert writer.rows == len(expected)
    for theirs in (pq.read_table(tmp_path / "ours.parquet"), pacsv.read_csv(tmp_path / "ours.csv")):
        np.testing.assert_array_equal(theirs.column(0).to_numpy(), expected)
    assert pq.read_metadata(tmp_path / "ours.parquet").num_row_groups > 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ours.csv", "ours.parquet"]


def test_an_integer_column_that_becomes_one_of_floats_is_not_rounded(tmp_path: Path) -> None:
    path = tmp_path / "ours.parquet"
    with table_writer(path) as writer:
        writer.write([TableColumn("n", np.arange(20_000))])
        writer.write([TableColumn("n", np.full(20_000, 0.5))])
    assert read_table(path).numbers("n")[-1] == 0.5


THEIRS: dict[str, tuple[pa.Array, list[Any]]] = {
    "int8": (pa.array([1, 2, 3], pa.int8()), [1, 2, 3]),
    "int32": (pa.array([1, 2, 3], pa.int32()), [1, 2, 3]),
    "uint16": (pa.array([1, 2, 3], pa.uint16()), [1, 2, 3]),
    "int32_null": (pa.array([1, None, 3], pa.int32()), [1.0, np.nan, 3.0]),
    "float32": (pa.array([1, None, 0.1], pa.float32()), [1.0, np.nan, float(np.float32(0.1))]),
    "float16": (pa.array(np.array([1, 2, 3], np.float16)), [1.0, 2.0, 3.0]),
    "double": (pa.array([0.1, None, float("nan")]), [0.1, np.nan, np.nan]),
    "bool": (pa.array([True, None, False]), [1.0, np.nan, 0.0]),
    "nothing": (pa.array([None, None, None]), [np.nan, np.nan, np.nan]),
    "texts": (pa.array(["a", None, "é"]), ["a", "", "é"]),
    "words": (pa.array(["a", None, "a"]).dictionary_encode(), ["a", "", "a"]),
    "large": (pa.array(["a", "b", "c"], pa.large_string()), ["a", "b", "c"]),
    "T": (pa.array([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]),
    "t": (pa.array([4.0, 5.0, 6.0]), [4.0, 5.0, 6.0]),
    "c0": (pa.array([7.0, 8.0, 9.0]), [7.0, 8.0, 9.0]),
    "": (pa.array([7.0, 8.0, 9.0]), [7.0, 8.0, 9.0]),
}


@pytest.mark.parametrize("compression", ["none", "snappy", "zstd", "gzip", "lz4", "brotli"])
def test_we_read_what_others_write(tmp_path: Path, compression: str) -> None:
    path = tmp_path / "theirs.parquet"
    arrays = {name: array for name, (array, _) in THEIRS.items()}
    arrays["when"] = pa.array(
        [datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)] * 3, pa.timestamp("us", "UTC")
    )
    arrays["lists"] = pa.array([[1], [2, 3], None])
    arrays["last"] = pa.array([1.5, 2.5, 3.5])
    pq.write_table(pa.table(arrays), path, compression=compression)
    with open_table(path) as opened:
        for table in (opened, read_table(path)):
            assert table.names == tuple(arrays)
            assert table.rows == 3
            values = {column.name: column.values for column in table.columns}
            for name, (_, expected) in THEIRS.items():
                kind = object if isinstance(expected[0], str) else type(expected[0])
                assert values[name].dtype == np.dtype(kind), name
                np.testing.assert_array_equal(values[name], np.array(expected, dtype=kind), name)
            assert values["when"][0].startswith("2026-01-02 03:04:05")
            assert values["lists"].dtype == object, "text that is no number"
            np.testing.assert_array_equal(values["last"], [1.5, 2.5, 3.5])


@pytest.mark.parametrize(
    "how",
    [
        {"version": "1.0"},
        {"data_page_version": "2.0"},
        {"row_group_size": 1000},
        {"use_byte_stream_split": True, "use_dictionary": False},
        # as campaigns were written before DuckDB
        {"compression": "none", "use_dictionary": False, "write_statistics": False},
    ],
)  # fmt: skip
def test_we_read_every_way_in_which_pyarrow_stores_numbers(
    tmp_path: Path, how: dict[str, Any]
) -> None:
    path, source = tmp_path / "theirs.parquet", np.random.default_rng(1)
    numbers = np.where(source.random(5000) < 0.1, np.nan, source.normal(size=5000))
    pq.write_table(pa.table({"a": numbers, "b": -numbers}), path, **how)
    assert_same_bits(read_table(path).numbers("b"), -numbers)
    with open_table(path) as table:
        assert_same_bits(table.numbers("a"), numbers)


def test_a_frame_of_pandas_with_an_index(tmp_path: Path) -> None:
    path = tmp_path / "theirs.parquet"
    frame = pandas.DataFrame({"a": [1.0, np.nan], "kind": pandas.Categorical(["u", "v"])}, [3, 4])
    frame.to_parquet(path)
    table = read_table(path)
    np.testing.assert_array_equal(table.numbers("a"), [1.0, np.nan])
    assert table.columns[1].values.tolist() == ["u", "v"]


def test_names_of_files_are_no_patterns(tmp_path: Path) -> None:
    names = ("a*.parquet", "a1.parquet", "b[1].parquet", "b1.parquet", "q'?.parquet")
    for at, name in enumerate(names):
        folder = tmp_path / "run=3"
        folder.mkdir(exist_ok=True)
        write_table(folder / name, [TableColumn("n", np.array([at]))])
        table = read_table(folder / name)
        assert (table.names, table.numbers("n").tolist()) == (("n",), [at])


def test_names_that_differ_only_in_their_case_are_refused(tmp_path: Path) -> None:
    columns = [TableColumn("T", np.zeros(2)), TableColumn("t", np.ones(2))]
    for suffix in (".parquet", ".csv"):
        with pytest.raises(RecordError, match="columns T and t, which differ at most in"):
            write_table(tmp_path / f"ours{suffix}", columns)
    assert not list(tmp_path.iterdir())


CSV = {
    "lines with different ends": ("a,b\r\n1,2\n3,4\r\n", [1, 3], [2, 4]),
    "old line ends": ("a,b\r1,2\r3,4\r", [1, 3], [2, 4]),
    "an empty line at the end": ("a,b\n1,2\n3,4\n\n", [1, 3], [2, 4]),
    "a byte order mark": ("\ufeffa,b\n1,2\n3,4\n", [1, 3], [2, 4]),
    "spaces": ("a,b\n 1, 2.5\n3 ,4\n", [1, 3], [2.5, 4]),
    "signs": ("a,b\n+1,-inf\n-0.0,1e-310\n", [1, -0.0], [-np.inf, 1e-310]),
    "missing": ("a,b\nNA,None\n1,\n", [np.nan, 1], [np.nan, np.nan]),
    "truth": ("a,b\ntrue,True\nfalse,\n", [1, 0], [1, np.nan]),
    "twenty digits": ("a,b\n12345678901234567890,1\n1,2\n", [12345678901234567890, 1], [1, 2]),
    "texts": ('a,b\n1,"x, ""y"""\n2,it\'s\n', [1, 2], ['x, "y"', "it's"]),
    "texts that are not UTF-8": ("a,b\n1,20 \xb0C\n2,x\n", [1, 2], ["20 \xb0C", "x"]),
    "no rows": ("a,b\n", [], []),
}


@pytest.mark.parametrize("case", CSV)
def test_csv_files_of_all_sorts(tmp_path: Path, case: str) -> None:
    text, a, b = CSV[case]
    path = tmp_path / "theirs.csv"
    path.write_bytes(text.encode("latin-1" if "UTF-8" in case else "utf-8"))
    with open_table(path) as opened:
        for table in (opened, read_table(path)):
            assert table.names == ("a", "b")
            for column, expected in zip(table.columns, (a, b), strict=True):
                assert column.values.tolist() == pytest.approx(expected, abs=0.0, nan_ok=True)


WRONG_CSV = {
    "a,b\n1,2\n3\n": "line 3 has 1 fields, and the first line 2",
    "a,b\n1,2\n3,4,5\n": "line 3 has 3 fields, and the first line 2",
    'a,b\n1,2\n"3,4\n5,6\n': "line 3: Value with unterminated quote found",
    "": "it is empty",
}


@pytest.mark.parametrize("text", WRONG_CSV)
def test_what_is_wrong_with_a_csv_file_is_said(tmp_path: Path, text: str) -> None:
    path = tmp_path / "theirs.csv"
    path.write_text(text)
    with pytest.raises(RecordError, match=f"theirs.csv cannot be read: {WRONG_CSV[text]}"):
        read_table(path)


def test_a_table_of_one_size_whatever_is_in_it(tmp_path: Path) -> None:
    source = np.random.default_rng(2)
    noise = source.normal(size=(25_000, 3))
    gaps = np.where(source.random(noise.shape) < 0.3, np.nan, noise)
    sizes = set()
    for array in (noise, gaps, np.zeros_like(noise), np.full_like(noise, np.nan), 1e-300 * noise):
        path = tmp_path / "trial.parquet"
        write_even_table(path, [TableColumn(f"c{at}", array[:, at]) for at in range(3)])
        sizes.add(path.stat().st_size)
        np.testing.assert_array_equal(pq.read_table(path).column("c1").to_numpy(), array[:, 1])
    assert len(sizes) == 1


def test_the_same_name_size_and_time_stamp_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "trial.parquet"
    for value in (1.0, 2.0):
        write_even_table(path, [TableColumn("a", np.full(100, value))])
        os.utime(path, (1_700_000_000, 1_700_000_000))
        assert read_table(path).numbers("a")[0] == value


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_an_error_of_the_system() -> None:
    for write in (write_parquet, write_csv):
        with pytest.raises(OSError, match=r"^No space left on device$"):
            write(Path("/dev/full"), ["a"], [np.arange(3.0)])


def test_no_thread_is_started_and_a_forked_process_reads(tmp_path: Path) -> None:
    path, before = tmp_path / "a.parquet", _threads()
    write_table(path, [TableColumn("a", np.arange(3.0))])
    assert read_table(path).rows == 3
    assert _threads() == before
    with get_context("fork").Pool(2) as pool:
        assert [table.rows for table in pool.map(_rows, [path] * 4)] == [3] * 4


def _rows(path: Path) -> Any:
    return read_table(path)


def _threads() -> int:
    tasks = Path("/proc/self/task")
    return len(list(tasks.iterdir())) if tasks.is_dir() else threading.active_count()
