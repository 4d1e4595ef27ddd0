"""Bounded recovery: decided in the pure step, done by the bus, and back as an input."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.dynamixel.registers import HardwareError
from model.values.faults import FaultKind, ServoEvent, StopReason
from model.values.tick import Mode
from robot.config.safety import RecoverySettings
from robot.control.recovery import RecoveryInputs, RecoveryMemory, RecoveryPlan, plan_recovery
from robot.control.safety import ServoVerdict
from robot.run.rig import policy_of
from tests.robot.bench_runs import BenchRun, bench_run, changed
from tests.robot.runs import CONFIG

NAMES = CONFIG.servo_bus.names
SETTINGS = RecoverySettings(most=2, window=300.0, wait=1.0)
NONE = np.zeros(6, dtype=bool)
DOWN = ServoEvent(2, FaultKind.SERVO_DOWN)
BACK = ServoEvent(2, FaultKind.SERVO_RECOVERED)
FAILED = ServoEvent(2, FaultKind.RECOVERY_FAILED)
FL = np.array([False, False, True, False, False, False])


def known(*events: ServoEvent, t_ns: int = 0, **more: object) -> RecoveryInputs:
    verdict = ServoVerdict((), NONE.astype(np.int64), NONE, NONE, NONE.astype(np.int64))
    usual = RecoveryInputs(
        t_ns, events, verdict, ~NONE, np.zeros(6, dtype=np.int64), holding=False, torque=True
    )
    return replace(usual, **more)  # type: ignore[arg-type]


def lost(legs: np.ndarray) -> ServoVerdict:
    return ServoVerdict((), NONE.astype(np.int64), legs, NONE, NONE.astype(np.int64))


def step(memory: RecoveryMemory, *events: ServoEvent, **more: object) -> RecoveryPlan:
    return plan_recovery(memory, known(*events, **more), SETTINGS, NAMES)  # type: ignore[arg-type]


def asked() -> RecoveryPlan:
    paused = step(RecoveryMemory.empty(6), DOWN)
    return step(paused.memory, holding=True)


def test_it_holds_then_asks_then_goes_on() -> None:
    paused = step(RecoveryMemory.empty(6), DOWN)
    assert paused.pause
    assert paused.ask == ()
    assert paused.stop is StopReason.NONE
    assert step(paused.memory).ask == (), "not before it holds"
    asking = step(paused.memory, holding=True)
    assert asking.ask == (2,)
    assert [(f.kind, f.source) for f in asking.faults] == [(FaultKind.RECOVERING, "FL")]
    done = step(asking.memory, BACK, holding=True)
    assert done.resume is not None
    assert done.resume.tolist() == FL.tolist()
    assert not done.pause


def test_it_is_bounded() -> None:
    memory = RecoveryMemory.empty(6)
    for _ in range(2):
        memory = step(memory, DOWN).memory
        memory = step(memory, holding=True).memory
        memory = step(memory, BACK, holding=True).memory
    memory = step(memory, DOWN, t_ns=10**9).memory
    refused = step(memory, holding=True, t_ns=10**9)
    assert refused.ask == ()
    assert refused.stop is StopReason.SERVO_FAULT
    assert "2 recoveries of 2 within 300 s are used up" in refused.faults[0].detail
    later = step(memory, holding=True, t_ns=301 * 10**9)
    assert later.ask == (2,), "the window has passed"


def test_a_failure_stops() -> None:
    assert step(asked().memory, FAILED, holding=True).stop is StopReason.SERVO_FAULT


def test_without_the_table_it_stops_at_once() -> None:
    found = plan_recovery(RecoveryMemory.empty(6), known(DOWN), RecoverySettings(), NAMES)
    assert found.stop is StopReason.SERVO_FAULT
    assert not found.pause
    silent = known(verdict=lost(FL))
    gone = plan_recovery(RecoveryMemory.empty(6), silent, RecoverySettings(), NAMES)
    assert gone.stop is StopReason.SERVO_LOST


def test_a_silent_servo_is_waited_for_and_not_for_ever() -> None:
    age = np.where(FL, 900_000_000, 0)
    waiting = step(RecoveryMemory.empty(6), verdict=lost(FL), age_ns=age, valid=~FL)
    assert waiting.pause
    assert waiting.stop is StopReason.NONE
    assert waiting.ask == ()
    too_long = step(waiting.memory, verdict=lost(FL), age_ns=age + 200_000_000, valid=~FL)
    assert too_long.stop is StopReason.SERVO_LOST
    never = step(RecoveryMemory.empty(6), verdict=lost(FL), age_ns=np.where(FL, -1, 0), valid=~FL)
    assert never.stop is StopReason.SERVO_LOST


def test_another_broken_servo_stops_while_one_is_down() -> None:
    memory = step(RecoveryMemory.empty(6), DOWN).memory
    verdict = replace(lost(NONE), broken_legs=FL)
    assert step(memory, verdict=verdict).stop is StopReason.NONE, "the one that is being seen to"
    assert step(memory, verdict=replace(verdict, broken_legs=~FL)).stop is StopReason.SERVO_FAULT


# On the whole loop.

RECOVERY = "[safety.recovery]\nmost = 2\nafter_restart = true\n"
OVERLOAD_LIMITS = {"max_current = 4.0 ": "max_current = 6.8 "}


def turns_and_brownouts(count: int, *, estimate: bool = False) -> BenchRun:
    faults = "".join(
        f'[[fault]]\nkind = "brownout"\nservo = 4\nstart_s = {2.2 + 3.2 * n}\nduration_s = 0.1\n'
        for n in range(count)
    )
    config, seconds = changed(more=RECOVERY), 2.2 + 3.2 * count
    return bench_run(faults, config=config, seconds=seconds, estimate=estimate)


@pytest.fixture(scope="module")
def brownout() -> BenchRun:
    return turns_and_brownouts(1, estimate=True)


def test_a_servo_that_started_anew_is_taken_up_where_it_stands(brownout: BenchRun) -> None:
    done = brownout
    assert done.result.reason is StopReason.EMERGENCY, "our own end"
    assert {FaultKind.SERVO_DOWN, FaultKind.RECOVERING, FaultKind.SERVO_RECOVERED} <= done.kinds
    assert (
        done.modes[-4:] == [Mode.ARMED, Mode.START, Mode.WALK, Mode.LIMP]
        or Mode.ARMED in (done.modes[2:])
    )
    down_s, words = done.first(FaultKind.SERVO_DOWN)
    assert "HR (id 4) restarted" in words
    back_s, _ = done.first(FaultKind.SERVO_RECOVERED)
    assert 0 < back_s - down_s < 2.0
    after = [t for t in done.ticks if t.mode in {Mode.START, Mode.WALK} and t.joints.valid[3]]
    lag = np.array([abs(t.joints.angle_rad[3] - t.sent.angle_rad[3]) for t in after])
    assert lag.max() < 0.3, "no turn is unwound: goal and shaft agree before and after"


def test_while_a_servo_is_down_its_angle_is_unknown(brownout: BenchRun) -> None:
    done = brownout
    begin_s, end_s = (done.first(k)[0] for k in (FaultKind.SERVO_DOWN, FaultKind.SERVO_RECOVERED))
    between = [
        t for t in done.ticks if begin_s <= (t.t_ns - done.ticks[0].t_ns) * 1e-9 < end_s - 0.005
    ]
    assert between
    assert all(np.isnan(t.joints.angle_rad[3]) for t in between)


def test_it_ends_when_it_happens_too_often() -> None:
    done = turns_and_brownouts(3)
    assert done.result.reason is StopReason.SERVO_FAULT
    assert "2 recoveries of 2 within 300 s are used up" in done.result.detail
    assert done.result.torque_off


def test_an_overload_is_rebooted_away_and_its_cause_kept() -> None:
    overload = '[[fault]]\nkind = "overload"\nservo = 6\nstart_s = 2.7\nduration_s = 2.1\n'
    config = changed(OVERLOAD_LIMITS, RECOVERY)
    done = bench_run(overload, config=config, seconds=7.7)
    assert done.result.reason is StopReason.EMERGENCY, done.result.detail
    _, words = done.first(FaultKind.SERVO_RECOVERED)
    assert "FR (id 6) shut itself down: overload, holds again at" in words


def test_a_cause_that_is_not_allowed_stops_with_its_name() -> None:
    hot = '[[fault]]\nkind = "overheating"\nservo = 5\nstart_s = 2.7\n'
    done = bench_run(hot, config=changed(more=RECOVERY))
    assert done.result.reason is StopReason.SERVO_FAULT
    assert "overheating" in done.result.detail


def test_the_same_inputs_give_the_same_ticks(brownout: BenchRun) -> None:
    """The recovery is in the inputs: stepping through them again asks for the same and gives the same."""
    from record.log.tick_message import encode_tick
    from robot.control.controller import Controller
    from robot.virtual.open import VirtualSettings, open_in_memory

    done = brownout
    config = changed(more=RECOVERY)
    calibrations = open_in_memory(config, VirtualSettings(armed=False)).calibrations
    controller = Controller(config, calibrations, armed=True)
    state = controller.initial()
    asks: list[int] = []
    for tick in done.ticks:
        state, again = controller.step(state, tick.inputs, tick.t_ns)
        assert encode_tick(again) == encode_tick(tick)
        asks += state.allowed.recover
    assert asks == [3]


@pytest.mark.parametrize("cause", [HardwareError.OVERLOAD, HardwareError.OVERHEATING])
def test_the_driver_keeps_to_the_same_policy(cause: HardwareError) -> None:
    name = str(cause.name).lower()
    settings = changed(more=f'[safety.recovery]\nmost = 1\ncauses = ["{name}"]').recovery
    assert policy_of(settings).causes == cause
    assert policy_of(settings).most == 1
