"""The real serial port, over a pseudo-terminal: baud rates, locking, waiting, unplugging."""

import contextlib
import fcntl
import os
import select
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import serial
from dynamixel_sdk import (
    COMM_RX_TIMEOUT,
    COMM_SUCCESS,
    GroupSyncRead,
    PortHandler,
    Protocol2PacketHandler,
)

from drivers.clock import MonotonicClock
from drivers.dynamixel import port as servo_port
from drivers.dynamixel.port import BusPort, ClockedPort
from drivers.dynamixel.requests import ServoRequests
from drivers.dynamixel.units import BAUD_CODES
from model.errors import BusError, ConnectionLost
from sim_hw.clock import VirtualClock
from tests.drivers.scripted_servos import PtyServos, ScriptedPort, ScriptedServos, Servo
from tests.drivers.sdk_over_ours import SdkRequests

PING = bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")
PING_STATUS = bytes.fromhex("FF FF FD 00 01 07 00 55 00 41 01 2A 21 46")
TCGETS2 = 0x802C542A  # struct termios2 ends with both speeds, 32 bits each
PATIENCE_MS = 2000.0  # so that a busy machine cannot make an answer late


@pytest.fixture
def wire() -> Iterator[PtyServos]:
    servos = PtyServos(ScriptedServos(Servo(1, {"firmware_version": 42}), Servo(2)))
    yield servos
    servos.close()


def opened(name: str, baud_rate: int = 1_000_000) -> BusPort:
    port = BusPort(name, baud_rate, MonotonicClock())
    port.openPort()
    port.latency_ms = PATIENCE_MS
    return port


def speed_of(fd: int) -> int:
    raw = fcntl.ioctl(fd, TCGETS2, bytes(44))
    return int(struct.unpack("<I", raw[-4:])[0])


@pytest.mark.parametrize("baud_rate", sorted(BAUD_CODES))
def test_every_baud_rate_of_the_servo_is_set_at_once(
    wire: PtyServos, baud_rate: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    original = serial.Serial._reconfigure_port  # type: ignore[attr-defined]

    def note(self: serial.Serial, *arguments: Any, **named: Any) -> None:
        asked.append(self.baudrate)
        original(self, *arguments, **named)

    monkeypatch.setattr(serial.Serial, "_reconfigure_port", note)
    port = opened(wire.name, baud_rate)
    assert speed_of(wire.slave) == baud_rate
    assert set(asked) == {baud_rate}  # the SDK would have begun with 1 Mbaud
    port.closePort()


def test_the_baud_rate_changes_without_closing(wire: PtyServos) -> None:
    port = opened(wire.name, 57_600)
    device = port.ser
    assert port.setBaudRate(4_500_000)
    assert port.ser is device
    assert device.is_open
    assert speed_of(wire.slave) == 4_500_000
    assert port.tx_time_per_byte == pytest.approx(10 / 4500)  # [ms]
    port.closePort()


def test_the_port_is_ours_alone(wire: PtyServos) -> None:
    first = opened(wire.name)
    assert first.openPort()  # again, and nothing happens
    with pytest.raises(BusError, match=r"in use by another program; close it first") as caught:
        opened(wire.name)
    assert caught.value.port == wire.name
    first.closePort()
    opened(wire.name).closePort()


def test_a_port_that_is_not_there_is_named(tmp_path: Path) -> None:
    name = str(tmp_path / "ttyNONE")
    with pytest.raises(BusError, match=f"there is no port {name}; see what is plugged in"):
        opened(name)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (PermissionError(13, "Permission denied"), "add yourself to the group dialout"),
        (ValueError("Failed to set custom baud rate (123): nope"), "does not take 123 baud"),
        (OSError(5, "Input/output error"), "cannot be opened: "),
    ],
)
def test_what_opening_fails_with_says_what_to_do(
    error: Exception, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(**_: Any) -> None:
        raise error

    monkeypatch.setattr(serial, "Serial", fail)
    with pytest.raises(BusError, match=words) as caught:
        BusPort("ttyX", 123, MonotonicClock()).openPort()
    assert caught.value.__cause__ is error


def test_bytes_are_counted_and_tapped(wire: PtyServos) -> None:
    port = opened(wire.name)
    seen: list[tuple[str, bytes]] = []
    times: list[int] = []

    def tap(direction: str, data: bytes, t_ns: int) -> None:
        seen.append((direction, data))
        times.append(t_ns)

    port.tap = tap
    assert SdkRequests(port).ping(port, 1) == (321, COMM_SUCCESS, 0)
    assert seen[0] == ("tx", PING)
    assert b"".join(data for direction, data in seen if direction == "rx") == PING_STATUS
    assert times == sorted(times)
    assert (port.bytes_sent, port.bytes_received) == (10, 14)
    port.closePort()


def test_a_silent_wait_sleeps_in_the_kernel(
    wire: PtyServos, monkeypatch: pytest.MonkeyPatch
) -> None:
    wire.stop()
    port = opened(wire.name)
    port.latency_ms = 5.0
    original, waits = select.select, []

    def note(readable: list[int], writable: list[int], other: list[int], wait_s: float) -> Any:
        if not writable:
            waits.append(wait_s)
        return original(readable, writable, other, wait_s)

    monkeypatch.setattr(select, "select", note)
    answer = ServoRequests(port).read(1, 132, 4)
    assert answer.code == COMM_RX_TIMEOUT
    assert len(waits) <= 3  # the SDK looks thousands of times
    assert all(wait_s <= 0.0123 for wait_s in waits)  # 29 bytes, twice 5 ms, 2 ms
    port.closePort()


# Row 7: one error for what the SDK raises as three.


@pytest.mark.parametrize(
    "use",
    [
        lambda port: port.clearPort(),
        lambda port: port.getBytesAvailable(),
        lambda port: port.writePort(PING),
        lambda port: port.readPort(1),
        lambda port: SdkRequests(port).ping(port, 1),
    ],
    ids=["clear", "available", "write", "read", "ping"],
)
def test_a_pulled_cable_is_one_error(wire: PtyServos, use: Callable[[BusPort], object]) -> None:
    port = opened(wire.name)
    wire.unplug()
    port.setPacketTimeoutMillis(PATIENCE_MS)
    with pytest.raises(ConnectionLost, match="was the cable pulled"):
        use(port)
    port.closePort()
    port.closePort()


def test_the_sdk_raises_unrelated_types_for_a_pulled_cable(wire: PtyServos) -> None:
    """The reason for the test above; when this fails, a newer SDK has put it right."""
    port = PortHandler(wire.name)
    port.openPort()
    wire.unplug()
    raised = set()
    for use in (port.clearPort, port.getBytesAvailable, lambda: port.writePort(PING)):
        try:
            use()
        except Exception as error:  # noqa: BLE001 - which types is the question
            raised.add(type(error))
    assert len(raised) > 1
    with contextlib.suppress(OSError):
        port.closePort()


def test_a_port_that_is_not_open_says_so() -> None:
    port = BusPort("ttyX", 57_600, MonotonicClock())
    with pytest.raises(ConnectionLost, match="ttyX is not open"):
        port.writePort(PING)


# Row 10: time.


def test_a_step_of_the_wall_clock_moves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = VirtualClock(start_ns=5_000_000_000)
    port = ClockedPort("virtual", 1_000_000, clock)
    port.setPacketTimeoutMillis(10.0)
    clock.advance(4_000_000)
    monkeypatch.setattr(time, "time", lambda: 0.0)
    assert port.getTimeSinceStart() == pytest.approx(4.0)
    assert port.remaining_ms() == pytest.approx(6.0)
    assert not port.isPacketTimeout()
    clock.advance(6_100_000)
    assert port.isPacketTimeout()
    assert port.remaining_ms() == 0


def test_the_timeout_is_wire_time_and_twice_the_latency() -> None:
    port = ClockedPort("virtual", 57_600, VirtualClock())
    port.latency_ms = 1.0
    port.setPacketTimeout(100)
    assert port.packet_timeout == pytest.approx(1000 * 100 * 10 / 57_600 + 2 + 2)


# Row 19: the adapter's latency.


class _Device:
    """A serial device that tells whether low latency was asked for."""

    def __init__(self, **_: Any) -> None:
        self.low_latency = False

    def set_low_latency_mode(self, on: bool) -> None:
        self.low_latency = on


@pytest.mark.parametrize(("text", "reported"), [("1\n", 1.0), ("16\n", 16.0), ("odd", None)])
def test_low_latency_is_asked_for_and_the_timer_is_read(
    text: str, reported: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ttyUSB0").mkdir()
    (tmp_path / "ttyUSB0" / "latency_timer").write_text(text)
    monkeypatch.setattr(servo_port, "USB_SERIAL_DEVICES", tmp_path)
    monkeypatch.setattr(serial, "Serial", _Device)
    port = BusPort("/dev/ttyUSB0", 1_000_000, MonotonicClock())
    port.openPort()
    assert vars(port.ser) == {"low_latency": True}
    assert port.latency_timer_ms == reported
    assert port.latency_ms == (reported or servo_port.UNKNOWN_LATENCY_MS)


def test_a_name_that_vanishes_while_it_is_followed_has_no_latency_timer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Between looking at a link and reading it the cable can be pulled."""
    (tmp_path / "servo_bus").symlink_to("/dev/ttyUSB0")

    def pulled(_: object) -> str:
        raise FileNotFoundError(2, "No such file or directory", str(tmp_path / "servo_bus"))

    monkeypatch.setattr(os, "readlink", pulled)
    assert servo_port.latency_timer_ms(str(tmp_path / "servo_bus")) is None


def test_a_pseudo_terminal_has_no_latency_timer(wire: PtyServos) -> None:
    port = BusPort(wire.name, 1_000_000, MonotonicClock())
    port.openPort()
    assert port.latency_timer_ms is None
    port.closePort()


# The SDK itself, as it is, over this port and over memory.


def test_the_sdk_as_it_is_runs_over_our_port(wire: PtyServos) -> None:
    port = opened(wire.name)
    handler = Protocol2PacketHandler()
    assert handler.ping(port, 1) == (321, COMM_SUCCESS, 0)
    assert handler.write4ByteTxRx(port, 2, 116, 4095) == (COMM_SUCCESS, 0)
    assert handler.read4ByteTxRx(port, 2, 116) == (4095, COMM_SUCCESS, 0)
    group = GroupSyncRead(port, handler, 132, 4)
    group.addParam(1)
    group.addParam(2)
    assert group.txRxPacket() == COMM_SUCCESS
    assert [group.getData(i, 132, 4) for i in (1, 2)] == [2048, 2048]
    port.closePort()


def test_the_sdk_broadcast_ping_runs_over_memory() -> None:
    port = ScriptedPort(ScriptedServos(Servo(1), Servo(4)).respond)
    found, code = Protocol2PacketHandler().broadcastPing(port)
    assert code == COMM_SUCCESS
    assert found == {1: [321, 44], 4: [321, 44]}


def test_a_frame_larger_than_the_wire_takes_is_a_lost_connection(
    wire: PtyServos, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody reads at the other end: the write ends after its time instead of never."""
    monkeypatch.setattr(servo_port, "WRITE_TIMEOUT_S", 0.01)
    wire.stop()
    port = opened(wire.name)
    with pytest.raises(ConnectionLost):
        port.writePort(os.urandom(200_000))
    port.closePort()
