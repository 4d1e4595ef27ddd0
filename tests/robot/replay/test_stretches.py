"""A log with states in it is replayed in stretches, with the result of a replay tick by tick."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from gap.worker_pool import worker_pool
from record.log.reader import LogContents, TopicMessage, read_tick_messages
from record.log.stretches import find_stretches, read_stretch
from robot.console import processes, stretch_pool
from robot.control.state_bytes import bytes_of_state, state_of_bytes
from robot.replay import stretches
from robot.replay.stretches import StretchTask, replay_stretch
from robot.replay.ticks import replay_log


@pytest.fixture
def walked(walk_with_states: Path) -> Path:
    """A short walk with a state every second."""
    return walk_with_states


def task_of(path: Path, number: int) -> StretchTask:
    contents = LogContents()
    next(read_tick_messages(path, contents))
    metadata = tuple(contents.metadata.items())
    return StretchTask(path, contents.config_text, metadata, None, find_stretches(path)[number])


def test_stretches_hold_every_tick_once(walked: Path) -> None:
    parts = find_stretches(walked)
    assert len(parts) > 5
    assert [part.begin for part in parts[1:]] == [part.end for part in parts[:-1]]
    ticks = [m.sequence for part in parts for m in read_stretch(walked, LogContents(), part)]
    assert ticks == [m.sequence for m in read_tick_messages(walked, LogContents())]


def test_a_state_comes_back_bit_for_bit(walked: Path) -> None:
    task = task_of(walked, 4)
    assert task.stretch.before is not None
    gaits = stretches._controller(task.config_text, task.metadata, None).book.gaits
    state = state_of_bytes(task.stretch.before, gaits)
    assert state.index == task.stretch.begin
    assert bytes_of_state(state) == task.stretch.before


def test_every_stretch_ends_with_the_state_that_the_next_begins_with(walked: Path) -> None:
    for number, part in enumerate(find_stretches(walked)):
        done = replay_stretch(task_of(walked, number))
        assert done is not None
        assert part.end is None or done.ticks == part.end - part.begin


def test_a_state_with_another_number_in_it_does_not_count(walked: Path) -> None:
    task = task_of(walked, 2)
    assert task.stretch.after is not None
    other = bytearray(task.stretch.after)
    other[-3] ^= 1
    wrong = replace(task, stretch=replace(task.stretch, after=bytes(other)))
    assert replay_stretch(wrong) is None


@pytest.mark.parametrize("from_the_end", [1, 60, 400, 900])
def test_an_estimate_with_another_bit_in_it_does_not_count(
    monkeypatch: pytest.MonkeyPatch, walked: Path, from_the_end: int
) -> None:
    """The estimate is the last part of a tick; here one bit of it differs, in one tick of a stretch."""
    task = task_of(walked, 2)
    assert replay_stretch(task) is not None

    def changed(*arguments: Any) -> Iterator[TopicMessage]:
        for place, message in enumerate(read_stretch(*arguments)):
            data = bytearray(message.data)
            data[-from_the_end] ^= 1 if place == 40 else 0
            yield replace(message, data=bytes(data))

    monkeypatch.setattr(stretches, "read_stretch", changed)
    assert replay_stretch(task) is None


def test_stretches_give_the_result_of_one_pass(
    monkeypatch: pytest.MonkeyPatch, walked: Path
) -> None:
    alone = replay_log(walked)
    monkeypatch.setattr(processes, "LEAST_BYTES", 0)
    # forked: the quicker moves of tests hold in the processes, too
    monkeypatch.setattr(stretch_pool, "worker_pool", partial(worker_pool, inherit=True))
    contents = LogContents()
    run = stretches.replay_stretches(walked, contents_of(walked), None)
    assert run is not None
    assert run.ticks == alone.ticks
    together = replay_log(walked, contents=contents, processes=True)
    assert replace(together, wall_s=0.0) == replace(alone, wall_s=0.0)
    assert contents.progress.position == contents.progress.size


def contents_of(path: Path) -> LogContents:
    contents = LogContents()
    next(read_tick_messages(path, contents))
    return contents


def test_a_log_that_ends_with_a_state_has_no_stretch_without_ticks(walked: Path) -> None:
    """It had one, which ended with no tick, so that nothing was concluded from all the others."""
    parts = find_stretches(walked)
    ticks = len(list(read_tick_messages(walked, LogContents())))
    assert parts[-1].after is not None, (
        "this walk takes whole seconds, and a state is written in each"
    )
    assert parts[-1].end == ticks
