"""The safety gate lets a command through whole or refuses it with a reason; the watch finds faults."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel.joints import joint_state
from drivers.dynamixel.units import TICKS_PER_TURN
from model.values.faults import FaultKind, StopReason
from model.values.legs import JointCommand
from model.values.readings import ServoReadings, silent_readings
from model.values.tick import Intent, Mode
from robot.config.robot_file import load_robot
from robot.control import safety
from robot.control.safety import (
    PERSISTENCE_READS,
    Allowed,
    Refused,
    ServoVerdict,
    gate,
    watch_servos,
    watch_turns,
)
from robot.control.stops import stop_at_once
from tests.robot.runs import Told, drive, modes_of, wish

CONFIG = load_robot()
LIMITS, BUS = CONFIG.limits, CONFIG.servo_bus
PERIOD_NS = 10_000_000


def command(t_ns: int, angle: float = 0.0, *, torque: bool = True) -> JointCommand:
    return JointCommand(t_ns, np.full(6, angle), np.zeros(6), torque)


def test_an_ordinary_command_passes_unchanged() -> None:
    wished = command(PERIOD_NS, 0.01)
    verdict = gate(wished, command(0), LIMITS, BUS)
    assert isinstance(verdict, Allowed)
    assert verdict.command is wished


def test_torque_off_always_passes() -> None:
    nan = np.full(6, np.nan)
    off = JointCommand(5, nan, nan, torque=False)
    assert isinstance(gate(off, command(9), LIMITS, BUS), Allowed)


@given(leg=st.integers(0, 5), value=st.sampled_from([np.nan, np.inf, -np.inf]), rate=st.booleans())
def test_what_is_no_number_is_refused(leg: int, value: float, rate: bool) -> None:
    wrong = np.zeros(6)
    wrong[leg] = value
    angle, speed = (np.zeros(6), wrong) if rate else (wrong, np.zeros(6))
    verdict = gate(JointCommand(PERIOD_NS, angle, speed, torque=True), command(0), LIMITS, BUS)
    assert isinstance(verdict, Refused)
    assert verdict.reason == f"{BUS.names[leg]}: the command is not a number"


def test_only_what_passes_the_gate_brings_a_servo_back() -> None:
    allowed = gate(command(PERIOD_NS), command(0), LIMITS, BUS, recover=(2,))
    assert isinstance(allowed, Allowed)
    assert allowed.recover == (2,)
    off = gate(command(PERIOD_NS, torque=False), command(0), LIMITS, BUS, recover=(2,))
    assert isinstance(off, Allowed)
    assert off.recover == ()
    assert isinstance(gate(command(0), command(0), LIMITS, BUS, recover=(2,)), Refused)


@given(step=st.floats(-3, 3), milliseconds=st.integers(1, 249))
def test_speed_is_the_boundary(step: float, milliseconds: int) -> None:
    elapsed_s = milliseconds * 1e-3
    verdict = gate(command(milliseconds * 1_000_000, step), command(0), LIMITS, BUS)
    if abs(step) <= LIMITS.max_speed_rad_s * elapsed_s:
        assert isinstance(verdict, Allowed)
    if abs(step) > LIMITS.max_speed_rad_s * elapsed_s * 1.05 + 0.0016:
        assert isinstance(verdict, Refused)


def test_a_speed_refusal_names_leg_and_limit() -> None:
    wished = replace(command(PERIOD_NS), angle_rad=np.array([0, 0, 0, 0, 0.5, 0]))
    verdict = gate(wished, command(0), LIMITS, BUS)
    assert isinstance(verdict, Refused)
    assert verdict.reason.startswith("MR: a step of 0.500 rad in 10 ms")


@pytest.mark.parametrize(("t_ns", "words"), [(0, "not newer"), (300_000_000, "stood still")])
def test_stale_and_repeated_commands_are_refused(t_ns: int, words: str) -> None:
    verdict = gate(command(t_ns), command(0), LIMITS, BUS)
    assert isinstance(verdict, Refused)
    assert words in verdict.reason


@pytest.mark.parametrize("turns", [-255.0, 255.0])
def test_the_end_of_the_turn_counter_is_refused(turns: float) -> None:
    angle = turns * 2 * np.pi
    verdict = gate(command(PERIOD_NS, angle), command(0, angle), LIMITS, BUS)
    assert isinstance(verdict, Refused)
    assert "turn counter" in verdict.reason


def test_behind_the_end_of_the_turn_counter_no_other_reason_is_given() -> None:
    """A plan that goes on is soon far from the last goal; that is not why it was refused."""
    angle = 255.0 * 2 * np.pi
    last = command(0, angle - 0.3)
    verdict = gate(command(6 * PERIOD_NS, angle), last, LIMITS, BUS, refused_ns=5 * PERIOD_NS)
    assert isinstance(verdict, Refused)
    assert "turn counter" in verdict.reason


@pytest.mark.parametrize("turns", [-253, 253])
def test_turns_that_are_nearly_used_up_are_a_fault_of_that_servo(turns: int) -> None:
    ticks = np.zeros(6, dtype=np.int64)
    ticks[4] = turns * TICKS_PER_TURN
    readings = replace(healthy(), position_ticks=ticks)
    (fault,) = watch_turns(readings, command(0), BUS.names)
    assert (fault.kind, fault.source) == (FaultKind.TURNS_USED, BUS.names[4])
    assert fault.detail == "253 of 256 turns are used"
    assert stop_at_once((fault,)) is StopReason.TURNS_USED
    assert watch_turns(readings, command(0, torque=False), BUS.names) == ()
    lost = replace(readings, valid=np.arange(6) != 4)
    assert watch_turns(lost, command(0), BUS.names) == ()
    assert watch_turns(replace(readings, position_ticks=ticks - ticks), command(0), BUS.names) == ()


def test_a_walk_ends_on_all_feet_before_the_turns_are_used_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As if the counters ended after one turn and a half."""
    monkeypatch.setattr(safety, "ENDING_TICK", 3 * TICKS_PER_TURN // 2)
    result, ticks, _ = drive(Told(lambda _, tick: wish(Intent.WALK, frequency_hz=0.3)))
    assert result.reason is StopReason.TURNS_USED
    assert "1 of 256 turns" in result.detail or "2 of 256 turns" in result.detail
    assert modes_of(ticks)[-4:] == [Mode.WALK, Mode.SLOW, Mode.SETTLE, Mode.HOLD]
    assert not [f for tick in ticks for f in tick.faults if f.kind is FaultKind.REFUSED]
    assert result.torque_off
    turned = np.abs(ticks[-1].joints.angle_rad / (2 * np.pi))
    assert turned.max() < 1.5 + 2.0  # what is left behind the limit for coming to rest


def healthy() -> ServoReadings:
    return replace(
        silent_readings(0, 6),
        position_ticks=np.full(6, 2048),
        voltage_counts=np.full(6, 120),
        temperature_c=np.full(6, 30),
        hardware_error=np.zeros(6, dtype=np.int64),
        valid=np.ones(6, dtype=bool),
        age_ns=np.zeros(6, dtype=np.int64),
    )


def watch(readings: ServoReadings, silent: int = 0, bad: int = 0):  # type: ignore[no-untyped-def]
    before = replace(
        ServoVerdict.sound(6), silent_reads=np.full(6, silent), bad_reads=np.full(6, bad)
    )
    return watch_servos(readings, joint_state(readings, BUS), command(0), before, LIMITS, BUS)


def test_healthy_servos_give_no_fault() -> None:
    verdict = watch(healthy())
    assert verdict.faults == ()
    assert not verdict.lost_legs.any()
    assert not verdict.broken_legs.any()


def test_one_silent_servo_is_a_fault_then_a_loss() -> None:
    valid = np.array([True, True, False, True, True, True])
    readings = replace(healthy(), valid=valid)
    first = watch(readings)
    assert [(f.kind, f.source) for f in first.faults] == [(FaultKind.SERVO_SILENT, "FL")]
    assert not first.lost_legs.any()
    assert watch(readings, silent=BUS.silent_limit - 1).lost_legs.any()


def test_alert_bit_stops_at_once_and_names_the_cause() -> None:
    error = np.array([0, 0x80, 0, 0, 0, 0])
    hardware = np.array([0, 0x20, 0, 0, 0, 0])
    verdict = watch(replace(healthy(), error_byte=error, hardware_error=hardware))
    assert verdict.broken_legs.any()
    assert verdict.faults[0].source == "ML"
    assert "overload" in verdict.faults[0].detail


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        ({"temperature_c": np.array([30, 30, 30, 30, 30, 75])}, FaultKind.SERVO_HOT),
        ({"current_counts": np.array([0, 0, 0, 0, 0, -1300])}, FaultKind.SERVO_CURRENT),
        ({"voltage_counts": np.array([120, 120, 120, 120, 120, 90])}, FaultKind.SERVO_VOLTAGE),
        ({"position_ticks": np.array([2048] * 5 + [2648])}, FaultKind.SERVO_LAG),
    ],
)
def test_limits_must_be_exceeded_for_a_while(
    change: dict[str, np.ndarray], kind: FaultKind
) -> None:
    readings = replace(healthy(), **change)  # type: ignore[arg-type]
    once = watch(readings)
    assert [(f.kind, f.source) for f in once.faults] == [(kind, "FR")]
    assert not once.broken_legs.any()
    assert watch(readings, bad=PERSISTENCE_READS - 1).broken_legs.any()


@given(jump=st.floats(0.1, 3.0), sense=st.sampled_from([-1, 1]))
def test_a_jump_stays_refused_however_often_it_is_asked_for(jump: float, sense: int) -> None:
    last, refused_ns = command(0), None
    for tick in range(1, 24):
        wished = command(tick * PERIOD_NS, sense * jump)
        assert isinstance(gate(wished, last, LIMITS, BUS, refused_ns=refused_ns), Refused)
        refused_ns = wished.t_ns


def test_after_a_refusal_an_ordinary_command_passes_again() -> None:
    wished = command(2 * PERIOD_NS, 0.01)
    assert isinstance(gate(wished, command(0), LIMITS, BUS, refused_ns=PERIOD_NS), Allowed)
