"""The whole loop on virtual hardware in virtual time: walking, stopping, and every scripted fault."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.dynamixel.registers import HardwareError
from model.errors import RecordError
from model.values.faults import FaultKind, StopReason
from model.values.tick import Intent, Mode, Tick
from robot.config.robot_file import load_robot, parse_robot
from robot.control.controller import Controller
from robot.run.loop import run
from robot.run.rig import Rig
from robot.virtual.open import VirtualSettings, open_in_memory
from tests.pace import usual
from tests.robot.runs import CONFIG, STOP, Kept, Told, drive, modes_of, walk_then_stop, wish

CUT = wish(Intent.CUT, reason=StopReason.EMERGENCY)
ORDINARY = [Mode.ARMED, Mode.START, Mode.WALK, Mode.SLOW, Mode.SETTLE, Mode.HOLD]


def servos(rig: Rig) -> Any:
    """The virtual servo bus behind a rig in memory."""
    return rig.bus._port._bus


def all_torque_off(rig: Rig) -> bool:
    return all(s.table.get("torque_enable") == 0 for s in servos(rig).servos)


def forward(ticks: list[Tick]) -> float:
    walking = [t.inputs.truth for t in ticks if t.mode is Mode.WALK]
    first, last = walking[0], walking[-1]
    assert first is not None
    assert last is not None
    return float(last.position_W[0] - first.position_W[0])


@pytest.mark.parametrize(
    ("gait", "seconds", "frequency_hz", "least"),
    [
        ("tripod", 5.5, 0.27, 0.06),
        pytest.param("metachronal", 7.0, 0.2, 0.02, marks=pytest.mark.soak),
    ],
)
def test_it_walks_forward_and_stands_at_the_end(
    gait: str, seconds: float, frequency_hz: float, least: float
) -> None:
    operator = walk_then_stop(seconds, gait=gait, frequency_hz=frequency_hz)
    result, ticks, rig = drive(operator)
    assert result.reason is StopReason.OPERATOR
    assert modes_of(ticks) == ORDINARY
    assert forward(ticks) > least
    assert result.torque_off
    assert all_torque_off(rig)
    truth = ticks[-1].inputs.truth
    assert truth is not None
    assert truth.contact.all(), "it comes to rest on six feet"
    assert truth.position_W[2] > 0.11, "and has not fallen"
    assert not [t for t in ticks if t.faults]
    assert result.ticks == len(ticks)


@pytest.mark.soak
def test_the_model_predicts_the_walk() -> None:
    _, ticks, _ = drive(walk_then_stop(13.0, frequency_hz=0.1))
    walking = [t for t in ticks if t.mode is Mode.WALK and t.inputs.truth is not None]
    true = np.array([t.inputs.truth.velocity_B[0] for t in walking if t.inputs.truth])
    predicted = np.array([t.contact.traction.velocity_B[0] for t in walking])
    assert np.sqrt(np.mean((predicted - true) ** 2)) < 0.25 * np.sqrt(np.mean(true**2))
    loads = np.array([t.contact.support.load_n for t in walking])
    measured = np.array([t.forces.force_n[:, 2] for t in walking])
    assert np.sqrt(np.nanmean((loads - measured) ** 2)) < 1.0, "newtons"


@pytest.mark.soak
def test_steering_left_turns_left() -> None:
    with usual():  # three feet that are set down at once turn it a little
        _, straight, _ = drive(walk_then_stop(20.0))
        _, left, _ = drive(walk_then_stop(20.0, steer=1.0))

    def yaw(ticks: list[Tick]) -> float:
        truth = ticks[-1].inputs.truth
        assert truth is not None
        _, _, z, w = truth.quaternion_xyzw
        return float(2 * np.arctan2(z, w))

    assert abs(yaw(straight)) < 0.02
    assert yaw(left) > 0.03


@pytest.mark.soak
def test_changing_the_gait_goes_through_a_stop_without_a_jump() -> None:
    def tell(t: float, _tick: Tick | None) -> Any:
        if t > 17:
            return STOP
        return wish(Intent.WALK, "tripod" if t < 7 else "metachronal")

    _, ticks, _ = drive(Told(tell))
    order = modes_of(ticks)
    assert order[:6] == [Mode.ARMED, Mode.START, Mode.WALK, Mode.SLOW, Mode.START, Mode.WALK]
    sent = np.array([t.sent.angle_rad for t in ticks if t.sent.torque])
    assert np.abs(np.diff(sent, axis=0)).max() < 0.01 * CONFIG.limits.max_speed_rad_s


def test_stand_walk_stand() -> None:
    def tell(t: float, _tick: Tick | None) -> Any:
        if t > 5:
            return STOP
        return wish(Intent.WALK if 1 < t < 3 else Intent.STAND)

    result, ticks, _ = drive(Told(tell))
    assert modes_of(ticks) == [
        Mode.ARMED, Mode.SETTLE, Mode.HOLD, Mode.START, Mode.WALK, Mode.SLOW, Mode.SETTLE, Mode.HOLD,
    ]  # fmt: skip
    assert result.reason is StopReason.OPERATOR


def test_readonly_never_switches_torque_on() -> None:
    sent: list[bytes] = []

    def listen(rig: Rig, _tick: Tick) -> None:
        rig.bus._port.tap = lambda d, data, _t: sent.append(data) if d == "tx" else None

    operator = Told(lambda t, _: STOP if t > 1 else wish(Intent.WALK))
    result, ticks, rig = drive(operator, armed=False, disturb=listen)
    assert modes_of(ticks) == [Mode.IDLE]
    assert all(t.joints.valid.all() for t in ticks)
    assert all_torque_off(rig)
    assert {frame[7] for frame in sent} <= {0x02, 0x82}, "reads only"
    assert result.torque_off


def test_emergency_cuts_torque_at_once() -> None:
    result, ticks, rig = drive(Told(lambda t, _: CUT if t > 2.0 else wish(Intent.WALK)))
    assert ticks[-1].mode is Mode.LIMP
    assert modes_of(ticks)[-2] is Mode.WALK, "no detour"
    assert not ticks[-1].sent.torque
    assert result.reason is StopReason.EMERGENCY
    assert all_torque_off(rig)


def test_the_same_seed_gives_the_same_ticks() -> None:
    from record.log.tick_message import encode_tick

    def cut_after(seconds: float) -> Told:
        return Told(lambda t, _: CUT if t > seconds else wish(Intent.WALK))

    runs = [drive(cut_after(1.8), seed=5, estimate=True)[1] for _ in range(2)]
    assert runs[0][-2].mode is Mode.WALK
    assert [encode_tick(t) for t in runs[0]] == [encode_tick(t) for t in runs[1]]
    *other, _ = drive(cut_after(0.5), seed=6, estimate=True)[1]
    assert [encode_tick(t) for t in other] != [encode_tick(t) for t in runs[0][: len(other)]]


# Scripted faults, each with the reaction expected.


def at(second: float, action: Callable[[Rig], None]) -> Callable[[Rig, Tick], None]:
    done: list[bool] = []

    def disturb(rig: Rig, tick: Tick) -> None:
        if not done and tick.t_ns > 1.2e9 + second * 1e9:
            done.append(True)
            action(rig)

    return disturb


def walking_on() -> Told:
    return Told(lambda t, _: STOP if t > 20 else wish(Intent.WALK))


@pytest.mark.parametrize(
    ("action", "reason", "kind", "source"),
    [
        (lambda rig: servos(rig).silence(3), StopReason.SERVO_LOST, FaultKind.SERVO_SILENT, "FL"),
        (
            lambda rig: (
                servos(rig)
                .servos[4]
                .table.set("hardware_error_status", int(HardwareError.OVERLOAD))
            ),
            StopReason.SERVO_FAULT,
            FaultKind.SERVO_ALERT,
            "MR",
        ),
        (
            lambda rig: servos(rig)._world.plant.temperature_c.__setitem__(1, 76.0),
            StopReason.SERVO_FAULT,
            FaultKind.SERVO_HOT,
            "ML",
        ),
    ],
    ids=["silent servo", "overload", "hot servo"],
)
def test_a_servo_fault_halts_the_robot_where_it_stands(
    action: Callable[[Rig], None], reason: StopReason, kind: FaultKind, source: str
) -> None:
    result, ticks, _ = drive(walking_on(), disturb=at(2.7, action))
    assert result.reason is reason
    assert any(f.kind is kind and f.source == source for f in ticks[-1].faults)
    assert modes_of(ticks)[-3:] == [Mode.WALK, Mode.SLOW, Mode.HOLD]
    assert result.torque_off is (reason is not StopReason.SERVO_LOST), "honest about the silent one"


def test_one_lost_reading_is_a_fault_and_no_stop() -> None:
    def blink(rig: Rig, tick: Tick) -> None:
        servos(rig).silence(2, on=tick.index % 30 == 0)

    result, ticks, _ = drive(walk_then_stop(2.0), disturb=blink, estimate=True)
    assert result.reason is StopReason.OPERATOR
    silent = [t for t in ticks if not t.joints.valid[1]]
    assert len(silent) > 5
    for tick in silent:
        assert np.isnan(tick.joints.angle_rad[1]), "absence is NaN, never 0"
        assert not tick.contact.support.converged, "and no prediction is made up from it"


def test_a_force_unit_that_falls_silent_brings_the_robot_to_rest() -> None:
    def mute(rig: Rig) -> None:
        stream: Any = rig._forces
        stream._datagrams._unit.transmit = False

    result, ticks, _ = drive(walking_on(), disturb=at(2.2, mute))
    assert result.reason is StopReason.FORCE_LOST
    assert modes_of(ticks)[-3:] == [Mode.SLOW, Mode.SETTLE, Mode.HOLD]


def test_a_pulled_cable_cuts() -> None:
    def pull(rig: Rig) -> None:
        from model.errors import ConnectionLost

        def gone(*_: object) -> int:
            raise ConnectionLost("memory is gone: was the cable pulled?", port="memory")

        rig.bus._port.writePort = gone

    result, ticks, _ = drive(walking_on(), disturb=at(2.2, pull))
    assert result.reason is StopReason.LINK_LOST
    assert ticks[-1].mode is Mode.LIMP
    assert result.torque_off is False, "nobody can confirm it"
    assert "cable" in result.detail


def test_a_servo_that_does_not_take_torque_ends_the_run() -> None:
    def refuse(rig: Rig, tick: Tick) -> None:
        if tick.index == 0:  # between connecting and switching on
            servos(rig).silence(6)

    rig_seen: list[Rig] = []

    def watch(rig: Rig, tick: Tick) -> None:
        rig_seen.append(rig)
        refuse(rig, tick)

    listen_then_walk = Told(lambda t, _: wish(Intent.LISTEN if t < 0.02 else Intent.WALK))
    result, ticks, rig = drive(listen_then_walk, disturb=watch)
    assert result.reason in {StopReason.SERVO_FAULT, StopReason.SERVO_LOST}
    assert ticks[-1].mode is not Mode.WALK
    assert rig_seen[0] is rig


def test_a_log_that_fails_brings_the_robot_to_rest() -> None:
    kept = Kept()

    def fail(_rig: Rig) -> None:
        kept.error = RecordError("the log x can no longer be written: No space left on device")

    result, ticks, _ = drive(walking_on(), disturb=at(2.2, fail), kept=kept)
    assert result.reason is StopReason.LOG_FAILED
    assert ticks[-1].mode is Mode.HOLD
    assert result.torque_off


def test_a_loop_that_stands_still_stops_and_the_watchdog_has_stopped_the_servos() -> None:
    def stall(rig: Rig) -> None:
        rig.clock.advance(600_000_000)  # type: ignore[attr-defined]

    result, ticks, _ = drive(walking_on(), disturb=at(2.7, stall))
    assert result.reason is StopReason.TIMING
    assert any(f.kind is FaultKind.LATE for t in ticks for f in t.faults)
    assert max(t.inputs.timing.missed for t in ticks) >= 59
    assert result.missed == sum(t.inputs.timing.missed for t in ticks)


def test_a_gait_too_fast_is_refused_and_the_robot_stands() -> None:
    def tell(t: float, _tick: Tick | None) -> Any:
        return wish(Intent.WALK, frequency_hz=0.2 if t < 3 else 3.0)

    result, ticks, _ = drive(Told(tell))
    assert result.reason is StopReason.GAIT_REFUSED
    assert modes_of(ticks)[-3:] == [Mode.SLOW, Mode.SETTLE, Mode.HOLD]


def test_a_plan_gone_wrong_never_reaches_the_servos(monkeypatch: pytest.MonkeyPatch) -> None:
    from gaits.plan import Walking

    whole = Walking.at

    def wrong(self: Walking, t_ns: int) -> Any:
        angle, rate = whole(self, t_ns)
        return angle + (1.0 if t_ns > 4e9 else 0.0), rate

    monkeypatch.setattr(Walking, "at", wrong)
    result, ticks, _ = drive(walking_on())
    assert result.reason is StopReason.COMMAND_REFUSED
    refused = [t for t in ticks if any(f.kind is FaultKind.REFUSED for f in t.faults)]
    assert refused
    sent = np.array([t.sent.angle_rad for t in ticks if t.sent.torque])
    assert np.abs(np.diff(sent, axis=0)).max() < 0.05


def test_the_loop_keeps_its_grid() -> None:
    _, ticks, _ = drive(walk_then_stop(1.2))
    starts = np.array([t.t_ns for t in ticks[5:]])
    assert set(np.diff(starts).tolist()) == {10_000_000}
    assert {t.inputs.timing.missed for t in ticks[5:]} == {0}


@pytest.mark.soak
def test_the_loop_runs_at_200_hz() -> None:
    rig = open_in_memory(CONFIG)
    kept = Kept()
    controller = Controller(CONFIG, rig.calibrations, armed=True, rate_hz=200)
    result = run(rig, controller, walk_then_stop(4.0), kept, None)
    starts = np.array([t.t_ns for t in kept.ticks[5:]])
    assert set(np.diff(starts).tolist()) == {5_000_000}
    assert result.reason is StopReason.OPERATOR
    assert not [t for t in kept.ticks if t.faults]


@pytest.mark.soak
def test_a_robot_with_eight_legs_walks() -> None:
    """The example file, whose fourth pair of legs carries no force sensor."""
    config = load_robot(Path(__file__).resolve().parents[3] / "examples" / "octopod.toml")
    result, ticks, _ = drive(walk_then_stop(9.0), config=config, estimate=True)
    assert result.reason is StopReason.OPERATOR
    assert forward(ticks) > 0.05
    valid = ticks[-1].forces.valid
    assert valid.tolist() == [True, True, True, False] * 2
    assert np.isnan(ticks[-1].forces.force_n[~valid]).all(), "absent is never zero"


def test_another_robot_walks_too() -> None:
    """Half the mass, other ids, other mounting: all of it comes from the file."""
    text = CONFIG.text.replace("mass = 6.5 ", "mass = 4.0 ")
    text = text.replace("[1, 2, 3, 4, 5, 6]              # assumed\n", "[11, 12, 13, 4, 5, 6]\n", 1)
    text = text.replace("servo_zero = [2048, 2048,", "servo_zero = [100, 3000,")
    text = text.replace("[0.10, 0.14, 0.22]", "[0.06, 0.09, 0.14]")
    config = parse_robot(text)
    assert config.servo_bus.ids.tolist() == [11, 12, 13, 4, 5, 6]
    result, ticks, _ = drive(walk_then_stop(4.5, frequency_hz=0.3), config=config)
    assert result.reason is StopReason.OPERATOR
    assert forward(ticks) > 0.04


def test_a_robot_with_slow_servos_stands_up_and_down_within_their_speed() -> None:
    """It used to be refused in its first move: legs moved at 2 rad/s whatever the robot file allows."""
    config = parse_robot(CONFIG.text.replace("max_speed = 4.0 ", "max_speed = 1.8 "))
    result, ticks, _ = drive(walk_then_stop(3.0, frequency_hz=0.12), config=config)
    assert result.reason is StopReason.OPERATOR
    assert ticks[-1].mode is Mode.HOLD
    assert not any(fault.kind is FaultKind.REFUSED for tick in ticks for fault in tick.faults)
    sent = np.array([tick.sent.rate_rad_s for tick in ticks])
    moving = np.array([tick.mode in {Mode.START, Mode.SETTLE} for tick in ticks])
    assert 0.5 < np.nanmax(np.abs(sent[moving])) <= 1.8


def test_without_forces_it_walks_and_says_nothing_of_forces() -> None:
    rig = open_in_memory(CONFIG, VirtualSettings(with_forces=False))
    kept = Kept()
    run(rig, Controller(CONFIG, rig.calibrations, armed=True), walk_then_stop(2.2), kept, None)
    assert Mode.WALK in modes_of(kept.ticks)
    assert all(not t.forces.valid.any() for t in kept.ticks)
    assert all(np.isnan(t.forces.force_n).all() for t in kept.ticks)
    assert replace(kept.ticks[-1]).stop_reason is StopReason.OPERATOR
