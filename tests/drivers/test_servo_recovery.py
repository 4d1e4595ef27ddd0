"""A servo that shuts down or starts anew: found out, explained, brought back as often as allowed."""

import numpy as np
import pytest

from drivers.dynamixel.frames import Instruction
from drivers.dynamixel.recovery import Incident, IncidentKind, RecoveryPolicy, ServoRecovery
from drivers.dynamixel.registers import HardwareError
from tests.drivers.test_servo_bus import SETTINGS, Bench, armed

TURN = 4096
OVERLOAD = RecoveryPolicy(most=2, window_s=300.0)
SERVO = 2  # FL, id 3
AT_ONCE = "[servo]\nrestart_s = 0.0\n"


def tick(bench: Bench, recovery: ServoRecovery, count: int = 1) -> list[Incident]:
    """Let the loop run: one read and one look every 10 ms."""
    found: list[Incident] = []
    for _ in range(count):
        bench.wait(0.01)
        found += recovery.look(bench.bus.read())
    return found


def overload(bench: Bench, recovery: ServoRecovery) -> Incident:
    """Load one servo beyond its strength until it gives up."""
    bench.motors.currents[SERVO] = 5.0
    (incident,) = tick(bench, recovery, 230)
    bench.motors.currents[SERVO] = 0.0
    return incident


def register(bench: Bench, name: str, index: int = SERVO) -> int:
    return bench.servos.servos[index].table.get(name)


def test_a_healthy_bus_has_no_incidents() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    assert tick(bench, recovery, 300) == []
    assert all(register(bench, "torque_enable", i) for i in range(6))


def test_an_overload_is_found_with_its_cause() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    incident = overload(bench, recovery)
    assert (incident.leg, incident.servo_id) == ("FL", 3)
    assert incident.kind is IncidentKind.SHUT_DOWN
    assert incident.cause == HardwareError.OVERLOAD
    assert incident.words == "FL (id 3) shut itself down: overload"
    assert tick(bench, recovery, 50) == [], "reported once"


def test_nothing_is_recovered_by_default() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, RecoveryPolicy())
    result = recovery.recover(overload(bench, recovery))
    assert not result.recovered
    assert result.reason == "recovery is not allowed"
    assert result.torque_off
    assert register(bench, "hardware_error_status") == HardwareError.OVERLOAD, "no reboot either"
    assert register(bench, "torque_enable") == 0


def test_an_allowed_recovery_holds_at_the_measured_position() -> None:
    bench = armed()
    bench.motors.ticks[SERVO] += 3 * TURN
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    bench.bus.torque_off()
    bench.bus.torque_on()
    incident = overload(bench, recovery)
    bench.motors.ticks[SERVO] += 300  # it sagged while nobody held it
    before = [bench.motors.ticks[i] for i in range(6)]
    result = recovery.recover(incident)
    assert result.recovered
    assert result.incident.cause == HardwareError.OVERLOAD, "the servo has forgotten it"
    here = round(before[SERVO]) - 3 * TURN
    assert result.goal_ticks == pytest.approx(here, abs=1)
    assert result.zero_shift_ticks == -3 * TURN, "turns lost"
    assert register(bench, "goal_position") == result.goal_ticks
    assert register(bench, "torque_enable") == 1
    assert register(bench, "bus_watchdog") == bench.bus.watchdog_units
    assert register(bench, "hardware_error_status") == 0
    others = [i for i in range(6) if i != SERVO]
    assert all(register(bench, "torque_enable", i) == 1 for i in others)
    assert all(register(bench, "bus_watchdog", i) > 0 for i in others), "none tripped meanwhile"
    assert tick(bench, recovery, 100) == []
    assert np.abs(bench.motors.ticks - before).max() < 20, "nobody moved"


def test_recoveries_are_counted_and_end() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    results = [recovery.recover(overload(bench, recovery)) for _ in range(3)]
    assert [r.recovered for r in results] == [True, True, False]
    assert results[2].reason == "2 recoveries within 300 s, and that is the limit"
    assert register(bench, "torque_enable") == 0
    bench.clock.advance(300 * 10**9)
    assert recovery.refusal(results[2].incident) == "", "the window has passed"


def test_a_cause_that_is_not_allowed_stays() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    bench.motors.temperature_c[SERVO] = 85
    (incident,) = tick(bench, recovery, 10)
    assert incident.cause == HardwareError.OVERHEATING
    assert recovery.recover(incident).reason == "recovery from overheating is not allowed"


def test_a_cause_that_persists_leaves_torque_off() -> None:
    bench = armed()
    policy = RecoveryPolicy(most=5, causes=HardwareError.OVERHEATING)
    recovery = ServoRecovery(bench.bus, policy)
    bench.motors.temperature_c[SERVO] = 85
    (incident,) = tick(bench, recovery, 10)
    result = recovery.recover(incident)
    assert not result.recovered
    assert "still reports overheating after its reboot" in result.reason
    assert result.torque_off
    assert register(bench, "torque_enable") == 0


def power_cut(bench: Bench) -> None:
    bench.servos.servos[SERVO].obey(Instruction.REBOOT, b"", bench.clock.now_ns(), broadcast=False)


@pytest.mark.parametrize("allowed", [False, True])
def test_a_servo_that_started_anew_is_found_by_its_turns(allowed: bool) -> None:
    bench = armed(AT_ONCE)
    bench.motors.ticks[SERVO] += 2 * TURN
    recovery = ServoRecovery(bench.bus, RecoveryPolicy(most=1, after_restart=allowed))
    bench.bus.torque_off()
    bench.bus.torque_on()
    tick(bench, recovery, 5)
    power_cut(bench)
    (incident,) = tick(bench, recovery)
    assert incident.kind is IncidentKind.RESTARTED
    assert incident.ticks_before - incident.ticks_after == 2 * TURN
    result = recovery.recover(incident)
    assert result.recovered is allowed
    if allowed:
        assert result.zero_shift_ticks == -2 * TURN
        assert register(bench, "torque_enable") == 1
    else:
        assert result.reason == "recovery of a servo that restarted is not allowed"
        assert register(bench, "torque_enable") == 0


def test_torque_that_vanished_without_a_trace_is_found_in_turn() -> None:
    bench = armed(AT_ONCE)
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    tick(bench, recovery, 5)
    power_cut(bench)  # within its first turn: the position does not change
    (incident,) = tick(bench, recovery, 60)
    assert (incident.leg, incident.kind) == ("FL", IncidentKind.TORQUE_LOST)


def test_a_servo_back_from_silence_is_looked_at() -> None:
    bench = armed(AT_ONCE)
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    tick(bench, recovery, 5)
    bench.servos.silence(3)
    power_cut(bench)
    assert tick(bench, recovery, 3) == []
    bench.servos.silence(3, on=False)
    (incident,) = tick(bench, recovery)
    assert incident.kind is IncidentKind.RESTARTED


def test_torque_switched_off_on_purpose_is_no_incident() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    tick(bench, recovery, 5)
    assert bench.bus.torque_off()
    assert tick(bench, recovery, 100) == []


def test_a_failed_attempt_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, RecoveryPolicy(most=1))
    incident = overload(bench, recovery)
    bench.servos.silence(3)
    result = recovery.recover(incident)
    assert not result.recovered
    assert not result.torque_off, "nobody confirmed it"
    bench.servos.silence(3, on=False)
    assert "that is the limit" in recovery.refusal(incident)
    assert SETTINGS.names[incident.index] == "FL"


def test_a_tripped_watchdog_is_found_although_torque_is_on() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    tick(bench, recovery, 3)
    bench.servos.silence(3)
    assert tick(bench, recovery, 100) == []
    assert register(bench, "bus_watchdog") == -1
    bench.servos.silence(3, on=False)
    bench.wait(0.6)  # answers still under way are no answers to what is asked now
    (incident,) = tick(bench, recovery, 3)
    assert register(bench, "torque_enable") == 1, "nothing else shows it"
    assert incident.kind is IncidentKind.TRIPPED
    assert "watchdog" in incident.words


def test_a_tripped_servo_takes_goals_again_after_its_recovery() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    tick(bench, recovery, 3)
    bench.servos.servos[SERVO].table.set("bus_watchdog", -1)
    (incident,) = tick(bench, recovery, 70)
    result = recovery.recover(incident)
    assert result.recovered
    assert register(bench, "bus_watchdog") == bench.bus.watchdog_units
    for _ in range(60):
        bench.wait(0.01)
        bench.bus.write_goals(bench.command(0.2))
        assert recovery.look(bench.bus.read()) == ()
    assert abs(bench.motors.ticks[SERVO] - (2048 + 0.2 * TURN / 2 / np.pi)) < 5


def test_a_tripped_servo_without_permission_stays_an_incident() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, RecoveryPolicy())
    bench.servos.servos[SERVO].table.set("bus_watchdog", -1)
    (incident,) = tick(bench, recovery, 70)
    assert recovery.refusal(incident) == "recovery is not allowed"


@pytest.mark.parametrize(
    ("restart_s", "hears"),
    [
        (0.1, "own"),
        (0.8, "all"),
        *(
            pytest.param(*one, marks=pytest.mark.soak)
            for one in ((0.1, "all"), (0.5, "all"), (0.5, "own"), (0.8, "own"))
        ),
    ],
)
def test_the_others_hear_enough_while_one_starts(restart_s: float, hears: str) -> None:
    scenario = f'[servo]\nrestart_s = {restart_s}\nwatchdog_hears = "{hears}"\n'
    bench = armed(scenario)
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    result = recovery.recover(overload(bench, recovery))
    assert result.recovered
    watchdogs = [register(bench, "bus_watchdog", i) for i in range(6)]
    assert watchdogs == [bench.bus.watchdog_units] * 6


def test_after_a_recovery_every_servo_is_asked() -> None:
    bench = armed()
    recovery = ServoRecovery(bench.bus, OVERLOAD)
    incident = overload(bench, recovery)
    bench.servos.servos[5].table.set("bus_watchdog", -1)
    assert recovery.recover(incident).recovered
    (other,) = recovery.look(bench.bus.read())
    assert (other.index, other.kind) == (5, IncidentKind.TRIPPED)
