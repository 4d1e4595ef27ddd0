"""A long log is replayed in two processes, with the result of one."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from gap.worker_pool import worker_pool
from model.values.tick import Tick
from record.log.reader import LogContents, read_tick_messages
from robot.config.robot_file import RobotConfig
from robot.console import processes
from robot.replay.beside import estimates_as_recorded
from robot.replay.ticks import Replay, replay_log
from robot.run.rebuilt import config_of
from tests.replay.golden import log_of
from tests.robot.cli.test_bad_input import tick_bytes, with_messages
from tests.robot.replay.test_replay import changed, other_load
from tests.soaked import soaked

pytestmark = pytest.mark.usefixtures(
    "usual_pace"
)  # that of the golden walk, and of fresh interpreters


def without_time(result: Replay) -> Replay:
    return replace(result, wall_s=0.0)


def own_config(path: Path) -> RobotConfig:
    contents = LogContents()
    next(read_tick_messages(path, contents))
    return config_of(contents)


def another_yaw(tick: Tick) -> Tick:
    if tick.index < 30 or tick.estimate is None:
        return tick
    return replace(tick, estimate=replace(tick.estimate, yaw_rad=tick.estimate.yaw_rad + 1e-15))


@pytest.mark.parametrize("scale", soaked([1.0, 0.0], lambda scale: scale == 1.0))
def test_two_processes_give_the_result_of_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, scale: float
) -> None:
    if scale == 1.0:  # forked, for time; in soak a fresh interpreter, as usual
        monkeypatch.setattr("robot.replay.beside.worker_pool", partial(worker_pool, inherit=True))
    path = changed(tmp_path / "today.mcap", lambda tick: tick)
    alone = replay_log(path, scale=scale)
    assert alone.equal_bits == alone.ticks
    monkeypatch.setattr(processes, "LEAST_BYTES", 0)
    contents = LogContents()
    both = replay_log(path, scale=scale, contents=contents, processes=True)
    assert without_time(both) == without_time(alone)
    assert contents.progress.position == contents.progress.size


def test_what_differs_is_found_tick_by_tick(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(processes, "LEAST_BYTES", 0)
    path = changed(tmp_path / "load.mcap", lambda tick: other_load(tick, by_n=1e-3))
    contents = LogContents()
    result = replay_log(path, contents=contents, processes=True)
    assert not result.equal
    assert without_time(result) == without_time(replay_log(path))
    assert contents.damages == ()


def test_the_first_estimate_that_differs_is_counted(tmp_path: Path) -> None:
    same, other = tmp_path / "same.mcap", tmp_path / "other.mcap"
    ticks = replay_log(changed(same, lambda tick: tick)).ticks
    assert estimates_as_recorded(same, own_config(same)) == ticks
    assert estimates_as_recorded(changed(other, another_yaw), own_config(same)) == 30


def test_a_short_log_is_not_worth_a_process() -> None:
    path = log_of("tripod")
    message = next(read_tick_messages(path, LogContents()))
    assert not processes.worth_processes(path, message.layout)


def test_a_damaged_tick_ends_the_ticks_that_are_as_recorded(tmp_path: Path) -> None:
    whole, broken = tmp_path / "whole.mcap", tmp_path / "broken.mcap"
    changed(whole, lambda tick: tick)
    with_messages(whole, broken, {40: tick_bytes(whole)[40][:100]})
    assert estimates_as_recorded(broken, own_config(whole)) <= 40
