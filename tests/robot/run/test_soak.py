"""Some of the soak: nothing wrong passes for right, and the witness would see it if it did."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.faults.soak import RUN_S, cause_of, random_faults, soak
from benchmarks.faults.witness import Findings, MarkedBench, Witness
from model.values.faults import StopReason
from model.values.tick import Mode
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.faults.kinds import KINDS, StuckShaft
from tests.record.ticks import NAMES, make_tick
from tests.soaked import THOROUGH, soaked


@pytest.mark.parametrize(
    "seconds",
    [*soaked((6.0, 10.0), lambda seconds: seconds < 10), pytest.param(60.0, marks=THOROUGH)],
)
def test_faults_on_faults(seconds: float) -> None:
    found = soak(seconds, seed=5)
    assert found.surprises == []
    assert found.wrong_readings == found.wrong_records == 0
    assert found.left_behind.total() == 0
    assert found.readings > 330 * seconds
    assert found.records > 50 * seconds
    assert found.faults["SERVO_SILENT"] > 5 * seconds, "the faults were there"
    assert found.reasons.total() + found.refused.total() == found.runs


def test_every_kind_of_fault_is_in_a_run() -> None:
    faults = random_faults(np.random.default_rng(1))
    assert {type(fault) for fault in faults} == set(KINDS.values())
    assert all(fault.start_s < RUN_S for fault in faults)


def test_the_witness_sees_a_stale_reading() -> None:
    world, findings = MarkedBench(FirmwareBank(6), np.full(6, 2048), 60.0, 1), Findings()
    witness = Witness(world, findings, NAMES, np.ones(6, dtype=np.int64))
    world.advance_to(0)
    world.advance_to(100_000_000)
    base = make_tick(0)
    assert base.inputs.servos is not None
    for age_ns, wrong in ((0, 0), (30_000_000, 6)):
        world.advance_to(world.past[-1][0] + 40_000_000)
        now_ns = world.past[-1][0]
        _, there, flowing = next(s for s in world.past if s[0] == now_ns - age_ns)
        servos = replace(
            base.inputs.servos,
            t_ns=now_ns,
            position_ticks=np.rint(there).astype(np.int64),
            current_counts=np.rint(flowing / 3.36e-3).astype(np.int64),
            valid=np.ones(6, dtype=bool),
        )
        tick = replace(base, t_ns=now_ns, inputs=replace(base.inputs, servos=servos, forces=()))
        before = findings.wrong_readings
        witness.write(tick)
        assert findings.wrong_readings - before == wrong


def test_the_witness_sees_a_leg_that_is_left_behind() -> None:
    world, findings = MarkedBench(FirmwareBank(6), np.full(6, 2048), 60.0, 1), Findings()
    witness = Witness(world, findings, NAMES, np.ones(6, dtype=np.int64))
    world.advance_to(0)
    base = replace(make_tick(0), mode=Mode.WALK, stop_reason=StopReason.NONE, faults=())
    base = replace(base, inputs=replace(base.inputs, servos=None, forces=()))
    for step in range(80):
        sent = replace(base.sent, angle_rad=np.full(6, 0.0) + 0.01 * step * (np.arange(6) == 2))
        witness.write(replace(base, t_ns=step * 10_000_000, sent=sent))
    assert findings.left_behind == {NAMES[2]: 1}


def test_a_stop_is_booked_to_what_was_on() -> None:
    jam = StuckShaft(servo=1, start_s=5.0, duration_s=2.0)
    assert cause_of(StopReason.SERVO_STALLED, [jam], 6.0) == "stuck_shaft"
    assert cause_of(StopReason.SERVO_STALLED, [jam], 4.0) == "", "it had not begun"
    assert cause_of(StopReason.LINK_LOST, [jam], 6.0) == "", "it cannot cause that"
