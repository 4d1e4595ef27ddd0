"""``odom`` of a log with states in it, in stretches: the answer of one pass, to the bit."""

from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

from gap.worker_pool import worker_pool
from record.log.reader import LogContents, read_stamped_ticks, read_tick_messages
from record.log.recording import ARRAYS
from record.log.stretches import find_stretches
from robot.config.robot_file import parse_robot
from robot.console import processes, stretch_pool
from robot.odometry.estimates import HEALTH, NAMES, TEXTS
from robot.odometry.stretches import TrackTask, track_stretch, track_stretches
from robot.odometry.track import Track, track, track_log
from robot.requests.recorded import OdomRequest


@pytest.fixture
def walked(walk_with_states: Path) -> Path:
    """A short walk with a state every second."""
    return walk_with_states


def task_of(path: Path, number: int) -> TrackTask:
    contents = LogContents()
    next(read_tick_messages(path, contents))
    metadata = tuple(contents.metadata.items())
    return TrackTask(path, contents.config_text, metadata, find_stretches(path)[number])


def test_stretches_give_the_track_of_one_pass(
    monkeypatch: pytest.MonkeyPatch, walked: Path
) -> None:
    monkeypatch.setattr(processes, "LEAST_BYTES", 0)
    # forked: what tests change holds in the processes, too
    monkeypatch.setattr(stretch_pool, "worker_pool", partial(worker_pool, inherit=True))
    contents = LogContents()
    together, alone = track_stretches(walked, OdomRequest(), contents), track_log(walked)
    assert together is not None
    assert contents.progress.position == contents.progress.size
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(together.log, name), getattr(alone.log, name))
    assert together.log.metadata == alone.log.metadata
    assert together.log.faults == alone.log.faults
    one, other = together.track.estimates, alone.track.estimates
    for name in set(NAMES) - {HEALTH, *TEXTS}:
        np.testing.assert_array_equal(one.column(name), other.column(name))
    assert (one.healths, one.reasons, one.remarks) == (other.healths, other.reasons, other.remarks)
    for name in ("t_s", "unix_ns", "rejections", "anchored"):
        np.testing.assert_array_equal(getattr(together.track, name), getattr(alone.track, name))


def test_other_settings_than_the_logs_own_are_tracked_in_one_pass(
    monkeypatch: pytest.MonkeyPatch, walked: Path
) -> None:
    monkeypatch.setattr(processes, "LEAST_BYTES", 0)
    for request in (
        OdomRequest(no_forces=True),
        OdomRequest(smooth=True),
        OdomRequest(no_sway=True),
    ):
        assert track_stretches(walked, request, LogContents()) is None


def test_a_stretch_from_another_state_does_not_count(walked: Path) -> None:
    third, fourth = task_of(walked, 2), task_of(walked, 3)
    assert track_stretch(third) is not None
    wrong = replace(third, stretch=replace(third.stretch, before=fourth.stretch.before))
    assert track_stretch(wrong) is None


def test_bytes_that_are_no_state_do_not_count(walked: Path) -> None:
    task = task_of(walked, 2)
    for data in (b"", b"\xff\xff\xff\xff", (task.stretch.before or b"")[:-1]):
        assert track_stretch(replace(task, stretch=replace(task.stretch, before=data))) is None


@cache  # both are compared with it
def tick_by_tick(walked: Path) -> Track:
    contents = LogContents()
    next(read_tick_messages(walked, contents))
    return track(read_stamped_ticks(walked), parse_robot(contents.config_text))


@pytest.mark.parametrize("is_long", [False, True])
def test_many_ticks_at_once_change_nothing(
    monkeypatch: pytest.MonkeyPatch, walked: Path, is_long: bool
) -> None:
    """A log hands over the feet of many ticks, and a long one is estimated in blocks."""
    monkeypatch.setattr(processes, "LEAST_BYTES", 0 if is_long else 1 << 30)
    together, alone = track_log(walked), tick_by_tick(walked)
    one, other = together.track.estimates, alone.estimates
    for name in set(NAMES) - {HEALTH, *TEXTS}:
        np.testing.assert_array_equal(one.column(name), other.column(name))
