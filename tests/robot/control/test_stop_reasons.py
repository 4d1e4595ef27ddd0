"""Every stop has a reason in log, on screen and in the exit code; an emergency stop stays one."""

from dataclasses import replace

import numpy as np
import pytest

from gaits.moves import MovePace
from model.values.faults import Fault, FaultKind, StopReason
from model.values.tick import Intent, Mode
from record.log.tick_message import decode_tick, encode_tick
from robot.console.exit_codes import ExitCode
from robot.control.modes import GaitBook, Phase, Situation, advance
from robot.control.stops import STOPS, StopKind, cause_words, gravest, stop_at_once
from tests.record.ticks import make_tick
from tests.robot.bench_runs import bench_run, changed
from tests.robot.runs import wish
from tests.soaked import soaked

# Their cause is the operator, not a fault.
ASKED = {
    StopReason.COMPLETED,
    StopReason.OPERATOR,
    StopReason.EMERGENCY,
    StopReason.GAIT_REFUSED,
}
REASONS = [reason for reason in StopReason if reason is not StopReason.NONE]


def test_every_stop_that_nobody_asked_for_has_faults_as_its_cause() -> None:
    assert set(STOPS) == set(StopReason)
    assert {reason for reason, stop in STOPS.items() if stop.causes} == set(REASONS) - ASKED
    assert all(stop.words for stop in STOPS.values())


@pytest.mark.parametrize("reason", [r for r in REASONS if STOPS[r].causes])
def test_the_cause_is_told_in_words_and_the_exit_code_is_not_0(reason: StopReason) -> None:
    kind = next(iter(STOPS[reason].causes))
    faults = (Fault(kind, "FL", "what happened"), Fault(FaultKind.NO_SUPPORT, "x", "no cause"))
    tick = replace(make_tick(0), stop_reason=reason, faults=faults)
    assert cause_words(tick.stop_reason, tick.faults) == "FL: what happened"
    assert STOPS[reason].exit_code is not ExitCode.OK
    again = decode_tick(encode_tick(tick))
    assert (again.stop_reason, again.faults) == (reason, faults), "and it is in the log"


def test_a_loop_that_stood_still_while_torque_went_on_says_for_how_long() -> None:
    refused = Fault(FaultKind.REFUSED, "safety gate", "the command before is 302 ms old")
    tick = replace(make_tick(0), stop_reason=StopReason.TIMING, faults=(refused,))
    assert (
        cause_words(tick.stop_reason, tick.faults)
        == "safety gate: the command before is 302 ms old"
    )


@pytest.mark.parametrize("reason", REASONS)
def test_an_emergency_stop_is_latched(reason: StopReason) -> None:
    limp = Phase(Mode.LIMP, None, None, StopReason.EMERGENCY)
    book = GaitBook({}, {}, MovePace(2.0, 60.0))
    for intent in (Intent.WALK, Intent.STAND, Intent.STOP):
        now = Situation(10**9, wish(intent), reason, np.zeros(6), armed=True)
        after = advance(limp, now, book)
        assert after.mode is Mode.LIMP
        assert after.plan is None
        assert STOPS[after.stop_reason].kind is StopKind.CUT


def test_the_gravest_stop_counts_and_of_equals_the_first() -> None:
    assert gravest(StopReason.COMPLETED, StopReason.TILTED, StopReason.NONE) is StopReason.TILTED
    assert gravest(StopReason.TILTED, StopReason.EMERGENCY) is StopReason.EMERGENCY
    assert gravest(StopReason.TIMING, StopReason.TILTED) is StopReason.TIMING


def test_a_fault_that_stops_at_once_and_one_that_must_last() -> None:
    gone, silent = (Fault(kind, "", "") for kind in (FaultKind.LINK_LOST, FaultKind.SERVO_SILENT))
    unwritten = Fault(FaultKind.LOG_WRITE, "log", "")
    assert stop_at_once((unwritten, gone)) is StopReason.LINK_LOST
    assert stop_at_once((silent,)) is StopReason.NONE
    assert stop_at_once(()) is StopReason.NONE


def test_a_servo_that_cannot_confirm_is_told_of() -> None:
    silent = '[[fault]]\nkind = "silent_servo"\nservo = 2\nstart_s = 2.0\n'
    done = bench_run(silent)
    assert done.result.reason is StopReason.SERVO_LOST
    assert done.result.torque_off is False, "nobody can say that the silent one is off"


ONE_PERCENT = "".join(
    f'[[fault]]\nkind = "{kind}"\nrate = 0.01\n'
    for kind in (
        "lost_reply", "bit_flip", "late_reply", "truncated_reply", "duplicated_reply",
        "foreign_reply", "echo", "packet_loss", "duplicate_packet", "reordered_packet",
    )
)  # fmt: skip


@pytest.mark.parametrize("seed", soaked(range(12), lambda seed: seed < 4))
def test_it_starts_in_spite_of_one_percent_of_every_fault(seed: int) -> None:
    """From the first byte on: finding, setting up, arming, watchdog, console, first steps."""
    done = bench_run(ONE_PERCENT, begins="power", seed=seed, seconds=1.0, config=changed())
    assert done.modes[:2] == [Mode.ARMED, Mode.START] or done.modes[:3] == [
        Mode.IDLE,
        Mode.ARMED,
        Mode.START,
    ]
    assert done.result.reason is StopReason.EMERGENCY, done.result.detail
    assert done.result.torque_off
