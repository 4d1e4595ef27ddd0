"""An estimator over the ticks of a log, in blocks: what it makes of them one by one, in every bit."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from model.errors import ConfigError
from model.values.arrays import part_of
from model.values.estimate import Estimate
from model.values.legs import JointState
from model.values.readings import ImuRecord, PoseRecord
from model.values.tick import SensedTick
from model.values.tick_rows import JointRows, SensedRows
from record.exact_values import encode_values
from record.log.reader import LogContents, read_stamped_ticks
from robot.config.robot_file import RobotConfig
from robot.control.tick_estimator import SingleTick, TickEstimator
from robot.run.rebuilt import config_of

TICKS = 400
JOINTS = JointRows.__slots__[1:]


@pytest.fixture(scope="module")
def walked(cycle_walk: Path) -> tuple[RobotConfig, list[SensedTick]]:
    """A robot, and ticks of its walk, from where its legs begin to move."""
    contents = LogContents()
    stamped = islice(read_stamped_ticks(cycle_walk, contents), 500, 500 + TICKS)
    ticks = [one.tick.sensed for one in stamped]
    return config_of(contents), ticks


def estimated(
    config: RobotConfig, ticks: Sequence[SensedTick], sizes: Sequence[int] = (50, 1, 149)
) -> tuple[list[Estimate], int]:
    """Go through ticks in blocks; return the estimates, and how many ticks stood by themselves."""
    estimator, said, alone, at, turn = TickEstimator(config, blocks=True), list[Estimate](), 0, 0, 0
    while at < len(ticks):
        part = ticks[at : at + sizes[turn % len(sizes)]]
        for made in estimator.through(SensedRows.stacked(part)):
            if isinstance(made, SingleTick):
                alone += 1
                said.append(made.estimate)
            else:
                said += [made.estimate(k) for k in range(len(made))]
        at, turn = at + len(part), turn + 1
    return said, alone


def one_by_one(config: RobotConfig, ticks: Sequence[SensedTick]) -> list[Estimate]:
    estimator = TickEstimator(config)
    return [estimator.step(tick) for tick in ticks]


def assert_same(config: RobotConfig, ticks: Sequence[SensedTick], most_alone: int) -> None:
    said, alone = estimated(config, ticks)
    expected = one_by_one(config, ticks)
    assert list(map(encode_values, said)) == list(map(encode_values, expected))
    assert alone <= most_alone


def test_a_walk(walked: tuple[RobotConfig, list[SensedTick]]) -> None:
    config, ticks = walked
    assert_same(config, ticks, 3)  # the first tick, and parts that are too short


def test_poses_and_an_imu_in_some_ticks(walked: tuple[RobotConfig, list[SensedTick]]) -> None:
    """A pose that comes late is put into a tick of the block before."""
    config, ticks = walked
    mixed = list(ticks)
    for at in (60, 61, 200, 330):
        late_ns = ticks[at - 4].t_ns if at > 100 else ticks[at].t_ns
        place, level = np.array([0.01, 0.0, 0.2]), np.array([0.0, 0.0, 0.0, 1.0])
        mixed[at] = replace(ticks[at], poses=(PoseRecord(late_ns, place, level, np.nan, np.nan),))
    for at in range(250, 300):
        mixed[at] = replace(ticks[at], imu=(ImuRecord(ticks[at].t_ns, 0.01, 0.0, 0.0),))
    assert_same(config, mixed, 60)


def test_a_slow_loop_is_gone_through_tick_by_tick(
    walked: tuple[RobotConfig, list[SensedTick]],
) -> None:
    """There each shaft's speed is corrected by its angles."""
    config, ticks = walked
    assert_same(config, ticks[::3], TICKS)
    assert estimated(config, ticks[::3])[1] == len(ticks[::3])


def test_ticks_of_another_robot_are_refused(walked: tuple[RobotConfig, list[SensedTick]]) -> None:
    config, ticks = walked
    joints = JointRows.stacked([ticks[9].joints])
    fewer = JointState(joints.t_ns[0], *(getattr(joints, name)[0, :5] for name in JOINTS))
    other = SensedRows.stacked([replace(ticks[9], joints=fewer)])
    with pytest.raises(ConfigError, match="6 joints, the log 5"):
        list(TickEstimator(config, blocks=True).through(other))
    nothing = part_of(SensedRows.stacked(ticks[:1]), slice(0))
    assert list(TickEstimator(config).through(nothing)) == []
