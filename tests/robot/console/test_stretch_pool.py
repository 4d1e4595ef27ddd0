"""What a stretch came to goes from process to process in a file, or as it is where there is no room."""

from pathlib import Path
from typing import NamedTuple

import pytest

from record.log.stretches import Stretch
from robot.console.stretch_pool import DifferentError, _laid_down, _taken_up


class Task(NamedTuple):
    """A stretch, and what work on it comes to."""

    stretch: Stretch
    result: list[int] | None


def task(result: list[int] | None) -> Task:
    return Task(Stretch(0, 1, (0, 0), None, None), result)


def work(of: Task) -> list[int] | None:
    return of.result


def test_a_result_comes_back_from_its_file_and_leaves_none(tmp_path: Path) -> None:
    laid_down = _laid_down(work, tmp_path, task([1, 2, 3]))
    assert isinstance(laid_down, Path)
    assert laid_down.parent == tmp_path
    assert _taken_up(laid_down) == [1, 2, 3]
    assert list(tmp_path.iterdir()) == []


def test_without_room_it_comes_as_it_is(tmp_path: Path) -> None:
    result = _laid_down(work, tmp_path / "absent", task([4]))
    assert result == [4]
    assert _taken_up(result) == [4]


def test_what_does_not_count_has_no_file(tmp_path: Path) -> None:
    assert _laid_down(work, tmp_path, task(None)) is None
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(DifferentError):
        _taken_up(None)
