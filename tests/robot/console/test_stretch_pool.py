"""Stretches in this process and others: in order, each once, and nothing if one does not count.

What one came to in another process comes back in a file, or as it is where there is no room.
"""

import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from gap.worker_pool import worker_pool
from record.log.damage import Pass
from record.log.stretches import Stretch
from robot.console import stretch_pool
from robot.console.stretch_pool import DifferentError, _laid_down, _taken_up, in_stretches

BAD = 5
HERE = os.getpid()


@dataclass(frozen=True)
class Task:
    """A stretch that is only numbered."""

    stretch: Stretch


def tasks(count: int) -> list[Task]:
    return [Task(Stretch(k, k + 1, (10 * k, 10 * k + 10), None, None)) for k in range(count)]


def squared(task: Task) -> tuple[int, int] | None:
    return task.stretch.begin**2, os.getpid()


def but_one(task: Task) -> tuple[int, int] | None:
    return None if task.stretch.begin == BAD else squared(task)


@pytest.fixture(autouse=True)
def forked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stretch_pool, "worker_pool", partial(worker_pool, inherit=True))
    monkeypatch.setattr(stretch_pool, "checksum_fits", lambda _path: True)


@pytest.mark.parametrize(("count", "cores"), [(1, 2), (2, 2), (12, 2), (12, 3), (3, 8), (4, 1)])
def test_results_come_in_order_from_this_process_and_others(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, count: int, cores: int
) -> None:
    monkeypatch.setattr(stretch_pool, "cores", lambda: cores)
    progress, taken = Pass(size=10 * count), list[tuple[int, int]]()
    assert in_stretches(tmp_path, tasks(count), squared, progress, taken.append)
    assert [number for number, _ in taken] == [k**2 for k in range(count)]
    assert len({process for _, process in taken} - {HERE}) <= max(cores - 1, 1)
    assert progress.finished
    assert progress.position == progress.size


def test_where_this_process_waits_it_works(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(stretch_pool, "cores", lambda: 2)
    taken: list[tuple[int, int]] = []
    assert in_stretches(tmp_path, tasks(40), slowly, Pass(), taken.append)
    assert {process == HERE for _, process in taken} == {True, False}


def slowly(task: Task) -> tuple[int, int] | None:
    return sum(k * 0 for k in range(200_000)) + task.stretch.begin, os.getpid()


def test_if_one_does_not_count_none_does(tmp_path: Path) -> None:
    progress = Pass(size=120)
    assert not in_stretches(tmp_path, tasks(12), but_one, progress, lambda _result: None)
    assert not progress.finished


def test_a_result_comes_back_from_its_file_and_leaves_none(tmp_path: Path) -> None:
    (task,) = tasks(1)
    laid_down = _laid_down(squared, tmp_path, task)
    assert isinstance(laid_down, Path)
    assert laid_down.parent == tmp_path
    assert _taken_up(laid_down) == (0, HERE)
    assert list(tmp_path.iterdir()) == []


def test_without_room_it_comes_as_it_is(tmp_path: Path) -> None:
    result = _laid_down(squared, tmp_path / "absent", tasks(1)[0])
    assert result == (0, HERE)
    assert _taken_up(result) == (0, HERE)


def test_what_does_not_count_has_no_file(tmp_path: Path) -> None:
    assert _laid_down(but_one, tmp_path, tasks(BAD + 1)[BAD]) is None
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(DifferentError):
        _taken_up(None)


def test_with_no_place_for_files_nothing_is_concluded(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Whoever asked then goes through the log in one pass."""
    absent = partial(TemporaryDirectory, dir=tmp_path / "absent")
    monkeypatch.setattr(stretch_pool, "TemporaryDirectory", absent)
    progress = Pass(size=30)
    assert not in_stretches(tmp_path, tasks(3), squared, progress, lambda _result: None)
    assert not progress.finished
