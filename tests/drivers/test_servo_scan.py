"""Scanning: who answers a broadcast ping, at which baud rate, in bounded time."""

from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from serial.tools import list_ports

from drivers.clock import MonotonicClock
from drivers.dynamixel import scan as servo_scan
from drivers.dynamixel.frames import Frame
from drivers.dynamixel.port import BusPort
from drivers.dynamixel.scan import ScannedServo, SerialPort, broadcast_ping, scan, serial_ports
from model.errors import BusError
from sim_hw.clock import VirtualClock
from tests.drivers.scripted_servos import (
    PtyServos,
    Replies,
    ScriptedPort,
    ScriptedServos,
    Servo,
)

PING_ALL = bytes.fromhex("FF FF FD 00 FE 03 00 01 31 42")


def test_everybody_is_found_by_one_broadcast() -> None:
    servos = ScriptedServos(Servo(6), Servo(1, {"firmware_version": 42}), Servo(200))
    port = ScriptedPort(servos.respond)
    assert broadcast_ping(port) == [
        ScannedServo(1_000_000, 1, 321, 42),
        ScannedServo(1_000_000, 6, 321, 44),
        ScannedServo(1_000_000, 200, 321, 44),
    ]
    assert port.sent == [PING_ALL]


def test_each_servo_has_the_time_slot_of_its_id() -> None:
    servos = ScriptedServos(Servo(0), Servo(252))

    def in_slot(servo_id: int, _frame: Frame, _at_ns: int, data: bytes) -> Replies:
        return [(servo_id * 3_000_000 + 1_000_000, data)]

    servos.edit = in_slot
    assert [s.servo_id for s in broadcast_ping(ScriptedPort(servos.respond))] == [0, 252]


def test_a_full_bus_is_heard_to_the_end_at_a_low_baud_rate() -> None:
    servos = ScriptedServos(*(Servo(i) for i in range(253)))
    wire_ns = 14 * 10_000_000_000 // 57_600

    def in_slot(servo_id: int, _frame: Frame, _at_ns: int, data: bytes) -> Replies:
        return [(servo_id * 3_000_000 + (servo_id + 1) * wire_ns, data)]

    servos.edit = in_slot
    assert len(broadcast_ping(ScriptedPort(servos.respond, 57_600))) == 253


@pytest.mark.parametrize("baud_rate", [9_600, 57_600, 1_000_000, 4_500_000])
def test_nobody_there_costs_less_than_a_second(baud_rate: int) -> None:
    port = ScriptedPort(lambda _: [], baud_rate)
    port.latency_ms = 16.0
    began_ns = port.clock.now_ns()
    assert broadcast_ping(port) == []
    assert port.clock.now_ns() - began_ns < 1_000_000_000  # virtual


def test_what_is_no_answer_to_a_ping_is_not_a_servo() -> None:
    port = ScriptedPort(lambda _: [(0, PING_ALL), (1, bytes.fromhex("FF FF FD 00 01 04 00 55"))])
    assert broadcast_ping(port) == []


@pytest.fixture
def wire() -> Iterator[PtyServos]:
    servos = PtyServos(ScriptedServos(Servo(3)))
    yield servos
    servos.close()


def test_a_scan_over_a_real_port_reports_the_baud_rate(
    wire: PtyServos, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(servo_scan, "IDS", 100)  # 0.3 s: the scripted servo has no slots
    found = scan(wire.name, (57_600, 4_500_000), MonotonicClock())
    assert found == (ScannedServo(57_600, 3, 321, 44), ScannedServo(4_500_000, 3, 321, 44))


def test_a_scan_gives_the_port_back(wire: PtyServos, monkeypatch: pytest.MonkeyPatch) -> None:
    used: list[BusPort] = []

    class Kept(BusPort):
        def openPort(self) -> bool:  # noqa: N802
            used.append(self)
            return super().openPort()

    monkeypatch.setattr(servo_scan, "IDS", 0)
    monkeypatch.setattr(servo_scan, "BusPort", Kept)
    scan(wire.name, (1_000_000, 57_600), MonotonicClock())
    assert [port.is_open for port in used] == [False, False]


def test_a_scan_of_no_port_is_an_error() -> None:
    with pytest.raises(BusError, match="there is no port"):
        scan("/dev/ttyNONE", (57_600,), VirtualClock())


@dataclass
class _Listed:
    device: str
    description: str | None
    vid: int | None = None
    pid: int | None = None


def test_ports_are_listed_with_usb_adapters_first(monkeypatch: pytest.MonkeyPatch) -> None:
    listed = [
        _Listed("/dev/ttyS0", None),
        _Listed("/dev/ttyUSB1", "U2D2", 0x0403, 0x6014),
        _Listed("/dev/ttyUSB0", "U2D2", 0x0403, 0x6014),
    ]
    monkeypatch.setattr(list_ports, "comports", lambda: listed)
    assert serial_ports() == (
        SerialPort("/dev/ttyUSB0", "0403:6014", "U2D2"),
        SerialPort("/dev/ttyUSB1", "0403:6014", "U2D2"),
        SerialPort("/dev/ttyS0", "", ""),
    )
