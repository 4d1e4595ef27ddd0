"""The servo bus over the virtual servos in memory: the ordinary path, and every trap of the SDK."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.registers import HardwareError
from model.errors import BusError
from model.values.legs import JointCommand
from robot.config.robot_file import load_robot
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from tests.sim_hw.faulty import scenario_on
from tests.sim_hw.motors import SimpleMotors

SETTINGS = load_robot().servo_bus
PERIOD_NS = 10_000_000


@dataclass
class Bench:
    clock: VirtualClock
    motors: SimpleMotors
    servos: VirtualServoBus
    bus: ServoBus
    sent: list[bytes]

    def wait(self, seconds: float) -> None:
        self.clock.advance(round(seconds * 1e9))
        self.servos.poll(self.clock.now_ns())

    def command(self, angle: float) -> JointCommand:
        return JointCommand(self.clock.now_ns(), np.full(6, angle), np.zeros(6), torque=True)


@pytest.fixture
def bench() -> Bench:
    return make_bench()


def make_bench(
    prepare: Callable[[VirtualServoBus], None] | None = None, scenario: str = ""
) -> Bench:
    clock = VirtualClock(1_000_000_000)
    firmware = FirmwareBank(6)
    motors = SimpleMotors(firmware, 6)
    ids = (1, 2, 3, 4, 5, 6)
    servos, wire = scenario_on(scenario, motors, firmware, ids, SETTINGS.baud_rate)
    if prepare is not None:
        prepare(servos)
    port = MemoryPort(wire, clock, SETTINGS.baud_rate)
    sent: list[bytes] = []
    port.tap = lambda direction, data, _t: sent.append(data) if direction == "tx" else None
    return Bench(clock, motors, servos, ServoBus(port, SETTINGS), sent)


def armed(scenario: str = "") -> Bench:
    bench = make_bench(scenario=scenario)
    bench.bus.connect()
    bench.bus.configure()
    bench.bus.torque_on()
    return bench


def test_connecting_writes_nothing(bench: Bench) -> None:
    report = bench.bus.connect()
    bench.bus.read()
    assert [s.leg for s in report.servos] == list(SETTINGS.names)
    assert {frame[7] for frame in bench.sent} <= {0x01, 0x02, 0x82}, "ping, read and sync read only"


def test_one_read_is_one_sync_read(bench: Bench) -> None:
    bench.bus.connect()
    bench.sent.clear()
    readings = bench.bus.read()
    assert bench.sent == [
        bytes.fromhex("FF FF FD 00 FE 0D 00 82 7C 00 17 00 01 02 03 04 05 06 78 A7")
    ]
    assert readings.valid.all()
    assert readings.position_ticks.tolist() == [2048] * 6
    assert readings.voltage_counts.tolist() == [120] * 6


def test_goals_go_out_in_one_sync_write() -> None:
    bench = armed()
    bench.sent.clear()
    bench.bus.write_goals(bench.command(np.pi / 2))
    ticks = b"".join(
        bytes([i]) + (3072 if i <= 3 else 1024).to_bytes(4, "little") for i in range(1, 7)
    )
    assert len(bench.sent) == 1
    assert bench.sent[0][:12] == bytes.fromhex("FF FF FD 00 FE 25 00 83 74 00 04 00")
    assert bench.sent[0][12:-2] == ticks


def test_the_shafts_follow() -> None:
    bench = armed()
    for step in range(100):
        bench.wait(0.01)
        bench.bus.read()
        bench.bus.write_goals(bench.command(0.005 * step))
    bench.wait(0.2)
    assert bench.bus.read().position_ticks[0] == pytest.approx(2048 + 0.495 * 651.9, abs=3)


def test_goals_without_torque_are_an_error(bench: Bench) -> None:
    bench.bus.connect()
    with pytest.raises(BusError, match="torque is off"):
        bench.bus.write_goals(bench.command(0.0))
    with pytest.raises(BusError, match="--armed"):
        bench.bus.torque_on()


def test_torque_goes_on_where_the_shaft_stands() -> None:
    bench = make_bench()
    bench.motors.ticks[:] = [100.0, 2048, 3000, 5000, -700, 2048]
    bench.bus.connect()
    bench.bus.configure()
    before = bench.motors.ticks.copy()
    bench.bus.torque_on()
    bench.wait(0.2)
    assert np.abs(bench.motors.ticks - before).max() < 1.0


def test_not_a_number_never_reaches_the_wire() -> None:
    bench = armed()
    bench.sent.clear()
    with pytest.raises(BusError, match="not a number"):
        bench.bus.write_goals(bench.command(np.nan))
    assert bench.sent == []


# Traps 3 and 8: one silent servo.


@pytest.mark.parametrize(("chain_breaks", "silent"), [(False, [3]), (True, [3, 4, 5, 6])])
def test_a_silent_servo_hides_no_other(bench: Bench, chain_breaks: bool, silent: list[int]) -> None:
    bench.bus.connect()
    bench.bus.read()
    bench.servos.silence(3, chain_breaks=chain_breaks)
    began = bench.clock.now_ns()
    readings = bench.bus.read()
    assert np.flatnonzero(~readings.valid).tolist() == [i - 1 for i in silent]
    assert readings.position_ticks[0] == 2048
    assert readings.age_ns[2] > 0, "the age says how old the last sound answer is"
    assert bench.clock.now_ns() - began < PERIOD_NS, "it costs one bounded timeout"


def test_a_servo_never_heard_has_no_age() -> None:
    bench = make_bench()
    bench.bus.connect()
    bench.servos.silence(6)
    readings = bench.bus.read()
    assert readings.age_ns[5] == -1
    assert not readings.valid[5]


# Traps 4 and 18: the alert bit.


def test_an_alert_is_seen_at_once_and_its_cause_read() -> None:
    bench = armed()
    bench.motors.temperature_c[1] = 95.0
    bench.wait(0.01)
    readings = bench.bus.read()
    assert readings.error_byte[1] & 0x80
    assert readings.hardware_error[1] == HardwareError.OVERHEATING
    assert readings.valid[1], "an alert is no reason to throw the measurement away"


# Traps 1 and 2: stuffing in both directions.


def test_a_frame_that_needs_stuffing_comes_through_both_ways() -> None:
    bench = armed()
    bench.motors.ticks[0] = 0x00FDFFFF  # position bytes FF FF FD 00
    bench.motors.hold = True
    assert bench.bus.read().position_ticks[0] == 0x00FDFFFF
    bench.sent.clear()
    goal = (-(257) - 2048) * 2 * np.pi / 4096  # 0xFFFFFEFF; its neighbours make headers
    bench.bus.write_goals(bench.command(goal))
    for frame in bench.sent:
        assert frame.find(b"\xff\xff\xfd", 4) in {-1, frame.find(b"\xff\xff\xfd\xfd", 4)}


# Trap 12: a late answer is not taken for the next one.


def test_a_late_answer_is_not_taken_for_the_next() -> None:
    # behind the timeout, within one latency period
    bench = make_bench(scenario=_once("late_reply", "delay_s = 0.007"))
    bench.bus.connect()
    bench.motors.hold = True
    bench.wait(1.0)
    first = bench.bus.read()
    assert not first.valid.all()
    bench.motors.ticks[:] = 1000.0
    second = bench.bus.read()
    assert second.position_ticks[second.valid].tolist() == [1000] * int(second.valid.sum())
    assert bench.bus.read().position_ticks.tolist() == [1000] * 6


def _once(kind: str, more: str = "") -> str:
    return f'[[fault]]\nkind = "{kind}"\nstart_s = 1.0\ncount = 1\n{more}'


def test_a_damaged_answer_is_said_of_that_servo_only() -> None:
    bench = make_bench(scenario=_once("bit_flip"))
    bench.bus.connect()
    bench.wait(1.0)
    readings = bench.bus.read()
    assert np.flatnonzero(~readings.valid).tolist() == [0]
    assert bench.bus.stats.crc_errors == 1
    assert bench.bus.read().valid.all()


# The watchdog, and every way out.


def test_the_servos_stop_by_themselves_when_the_host_dies() -> None:
    bench = armed()
    for servo in bench.servos.servos:
        assert servo.table.get("bus_watchdog") == round(SETTINGS.watchdog_s / 0.02)
    bench.bus.write_goals(bench.command(3.0))
    bench.wait(SETTINGS.watchdog_s + 0.02)
    where = bench.motors.ticks.copy()
    assert bench.servos.servos[0].table.get("bus_watchdog") == -1
    bench.wait(0.5)
    assert np.abs(bench.motors.ticks - where).max() < 60, "it brakes where it is"
    assert abs(bench.motors.ticks[0] - (2048 + 3.0 * 651.9)) > 100, "and does not go on"


def test_torque_off_is_confirmed_also_after_the_watchdog_tripped() -> None:
    bench = armed()
    bench.wait(1.0)
    assert bench.bus.torque_off() is True
    assert all(s.table.get("torque_enable") == 0 for s in bench.servos.servos)


def test_torque_off_is_honest_about_a_servo_that_does_not_answer() -> None:
    bench = armed()
    bench.servos.silence(4)
    assert bench.bus.torque_off() is False


# What connecting refuses.


@pytest.mark.parametrize(
    ("prepare", "words"),
    [
        (lambda servos: servos.silence(3), r"FL \(id 3\) does not answer .* 5 others do"),
        (lambda servos: [servos.silence(i) for i in range(1, 7)], "no servo answers on memory"),
        (lambda servos: servos.servos[2].table.set("model_number", 320), "protocol 1.0 firmware"),
        (lambda servos: servos.servos[2].table.set("model_number", 35), "is model 35"),
        (lambda servos: servos.servos[4].table.set("homing_offset", 9), "homing offset of 9"),
        (
            lambda servos: servos.servos[4].table.set("hardware_error_status", 0x20),
            r"MR \(id 5\) has shut down \(overload\)",
        ),
    ],
)
def test_what_connecting_refuses(prepare: Callable[[VirtualServoBus], None], words: str) -> None:
    with pytest.raises(BusError, match=words):
        make_bench(prepare).bus.connect()


def test_the_wrong_baud_rate_is_said() -> None:
    def slow_down(servos: VirtualServoBus) -> None:
        for servo in servos.servos:
            servo.table.set("baud_rate", 1)

    bench = make_bench(slow_down)
    with pytest.raises(BusError, match=r"at 1000000 baud: .* bigant devices --port memory"):
        bench.bus.connect()


def test_a_long_return_delay_is_a_warning() -> None:
    bench = make_bench(lambda servos: servos.servos[0].table.set("return_delay_time", 250))
    report = bench.bus.connect()
    assert any("HL wait 500 us" in warning for warning in report.warnings)
    assert bench.bus.read().valid.all(), "and the deadline allows for it"


def test_a_used_up_turn_counter_is_set_back() -> None:
    bench = make_bench()
    bench.motors.ticks[0] = 200 * 4096.0 + 7
    bench.motors.hold = True
    bench.bus.connect()
    bench.bus.configure()
    assert bench.bus.read().position_ticks[0] == 7


def test_a_torque_left_on_is_switched_off_before_setting_up() -> None:
    bench = make_bench()
    bench.bus.connect()
    for servo in bench.servos.servos:
        servo.write(MX_106.table["torque_enable"].address, b"\x01", bench.clock.now_ns())
    bench.bus.configure()
    assert all(s.table.get("torque_enable") == 0 for s in bench.servos.servos)
    assert all(s.table.get("operating_mode") == 4 for s in bench.servos.servos)


def test_settings_that_are_right_are_not_written_again() -> None:
    bench = make_bench()
    bench.bus.connect()
    bench.bus.configure()
    bench.sent.clear()
    bench.bus.configure()
    eeprom = [f for f in bench.sent if f[7] == 0x03 and int.from_bytes(f[8:10], "little") < 64]
    assert eeprom == []


@pytest.mark.parametrize("angle", [1e17, -1e17, 2000.0])
def test_goals_beyond_all_turns_are_refused_as_such(angle: float) -> None:
    bench = armed()
    with pytest.raises(BusError, match="beyond 256 turns"):
        bench.bus.write_goals(bench.command(angle))


def test_goals_that_cannot_be_sent_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = armed()
    monkeypatch.setattr(bench.bus._port, "writePort", lambda packet: len(packet) - 1)
    with pytest.raises(BusError, match="could not be sent whole"):
        bench.bus.write_goals(bench.command(0.0))
