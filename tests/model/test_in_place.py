"""Kernels that make no array do not count who holds those that they are given."""

import importlib
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from model.compiled import compiles

pytestmark = pytest.mark.skipif(not compiles(), reason="numba is not there")

# A package of its own, as machine code is kept by the sources of a package.
SOURCE = """
import numpy as np

from model.compiled import compiled, in_place


@in_place
@compiled
def sum_of_rows(rows):
    total = 0.0
    for k in range(rows.shape[0]):
        row = rows[k]
        for i in range(row.size):
            total += row[i]
    return total


@compiled
def sum_of_some(count):
    made = np.ones((count, 2))
    return sum_of_rows(made[1:])


@in_place
@compiled
def sum_of_more(rows):
    return sum_of_rows(rows) + sum_of_some(len(rows))


@in_place
@compiled
def makes_one(rows):
    copy = rows.copy()
    return copy[0, 0]
"""


@pytest.fixture
def kernels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    package = tmp_path / "kernels_of_a_test"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "rows.py").write_text(SOURCE)
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("kernels_of_a_test", "kernels_of_a_test.rows"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return importlib.import_module("kernels_of_a_test.rows")


def test_they_compute_the_same_and_leave_their_arguments_alone(kernels: ModuleType) -> None:
    rows = np.arange(12.0).reshape(4, 3)
    held = sys.getrefcount(rows)
    for _ in range(1_000):
        assert kernels.sum_of_rows(rows) == rows.sum()
    assert sys.getrefcount(rows) == held


def test_those_that_count_and_those_that_do_not_call_each_other(kernels: ModuleType) -> None:
    assert kernels.sum_of_more(np.ones((5, 2))) == 10.0 + 8.0
    assert kernels.sum_of_some(3) == 4.0


def test_an_array_made_in_one_is_an_error(kernels: ModuleType) -> None:
    with pytest.raises(Exception, match=r"(?i)nrt"):
        kernels.makes_one(np.ones((2, 2)))
