"""The SDK's own requests over the repaired packet handler, and the typed requests beside them."""

import pytest
from dynamixel_sdk import (
    COMM_NOT_AVAILABLE,
    COMM_RX_CORRUPT,
    COMM_RX_TIMEOUT,
    COMM_SUCCESS,
    COMM_TX_FAIL,
    GroupSyncRead,
    GroupSyncWrite,
    Protocol2PacketHandler,
)
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel.frames import Frame, Instruction, StatusError, build_status
from drivers.dynamixel.packets import ServoAnswer
from drivers.dynamixel.requests import ServoRequests
from model.errors import ConnectionLost
from tests.drivers.scripted_servos import Replies, ScriptedPort, ScriptedServos, Servo
from tests.drivers.sdk_over_ours import SdkRequests

PRESENT_POSITION = 132
STUFFED_WRITE = bytes.fromhex("FF FF FD 00 01 0A 00 03 6C 00 FF FF FD FD 00 A1 FE")
UNSTUFFED_WRITE = bytes.fromhex("FF FF FD 00 01 09 00 03 6C 00 FF FF FD 00 D2 C7")
STUFFED_STATUS = bytes.fromhex("FF FF FD 00 01 0F 00 55 00 00 00 FF FF FF FF FD FD 00 00 00 DA 98")


def bus(*servos: Servo) -> tuple[ScriptedServos, ScriptedPort, SdkRequests]:
    scripted = ScriptedServos(*servos)
    port = ScriptedPort(scripted.respond)
    return scripted, port, SdkRequests(port)


def answering(*replies: bytes) -> tuple[ScriptedPort, SdkRequests]:
    """A port on which each request gets the next of these replies."""
    left = list(replies)
    port = ScriptedPort(lambda _: [(1000, left.pop(0))] if left else [])
    return port, SdkRequests(port)


# Row 1: what the SDK sends.


def test_the_sdk_as_it_is_sends_without_stuffing() -> None:
    port = ScriptedPort(lambda _: [])
    Protocol2PacketHandler().write4ByteTxOnly(port, 1, 108, 0x00FDFFFF)
    assert port.sent == [UNSTUFFED_WRITE]


def test_what_the_sdk_lays_out_is_sent_stuffed() -> None:
    port, packets = answering()
    assert packets.write4ByteTxOnly(port, 1, 108, 0x00FDFFFF) == COMM_SUCCESS
    assert port.sent == [STUFFED_WRITE]


def test_our_own_write_is_stuffed_too() -> None:
    port, packets = answering(build_status(1, 0))
    assert packets.write(1, 108, b"\xff\xff\xfd\x00").ok
    assert port.sent == [STUFFED_WRITE]


# Row 2: what comes in.


def test_a_stuffed_status_is_read_as_it_was_meant() -> None:
    _port, packets = answering(STUFFED_STATUS)
    answer = packets.read(1, 126, 10)
    assert answer == ServoAnswer(bytes.fromhex("00 00 FF FF FF FF FD 00 00 00"), 0, COMM_SUCCESS)


@given(st.lists(st.sampled_from([0xFF, 0xFF, 0xFD, 0x00]), min_size=1, max_size=16).map(bytes))
def test_any_data_comes_through_the_sdk_as_it_was(data: bytes) -> None:
    port, packets = answering(build_status(1, 0, data))
    assert packets.readTxRx(port, 1, 100, len(data)) == (list(data), COMM_SUCCESS, 0)


# Row 5: error byte and length come before the data.


@pytest.mark.parametrize("size", [1, 2, 4])
def test_an_error_is_no_data_for_the_sdk_helpers(size: int) -> None:
    port, packets = answering(bytes.fromhex("FF FF FD 00 01 04 00 55 07 B0 8C"))
    helper = {1: packets.read1ByteTxRx, 2: packets.read2ByteTxRx, 4: packets.read4ByteTxRx}[size]
    value, code, error = helper(port, 1, 600)
    assert code != COMM_SUCCESS
    assert (value, error) == (0, StatusError.ACCESS)


def test_an_error_is_no_data_for_us() -> None:
    _port, packets = answering(bytes.fromhex("FF FF FD 00 01 04 00 55 07 B0 8C"))
    answer = packets.read(1, 600, 2)
    assert answer.data is None
    assert not answer.ok
    assert answer.words == "error: access"
    assert packets.counters.snapshot().status_errors == 1


def test_data_of_another_length_is_not_used() -> None:
    _port, packets = answering(build_status(1, 0, b"\x01\x02"))
    assert packets.read(1, 132, 4) == ServoAnswer(None, 0, COMM_RX_TIMEOUT)
    assert packets.counters.snapshot().foreign_replies == 1


# Row 6: an exception leaves nothing behind.


class _Broken(ScriptedPort):
    broken_read = broken_write = False

    def writePort(self, packet: bytes) -> int:  # noqa: N802
        if self.broken_write:
            raise ConnectionLost("gone")
        return super().writePort(packet)

    def readPort(self, length: int) -> bytes:  # noqa: N802
        if self.broken_read:
            raise ConnectionLost("gone")
        return super().readPort(length)


@pytest.mark.parametrize("where", ["broken_read", "broken_write"])
def test_the_port_is_not_busy_after_an_exception(where: str) -> None:
    port = _Broken(ScriptedServos(Servo(1)).respond)
    packets = SdkRequests(port)
    setattr(port, where, True)
    with pytest.raises(ConnectionLost):
        packets.ping(port, 1)
    assert not port.is_using
    setattr(port, where, False)
    assert packets.ping(port, 1) == (321, COMM_SUCCESS, 0)


class _Choking(ScriptedPort):
    def writePort(self, packet: bytes) -> int:  # noqa: N802
        return super().writePort(packet) - 1


def test_a_request_that_was_not_sent_whole_is_no_request() -> None:
    packets = ServoRequests(_Choking(lambda _: []))
    answer = packets.read(1, 132, 4)
    assert answer.code == COMM_TX_FAIL
    assert answer.words == "the request could not be sent"
    assert [a.code for a in packets.sync_read([1, 2], 132, 4, 0.0)] == [COMM_TX_FAIL] * 2


# Row 8: how long a silent servo costs.


def test_a_missing_servo_costs_latency_and_wire_time_and_no_more() -> None:
    port, packets = answering()
    began_ns = port.clock.now_ns()
    assert packets.read(1, 132, 4).code == COMM_RX_TIMEOUT
    assert 2e6 < port.clock.now_ns() - began_ns < 5e6  # virtual; the SDK takes 34 ms


# Row 12: late answers.


def late(scripted: ScriptedServos, delays_ns: list[int]) -> None:
    """Let each reply, as long as the list goes, come so much later."""

    def edit(_servo_id: int, _frame: Frame, at_ns: int, data: bytes) -> Replies:
        return [(at_ns + (delays_ns.pop(0) if delays_ns else 0), data)]

    scripted.edit = edit


def test_an_answer_after_its_time_is_not_the_next_one() -> None:
    scripted, _port, packets = bus(Servo(1, {"present_position": 1234, "present_velocity": -7}))
    late(scripted, [4_700_000])  # the read of 4 bytes is given up after 4.3 ms
    assert packets.read(1, 132, 4).code == COMM_RX_TIMEOUT
    answer = packets.read(1, 128, 4)
    assert answer.data == (-7).to_bytes(4, "little", signed=True)
    assert packets.counters.snapshot().late_replies == 1


def test_a_sync_read_after_a_timeout_waits_for_what_is_late() -> None:
    scripted, _port, packets = bus(Servo(1, {"present_position": 1}))
    late(scripted, [4_700_000])
    assert packets.sync_read([1], PRESENT_POSITION, 4, 0.0)[0].words == "no answer"
    scripted.servos[1].values["present_position"] = 2
    assert packets.sync_read([1], PRESENT_POSITION, 4, 0.0)[0].data == b"\x02\0\0\0"
    assert packets.counters.snapshot().late_replies == 1


def test_a_late_answer_that_is_there_already_is_dropped_without_waiting() -> None:
    scripted, port, packets = bus(Servo(1, {"present_position": 1}), Servo(2))
    twice = build_status(1, 0, (999).to_bytes(4, "little"))
    scripted.edit = lambda _, __, at, data: [(at, data), (at + 1000, twice)]
    assert packets.read(1, 132, 4).data == (1).to_bytes(4, "little")
    port.virtual.advance(2000)
    began_ns = port.clock.now_ns()
    assert packets.read(1, 132, 4).data == (1).to_bytes(4, "little")
    assert port.clock.now_ns() - began_ns < 500_000
    assert packets.counters.snapshot().late_replies == 1


@pytest.mark.parametrize("place", [0, 2, 5])
def test_an_old_answer_within_a_sync_read_gives_way_to_the_new_one(place: int) -> None:
    ids = [1, 2, 3, 4, 5, 6]
    _, port, packets = bus(*(Servo(i, {"present_position": 10 * i}) for i in ids))
    old = build_status(ids[place], 0, (9999).to_bytes(4, "little"))
    respond = port.respond
    port.respond = lambda request: [(1000, old), *respond(request)]
    answers = packets.sync_read(ids, PRESENT_POSITION, 4, 0.0)
    assert [int.from_bytes(a.data or b"", "little") for a in answers] == [10 * i for i in ids]
    assert packets.counters.snapshot().late_replies == 1


# Rows 3, 13, 17: groups.


def test_the_sdk_group_read_works_over_the_repaired_handler() -> None:
    _, port, packets = bus(*(Servo(i, {"present_position": -i}) for i in (1, 2)))
    group = GroupSyncRead(port, packets, PRESENT_POSITION, 4)
    assert group.addParam(1)
    assert group.addParam(2)
    assert group.txRxPacket() == COMM_SUCCESS
    assert group.getData(2, PRESENT_POSITION, 4) == 0xFFFFFFFE  # the SDK knows no signs (row 16)


def test_the_sdk_group_write_works_over_the_repaired_handler() -> None:
    scripted, port, packets = bus(Servo(1), Servo(2))
    group = GroupSyncWrite(port, packets, 104, 4)
    assert group.addParam(1, [0xFF, 0xFF, 0xFD, 0x00])
    assert group.addParam(2, [50, 0, 0, 0])
    assert group.txPacket() == COMM_SUCCESS
    assert scripted.servos[1].values["goal_velocity"] == 0x00FDFFFF
    assert scripted.servos[2].values["goal_velocity"] == 50


def test_six_speeds_in_one_sync_write() -> None:
    port, packets = answering()
    speed = (50).to_bytes(4, "little")
    packets.sync_write(104, [(i, speed) for i in range(1, 7)])
    assert port.sent == [
        bytes.fromhex(
            "FF FF FD 00 FE 25 00 83 68 00 04 00 01 32 00 00 00 02 32 00 00 00"
            "03 32 00 00 00 04 32 00 00 00 05 32 00 00 00 06 32 00 00 00 9A 49"
        )
    ]


@pytest.mark.parametrize(
    "items", [[], [(1, b"\x01"), (2, b"\x01\x02")], [(1, b"\x01"), (1, b"\x02")]]
)
def test_a_sync_write_that_makes_no_sense_is_not_sent(items: list[tuple[int, bytes]]) -> None:
    port, packets = answering()
    with pytest.raises(ValueError, match="sync write"):
        packets.sync_write(104, items)
    assert port.sent == []
    assert not port.is_using


def test_a_foreign_servo_and_an_echo_are_passed_over() -> None:
    scripted, port, packets = bus(Servo(1), Servo(2, {"present_position": 5}))
    respond = port.respond
    stranger = build_status(9, 0, (7).to_bytes(4, "little"))
    port.respond = lambda request: [(0, request), (10, stranger), *respond(request)]
    answers = packets.sync_read([1, 2], PRESENT_POSITION, 4, 0.0)
    assert [a.ok for a in answers] == [True, True]
    assert packets.counters.snapshot().foreign_replies == 1
    assert len(scripted.requests) == 1


@pytest.mark.parametrize("silent", [1, 3, 6])
def test_one_silent_servo_hides_nobody(silent: int) -> None:
    ids = [1, 2, 3, 4, 5, 6]
    _, _port, packets = bus(*(Servo(i, silent=i == silent) for i in ids))
    answers = packets.sync_read(ids, PRESENT_POSITION, 4, 0.0)
    assert [a.data is None for a in answers] == [i == silent for i in ids]
    assert answers[silent - 1].words == "no answer"
    assert packets.counters.snapshot().timeouts == 1


@pytest.mark.parametrize("hit", range(4, 15))
def test_one_damaged_answer_hides_nobody(hit: int) -> None:
    """Wherever the bit flips behind the header, also in the length of the frame."""
    ids = [1, 2, 3]
    scripted, _port, packets = bus(*(Servo(i) for i in ids))

    def edit(servo_id: int, _frame: Frame, at_ns: int, data: bytes) -> Replies:
        if servo_id != 2:
            return [(at_ns, data)]
        return [(at_ns, data[:hit] + bytes([data[hit] ^ 0x10]) + data[hit + 1 :])]

    scripted.edit = edit
    answers = packets.sync_read(ids, PRESENT_POSITION, 4, 0.0)
    assert [a.data is not None for a in answers] == [True, False, True]
    assert answers[1].words == "a damaged answer"
    stats = packets.counters.snapshot()
    assert stats.crc_errors >= 1
    assert stats.timeouts == 0


def test_noise_on_the_line_is_counted_and_harms_nobody() -> None:
    scripted, _port, packets = bus(Servo(1))
    scripted.edit = lambda _, __, at, data: [(at, b"\x00\xff" + data[:5]), (at + 900, data[5:])]
    assert packets.read(1, 132, 4).ok
    stats = packets.counters.snapshot()
    assert (stats.noise_bytes, stats.crc_errors) == (2, 0)


def test_the_wait_ends_with_the_last_answer() -> None:
    ids = [1, 2, 3, 4, 5, 6]
    _, port, packets = bus(*(Servo(i) for i in ids))
    began_ns = port.clock.now_ns()
    packets.sync_read(ids, 124, 23, 0.0)
    wire_ns = (20 + 6 * 34) * 10_000
    assert port.clock.now_ns() - began_ns == wire_ns + 6 * 50_000
    stats = packets.counters.snapshot()
    assert sum(stats.round_trips) == 1
    assert stats.longest_round_trip_us == 2540
    assert stats.round_trips[3] == 1  # 2 to 3 ms


# Row 18: an alert is no error.


def test_an_alert_is_kept_and_the_data_is_used() -> None:
    _port, packets = answering(bytes.fromhex("FF FF FD 00 01 08 00 55 80 00 08 00 00 1F 84"))
    answer = packets.read(1, 132, 4)
    assert answer.ok
    assert (answer.data, answer.error) == ((2048).to_bytes(4, "little"), 0x80)


def test_words_for_an_error_that_nobody_knows() -> None:
    assert ServoAnswer(None, 0x33, COMM_SUCCESS).words == "error 51"


def test_a_broadcast_read_is_refused() -> None:
    port, packets = answering()
    assert packets.readTxRx(port, 0xFE, 132, 4) == ([], COMM_NOT_AVAILABLE, 0)
    assert port.sent == []


def test_a_truncated_answer_is_damage_not_silence() -> None:
    _port, packets = answering(STUFFED_STATUS[:-3])
    assert packets.read(1, 126, 10) == ServoAnswer(None, 0, COMM_RX_CORRUPT)


def test_ask_sends_any_instruction() -> None:
    scripted, port, packets = bus(Servo(1, {"present_position": 5000}))
    assert packets.ask(1, Instruction.PING).data == bytes.fromhex("41 01 2C")
    assert packets.ask(1, Instruction.CLEAR, bytes.fromhex("01 44 58 4C 22")).ok
    assert scripted.servos[1].values["present_position"] == 904
    assert packets.clearMultiTurn(port, 1) == (COMM_SUCCESS, 0)
