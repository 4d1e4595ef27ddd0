"""Hexapods with other servos walk on the virtual bus: without currents, and with a model a leg."""

import numpy as np
import pytest

from model.values.faults import FaultKind, StopReason
from model.values.tick import Mode
from robot.config.robot_file import parse_robot
from tests.robot.bench_runs import bench_run
from tests.robot.other_servos import MIXED, XL430, other_robot
from tests.robot.runs import drive, walk_then_stop


@pytest.mark.parametrize(
    ("changes", "measured"),
    [
        pytest.param(XL430, 0, id="XL430", marks=pytest.mark.soak),
        pytest.param(MIXED, 5, id="mixed"),
    ],
)
def test_it_walks_on_the_plant(changes: tuple[tuple[str, str], ...], measured: int) -> None:
    config = parse_robot(other_robot(*changes))
    result, ticks, _ = drive(walk_then_stop(4.2, frequency_hz=0.3), config=config)
    assert result.torque_off
    assert result.reason is StopReason.OPERATOR, result.detail
    walked = [tick for tick in ticks if tick.mode is Mode.WALK]
    assert len(walked) > 100
    assert not any(tick.faults for tick in ticks)
    for tick in walked:
        assert tick.joints.valid.all()
        known = np.isfinite(tick.joints.current_a)
        assert known.sum() == measured
        np.testing.assert_array_equal(known, config.servo_bus.measures_current)
    turned = np.abs(walked[-1].joints.angle_rad - walked[0].joints.angle_rad)
    assert turned.min() > 1.0


def test_a_jammed_shaft_without_a_current_stops_by_its_lag() -> None:
    config = parse_robot(other_robot(*XL430))
    jam = '[[fault]]\nkind = "stuck_shaft"\nservo = 1\nstart_s = 2.2\n'
    kept = bench_run(jam, config=config)
    kinds = {fault.kind for tick in kept.ticks for fault in tick.faults}
    assert FaultKind.SERVO_LAG in kinds
    assert not {FaultKind.SERVO_CURRENT, FaultKind.SERVO_STALLED} & kinds, "no current is judged"
    assert kept.result.reason is StopReason.SERVO_FAULT
