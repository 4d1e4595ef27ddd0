"""Estimates kept as columns are those that the estimator gave, in every bit."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from model.values.estimate import Estimate, Health
from record.log.reader import read_stamped_ticks
from robot.config.robot_file import load_robot
from robot.control.tick_estimator import TickEstimator
from robot.odometry import estimates as columns
from robot.odometry.estimates import EstimateColumns, EstimateSeries
from tests.replay.golden import log_of


def walked(count: int) -> list[Estimate]:
    estimator, path = TickEstimator(load_robot()), Path(log_of("tripod"))
    ticks = (item.tick for item in read_stamped_ticks(path))
    return [estimator.step(tick.sensed) for tick, _ in zip(ticks, range(count), strict=False)]


@pytest.fixture(scope="module")
def given() -> list[Estimate]:
    made = walked(60)
    made[7] = replace(made[7], health=Health.LOST, reason="no forces", remark="a shaft's zero")
    made[9] = replace(made[9], health=Health.DEGRADED, reason="no forces; a gap of 2 s")
    return made


def same(one: Estimate, other: Estimate) -> bool:
    return all(
        np.array_equal(getattr(one, f.name), getattr(other, f.name), equal_nan=True)
        if isinstance(getattr(one, f.name), float | np.ndarray)
        else getattr(one, f.name) == getattr(other, f.name)
        for f in fields(Estimate)
    )


def test_each_comes_back_as_it_was(given: list[Estimate], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "BLOCK", 16)
    kept = EstimateSeries.of(given)
    assert len(kept) == len(given)
    assert all(same(one, other) for one, other in zip(kept, given, strict=True))
    assert same(kept[-1], given[-1])
    assert same(kept[5:12][3], given[8])
    assert not kept[0].position_m.flags.writeable
    assert kept.healths == [one.health for one in given]
    assert kept.reasons == [one.reason for one in given]
    assert kept.remarks[7] == "a shaft's zero"
    with pytest.raises(IndexError):
        kept[len(given)]


def test_a_column_is_a_field_of_all(given: list[Estimate]) -> None:
    kept = EstimateSeries.of(given)
    np.testing.assert_array_equal(kept.column("mu"), np.array([one.mu for one in given]))
    assert kept.column("nis_dof").dtype == np.float64
    for name in ("health", "reason"):
        with pytest.raises(KeyError):
            kept.column(name)


def test_columns_grow_on_after_they_were_looked_at(given: list[Estimate]) -> None:
    growing = EstimateColumns()
    for number, one in enumerate(given, start=1):
        growing.add(one)
        if number % 7 == 0:
            assert len(growing.estimates()) == len(growing) == number
    assert same(growing.estimates()[0], given[0])
    assert same(growing.estimates()[-1], given[-1])


def test_a_whole_number_first_does_not_round_what_follows(given: list[Estimate]) -> None:
    first = replace(given[0], yaw_rad=0)
    kept = EstimateSeries.of([first, replace(given[1], yaw_rad=0.25)])
    assert kept.column("yaw_rad").tolist() == [0.0, 0.25]
