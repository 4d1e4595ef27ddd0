"""The virtual MX-106 bus: the bytes, the rules and the habits of the real one."""

import os
import select
import threading

import dynamixel_sdk
import numpy as np
import pytest
import serial

from drivers.clock import MonotonicClock
from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import (
    BROADCAST_ID,
    Frame,
    FrameParser,
    Instruction,
    StatusError,
    build_instruction,
)
from drivers.dynamixel.port import BusPort
from drivers.dynamixel.scan import broadcast_ping, scan
from model.errors import BusError, ConnectionLost
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from sim_hw.dynamixel.pty import PtyServoBus
from tests.sim_hw.motors import SimpleMotors

BAUD = 1_000_000
MS = 1_000_000
PATIENCE_MS = 5000.0  # so that a busy machine cannot make an answer late


class Wire:
    """Raw bytes to a virtual bus in virtual time."""

    def __init__(self, ids: tuple[int, ...] = (1, 2, 3)) -> None:
        firmware = FirmwareBank(len(ids))
        self.motors = SimpleMotors(firmware, len(ids))
        self.bus = VirtualServoBus(self.motors, firmware, ids, BAUD)
        self.t_ns = 0

    def say(self, frame: bytes, baud: int = BAUD, wait_ms: float = 20) -> bytes:
        self.t_ns += round(10e9 * len(frame) / BAUD)
        self.bus.receive(frame, self.t_ns, baud)
        self.t_ns += round(wait_ms * MS)
        self.bus.poll(self.t_ns)
        return self.bus.replies(self.t_ns)

    def ask(self, servo_id: int, instruction: int, parameters: bytes = b"") -> list[Frame]:
        heard = FrameParser().feed(self.say(build_instruction(servo_id, instruction, parameters)))
        return [frame for frame in heard if isinstance(frame, Frame)]

    def write(self, name: str, value: int, servo_id: int = 1) -> int:
        register = MX_106.table[name]
        data = register.address.to_bytes(2, "little") + register.encode(value)
        return self.ask(servo_id, Instruction.WRITE, data)[0].error or 0

    def read(self, name: str, servo_id: int = 1) -> int:
        register = MX_106.table[name]
        data = register.address.to_bytes(2, "little") + register.size.to_bytes(2, "little")
        return register.decode(self.ask(servo_id, Instruction.READ, data)[0].parameters)


def test_ping_byte_for_byte() -> None:
    answer = Wire().say(bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E"))
    assert answer[:12] == bytes.fromhex("FF FF FD 00 01 07 00 55 00 41 01 2D")


def test_broadcast_ping_is_answered_in_the_order_of_ids() -> None:
    wire = Wire(ids=(7, 2, 5))
    assert [f.servo_id for f in wire.ask(BROADCAST_ID, Instruction.PING)] == [2, 5, 7]


def test_sync_read_is_answered_in_the_order_of_the_request() -> None:
    wire = Wire()
    answers = wire.ask(BROADCAST_ID, Instruction.SYNC_READ, bytes.fromhex("84 00 04 00 03 01 02"))
    assert [f.servo_id for f in answers] == [3, 1, 2]
    assert {f.parameters for f in answers} == {(2048).to_bytes(4, "little")}


def test_wire_time_and_return_delay_count() -> None:
    wire = Wire()
    wire.bus.servos[0].table.set("return_delay_time", 250)
    frame = build_instruction(1, Instruction.PING)
    wire.say(frame, wait_ms=0)
    due = wire.bus.next_reply_ns()
    assert due == wire.t_ns + 500_000 + 50_000 + 14 * 10_000


@pytest.mark.parametrize("instruction", [Instruction.FAST_SYNC_READ, Instruction.FAST_BULK_READ])
def test_mx_firmware_does_not_know_fast_reads(instruction: int) -> None:
    assert Wire().ask(BROADCAST_ID, instruction, bytes.fromhex("84 00 04 00 01 02")) == []


def test_control_table_backup_is_an_unknown_instruction() -> None:
    frame = Wire().ask(1, Instruction.CONTROL_TABLE_BACKUP, bytes.fromhex("01 43 54 52 4C"))[0]
    assert frame.error == StatusError.INSTRUCTION


@pytest.mark.parametrize(
    ("address", "data", "error"),
    [
        (0, "41 01", StatusError.ACCESS),  # model number is read only
        (132, "00 00 00 00", StatusError.ACCESS),  # present position as well
        (60, "00", StatusError.ACCESS),  # reserved
        (116, "00 00", StatusError.DATA_LENGTH),  # half a goal position
        (117, "00 00 00", StatusError.DATA_LENGTH),
        (64, "02", StatusError.DATA_RANGE),
        (11, "02", StatusError.DATA_RANGE),  # there is no operating mode 2
        (104, "E8 03 00 00", StatusError.DATA_LIMIT),  # velocity 1000 over its limit of 210
        (116, "00 10 00 00", StatusError.DATA_LIMIT),  # 4096 in position mode
    ],
)
def test_writes_that_break_a_rule(address: int, data: str, error: StatusError) -> None:
    parameters = address.to_bytes(2, "little") + bytes.fromhex(data)
    assert Wire().ask(1, Instruction.WRITE, parameters)[0].error == error


def test_eeprom_is_locked_while_torque_is_on() -> None:
    wire = Wire()
    assert wire.write("torque_enable", 1) == 0
    assert wire.write("operating_mode", 4) == StatusError.ACCESS
    assert wire.write("torque_enable", 0) == 0
    assert wire.write("operating_mode", 4) == 0


def test_indirect_data_reach_their_targets() -> None:
    wire = Wire()
    wire.write("indirect_address_1", 132)
    wire.write("indirect_address_2", 133)
    frame = wire.ask(1, Instruction.READ, bytes.fromhex("E0 00 02 00"))[0]
    assert frame.parameters == bytes.fromhex("00 08")


def test_status_return_level() -> None:
    wire = Wire()
    wire.write("status_return_level", 1)
    assert wire.ask(1, Instruction.WRITE, bytes.fromhex("41 00 01")) == []
    assert len(wire.ask(1, Instruction.READ, bytes.fromhex("84 00 04 00"))) == 1
    wire.bus.servos[0].table.set("status_return_level", 0)
    assert wire.ask(1, Instruction.READ, bytes.fromhex("84 00 04 00")) == []
    assert len(wire.ask(1, Instruction.PING)) == 1, "a ping is always answered"


def test_reg_write_waits_for_action() -> None:
    wire = Wire()
    wire.ask(1, Instruction.REG_WRITE, bytes.fromhex("41 00 01"))
    assert (wire.read("led"), wire.read("registered_instruction")) == (0, 1)
    wire.ask(1, Instruction.ACTION)
    assert (wire.read("led"), wire.read("registered_instruction")) == (1, 0)


def test_reboot_loses_turns_and_torque() -> None:
    wire = Wire()
    wire.motors.ticks[0] = 3 * 4096 + 5.0
    wire.motors.hold = True
    wire.write("operating_mode", 4)
    wire.write("torque_enable", 1)
    assert wire.read("present_position") == 3 * 4096 + 5
    wire.ask(1, Instruction.REBOOT)
    assert wire.ask(1, Instruction.PING) == [], "it is starting"
    wire.t_ns += 250 * MS
    assert (wire.read("present_position"), wire.read("torque_enable")) == (5, 0)
    assert wire.read("operating_mode") == 4, "EEPROM stays"


def test_clear_sets_turns_back_and_fails_while_moving() -> None:
    wire = Wire()
    clear = bytes.fromhex("01 44 58 4C 22")
    wire.motors.ticks[0] = -2 * 4096.0 + 9
    wire.motors.hold = True
    wire.motors.rate[0] = 1.0
    assert wire.ask(1, Instruction.CLEAR, clear)[0].error == StatusError.RESULT_FAIL
    wire.motors.rate[0] = 0.0
    assert wire.ask(1, Instruction.CLEAR, clear)[0].error == 0
    assert wire.read("present_position") == 9


def test_a_shut_down_servo_needs_a_reboot() -> None:
    wire = Wire()
    wire.write("torque_enable", 1)
    wire.motors.temperature_c[0] = 90.0
    wire.t_ns += 10 * MS
    wire.bus.poll(wire.t_ns)
    assert wire.read("hardware_error_status") == 0x04
    assert wire.ask(1, Instruction.PING)[0].error == 0x80
    wire.write("torque_enable", 1)
    assert wire.read("torque_enable") == 0
    wire.motors.temperature_c[0] = 30.0
    wire.ask(1, Instruction.REBOOT)
    wire.t_ns += 250 * MS
    wire.write("torque_enable", 1)
    assert wire.read("torque_enable") == 1


def test_the_watchdog_trips_and_must_be_cleared() -> None:
    wire = Wire()
    wire.write("operating_mode", 4)
    wire.write("torque_enable", 1)
    wire.write("bus_watchdog", 5)
    assert wire.read("bus_watchdog") == 5, "traffic keeps it quiet"
    wire.t_ns += 110 * MS
    wire.bus.poll(wire.t_ns)
    assert wire.read("bus_watchdog") == -1
    assert wire.write("goal_position", 100) == StatusError.DATA_RANGE
    wire.write("bus_watchdog", 0)
    assert wire.write("goal_position", 100) == 0


def test_a_watchdog_sleeps_while_torque_is_off() -> None:
    wire = Wire()
    wire.write("bus_watchdog", 5)
    wire.t_ns += 1000 * MS
    wire.bus.poll(wire.t_ns)
    assert wire.read("bus_watchdog") == 5


def test_the_wrong_baud_rate_meets_silence() -> None:
    frame = build_instruction(1, Instruction.PING)
    assert Wire().say(frame, baud=57_600) == b""


def test_a_pause_inside_a_packet_drops_it() -> None:
    wire = Wire()
    frame = build_instruction(1, Instruction.PING)
    wire.say(frame[:5], wait_ms=2.0)
    assert wire.say(frame[5:]) == b""
    assert wire.say(frame) != b""


def test_a_shadow_obeys_and_never_answers() -> None:
    wire = Wire()
    wire.write("secondary_id", 1, servo_id=2)
    answers = wire.ask(1, Instruction.WRITE, bytes.fromhex("41 00 01"))
    assert [f.servo_id for f in answers] == [1]
    assert wire.read("led", servo_id=2) == 1


@pytest.mark.parametrize("profile", [(0, 0), (50, 0), (50, 5)])
def test_profiles_reach_their_goal(profile: tuple[int, int]) -> None:
    wire = Wire()
    wire.write("operating_mode", 4)
    wire.write("profile_velocity", profile[0])
    wire.write("profile_acceleration", profile[1])
    wire.write("torque_enable", 1)
    wire.write("goal_position", 3000)
    speeds = []
    for _ in range(300):
        wire.t_ns += 10 * MS
        wire.bus.poll(wire.t_ns)
        speeds.append(wire.motors.rate[0] / 0.0239691)
    assert wire.read("present_position") == pytest.approx(3000, abs=3)
    if profile[0]:
        assert max(speeds) == pytest.approx(profile[0], rel=0.15)


def test_velocity_mode_turns_at_its_goal() -> None:
    wire = Wire()
    wire.write("operating_mode", 1)
    wire.write("torque_enable", 1)
    wire.write("goal_velocity", -100)
    for _ in range(300):
        wire.t_ns += 10 * MS
        wire.bus.poll(wire.t_ns)
    assert wire.read("present_velocity") == pytest.approx(-100, abs=2)


def test_the_default_position_gain_is_the_manuals() -> None:
    firmware = FirmwareBank(1)
    firmware.mode[:] = 4
    firmware.servos["torque"] = True
    firmware.goal_position[:] = 100.0
    duty = firmware.duty(np.zeros(1), np.zeros(1), np.zeros(1), 1e-3)
    assert duty[0] * 885 == pytest.approx(6.64 * 100, rel=1e-3)


# The unmodified SDK, in memory and over a pseudo-terminal.


def test_the_plain_sdk_in_memory() -> None:
    wire = Wire()
    port = MemoryPort(wire.bus, VirtualClock(1), BAUD)
    packets = dynamixel_sdk.PacketHandler(2.0)
    assert packets.ping(port, 1) == (321, 0, 0)
    assert sorted(packets.broadcastPing(port)[0]) == [1, 2, 3]
    assert packets.write4ByteTxRx(port, 2, 116, 1000) == (0, 0)
    assert packets.read4ByteTxRx(port, 2, 116) == (1000, 0, 0)
    group = dynamixel_sdk.GroupSyncRead(port, packets, 132, 4)
    for servo_id in (1, 2, 3):
        group.addParam(servo_id)
    assert group.txRxPacket() == 0
    assert [group.getData(i, 132, 4) for i in (1, 2, 3)] == [2048, 2048, 2048]


class Served:
    """A virtual bus on a pseudo-terminal, served by a thread."""

    def __init__(self) -> None:
        wire = Wire()
        self.pty = PtyServoBus(wire.bus)
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        clock = MonotonicClock()
        while not self._done.is_set() and self.pty.filenos():
            select.select(self.pty.filenos(), [], [], 0.0005)
            self.pty.service(clock.now_ns())

    def close(self) -> None:
        self._done.set()
        self._thread.join()
        self.pty.close()


def test_the_plain_sdk_over_a_pseudo_terminal() -> None:
    served = Served()
    port = dynamixel_sdk.PortHandler(served.pty.device_name)
    try:
        assert port.openPort()
        assert port.setBaudRate(BAUD)
        packets = dynamixel_sdk.PacketHandler(2.0)
        own = port.setPacketTimeout
        port.setPacketTimeout = lambda _: port.setPacketTimeoutMillis(PATIENCE_MS)
        assert packets.ping(port, 3) == (321, 0, 0)
        port.setPacketTimeout = own
        assert port.setBaudRate(57_600)
        assert packets.ping(port, 3)[1] != 0, "wrong baud rate: silence"
    finally:
        port.closePort()
        served.close()


def test_our_port_over_a_pseudo_terminal_and_the_scan(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.dynamixel.scan.IDS", 100)  # 0.3 s
    served = Served()
    try:
        found = scan(served.pty.device_name, (57_600, BAUD), MonotonicClock())
        assert [(f.baud_rate, f.servo_id, f.model) for f in found] == [
            (BAUD, 1, 321),
            (BAUD, 2, 321),
            (BAUD, 3, 321),
        ]
        port = BusPort(served.pty.device_name, 4_500_000, MonotonicClock())
        port.openPort()
        assert served.pty.baud_rate() == 4_500_000
        with pytest.raises(BusError, match="in use by another program"):
            BusPort(served.pty.device_name, BAUD, MonotonicClock()).openPort()
        port.closePort()
    finally:
        served.close()


def test_a_server_that_is_late_says_so_now_and_then() -> None:
    said: list[str] = []
    pty = PtyServoBus(Wire().bus, notice=said.append)
    client = serial.Serial(pty.device_name, BAUD, timeout=0)
    t_ns = 1_000_000_000
    ping = build_instruction(1, Instruction.PING)

    def ask(late_ms: float, reply_ms: float) -> None:
        nonlocal t_ns
        client.write(ping)
        t_ns += round(late_ms * MS)
        pty.service(t_ns)
        assert not client.in_waiting
        t_ns += round(reply_ms * MS)
        pty.service(t_ns)
        assert len(client.read(100)) == 14

    try:
        for _ in range(5):
            ask(1.0, 1.0)
        assert (said, pty.late_answers) == ([], 0)
        ask(30.0, 1.0)  # the request waited
        ask(1.0, 50.0)  # the reply did
        assert len(said) == 1
        assert "by up to 30 ms" in said[0]
        ask(10_000.0, 1.0)
        assert pty.late_answers == 3
        assert len(said) == 2
        assert "by up to 10000 ms (times so far: 3)" in said[1]
    finally:
        client.close()
        pty.close()


def test_pulling_the_cable_is_one_kind_of_error() -> None:
    wire = Wire()
    pty = PtyServoBus(wire.bus)
    port = BusPort(pty.device_name, BAUD, MonotonicClock())
    port.openPort()
    pty.unplug()
    for action in (port.clearPort, lambda: port.writePort(b"\xff"), lambda: broadcast_ping(port)):
        with pytest.raises(ConnectionLost, match="was the cable pulled"):
            action()
    port.closePort()


def test_a_port_that_is_not_there() -> None:
    with pytest.raises(BusError, match="there is no port /dev/none"):
        BusPort("/dev/none", BAUD, MonotonicClock()).openPort()


def test_a_baud_rate_that_no_port_takes() -> None:
    master, slave = os.openpty()
    try:
        name = os.ttyname(slave)
        with pytest.raises(BusError, match="does not take -5 baud"):
            BusPort(name, -5, MonotonicClock()).openPort()
        assert serial.Serial(name, timeout=0).is_open
    finally:
        os.close(master)
        os.close(slave)
