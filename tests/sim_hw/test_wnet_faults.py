"""Every fault of the force-torque unit, on the wire, byte for byte, from its start to its end."""

import select
import socket

import pytest

from drivers.ati.discovery import parse_answer, question
from drivers.ati.packets import Malformed, parse_datagram
from drivers.ati.stream import ForceStream
from model.errors import ForceStreamError
from model.values.faults import FaultKind
from model.values.readings import ForceRecord
from robot.config.robot_file import load_robot
from sim_hw.ati.console import open_console
from sim_hw.ati.memory import MemoryDatagramLink, MemoryTextLink
from sim_hw.ati.sockets import WnetSockets
from sim_hw.clock import VirtualClock
from tests.sim_hw.faulty import START, STOP, FaultyUnit, sound_record

SECOND = 1_000_000_000
SIX = (1, 2, 3, 4, 5, 6)
# Record 13 is the first from 0.1 s on (0.104 s), record 25 is the one at 0.2 s.
BEFORE, DURING, AFTER = range(1, 13), range(13, 25), range(25, 38)


def fault(kind: str, *more: str) -> str:
    """A fault that is on from 0.1 s to 0.2 s."""
    lines = ["[[fault]]", f'kind = "{kind}"', "start_s = 0.1", "duration_s = 0.1", *more]
    return "\n".join(lines)


def sound(numbers: range) -> list[bytes]:
    return [sound_record(number) for number in numbers]


def patched(number: int, at: int, data: str) -> bytes:
    """A sound record with other bytes from a place on."""
    record, new = bytearray(sound_record(number)), bytes.fromhex(data)
    record[at : at + len(new)] = new
    return bytes(record)


def test_a_sound_record_byte_for_byte() -> None:
    expected = "c41c0020 00000001 00010a82 00000000 07 01" + 24 * "00"
    assert FaultyUnit("").start().heard(0.01) == [bytes.fromhex(expected)]
    assert FaultyUnit("").start().heard(0.3) == sound(range(1, 38))


SATURATED = "01010a81 00000000 07 01" + 6 * "7fffffff"


@pytest.mark.parametrize(
    ("text", "heard"),
    [
        (fault("packet_loss"), []),
        (fault("duplicate_packet"), [sound_record(n) for n in DURING for _ in range(2)]),
        (fault("reordered_packet"), [sound_record(n + d) for n in DURING[::2] for d in (1, 0)]),
        (fault("saturation", "transducer = 1"), [patched(n, 8, SATURATED) for n in DURING]),
        (
            fault("saturation", "transducer = 1", "counts = -2"),
            [patched(n, 8, "01010a81 00000000 07 01" + 6 * "fffffffe") for n in DURING],
        ),
        (fault("low_battery"), [patched(n, 8, "00010682 00000000 01") for n in DURING]),
        (
            fault("low_battery", "level = 9", 'led = "off"'),
            [patched(n, 8, "00010282 00000000 09") for n in DURING],
        ),
        (fault("mask_change", "transducers = [1]"), [
            sound_record(n)[:8] + bytes.fromhex("00000a80 00000000 07 00") for n in DURING
        ]),
        (fault("silent_stop", "needs_start = false"), []),
        (fault("port_change_stall"), sound(DURING)),
    ],
    ids=lambda value: value.split('"')[1] if isinstance(value, str) else "",
)  # fmt: skip
def test_a_fault_starts_and_ends_when_told(text: str, heard: list[bytes]) -> None:
    unit = FaultyUnit(text).start()
    assert unit.heard(0.1) == sound(BEFORE)
    assert unit.heard(0.1999) == heard
    assert unit.heard(0.3) == sound(AFTER)


def test_what_is_polled_once_is_what_is_polled_often() -> None:
    """When a fault is on is a matter of the record's time, not of when somebody looks."""
    text = fault("saturation", "transducer = 1") + "\n" + fault("sample_rate", "percent = -20")
    often = FaultyUnit(text).start()
    pieces = [data for i in range(1, 101) for data in often.heard(0.003 * i)]
    assert pieces == FaultyUnit(text).start().heard(0.3)


def test_a_clock_step_moves_the_stamps_and_back() -> None:
    unit = FaultyUnit(fault("clock_step", "step_s = -3600.0")).start()
    assert unit.heard(0.1) == sound(BEFORE)
    # 3600 s are 0xe10000 ticks
    assert unit.heard(0.11) == [patched(13, 0, f"{0xC41C0000 - 0xE10000 + 425:08x}")]
    assert unit.heard(0.1999) != []
    assert unit.heard(0.3) == sound(AFTER)


def test_a_rollover_wraps_the_stamps_where_told() -> None:
    unit = FaultyUnit('[[fault]]\nkind = "rollover"\nstart_s = 0.02').start()
    stamps = [data[:4].hex() for data in unit.heard(0.04)]
    assert stamps == ["ffffffae", "ffffffcf", "fffffff0", "00000011", "00000031"]


def test_batches_hold_whole_records_and_lose_none() -> None:
    unit = FaultyUnit(fault("batching", "records = 5")).start()
    assert unit.heard(0.1) == sound(BEFORE)
    joined = [b"".join(sound(numbers)) for numbers in (range(13, 18), range(18, 23))]
    assert unit.heard(0.1999) == joined
    rest = b"".join(sound(range(23, 25)))
    assert unit.heard(0.3) == [rest, *sound(AFTER)], "what was kept goes when batching ends"


def test_a_mask_change_takes_only_its_transducer_out() -> None:
    unit = FaultyUnit(fault("mask_change", "transducers = [2]"), (1, 2, 0, 0, 0, 0)).start()
    both = "00050a8a 00000000 07 03" + 48 * "00"
    assert unit.heard(0.01)[0][8:] == bytes.fromhex(both)
    unit.heard(0.1)
    assert unit.heard(0.11) == [sound_record(13)]
    unit.heard(0.1999)
    assert unit.heard(0.2)[0][8:] == bytes.fromhex(both)


def test_a_silent_stop_waits_for_a_start_that_comes_after_it() -> None:
    unit = FaultyUnit(fault("silent_stop")).start()
    assert unit.heard(0.15) == sound(BEFORE)
    unit.start(0.15)
    assert unit.heard(0.25) == [], "a start does not help while it lasts"
    unit.start(0.25)
    assert len(unit.heard(0.2999)) == 6


def test_a_port_change_stalls_until_the_power_cycle() -> None:
    stalls = FaultyUnit(fault("port_change_stall")).start()
    assert stalls.heard(0.12) == sound(range(1, 16))
    stalls.start(0.12, host_port=50_000)
    assert stalls.heard(0.1999) == []
    assert len(stalls.heard(0.3)) == 13
    powered = FaultyUnit(fault("port_change_stall", "stored_port = 50000").replace("0.1", "0.0", 1))
    assert powered.start().heard(0.09) == [], "even the first start asks for another port"


def test_a_wrong_crystal_changes_how_often_records_come_and_not_their_stamps() -> None:
    unit = FaultyUnit(fault("sample_rate", "percent = -20")).start()
    assert unit.heard(0.1) == sound(BEFORE)
    slow = unit.heard(0.2)
    assert len(slow) == 10, "every 10 ms, from 104 to 194"
    expected = [0xC41C0000 + (104 + 10 * i) * 4096 // 1000 for i in range(10)]
    assert [int.from_bytes(data[:4], "big") for data in slow] == expected
    assert [int.from_bytes(data[4:8], "big") for data in slow] == list(range(13, 23))
    assert len(unit.heard(0.3)) == 13


def test_rate_count_and_seed() -> None:
    def run(seed: int, *more: str) -> list[bytes]:
        kinds = ("packet_loss", "duplicate_packet", "reordered_packet")
        faults = "\n".join(f'[[fault]]\nkind = "{kind}"\nrate = 0.2' for kind in kinds)
        return FaultyUnit("\n".join([f"seed = {seed}", faults, *more])).start().heard(4.0)

    first = run(1)
    assert first == run(1), "the same seed gives the same bytes"
    assert first != run(2)
    lost = 500 - len(set(first))
    assert 60 < lost < 140
    assert first != sorted(first, key=lambda data: data[4:8])
    twice = FaultyUnit(fault("packet_loss", "count = 2")).start()
    assert twice.heard(0.3) == [sound_record(n) for n in range(1, 38) if n not in {13, 14}]


# The console.


def test_a_stalled_console_prints_everything_at_the_end() -> None:
    unit = FaultyUnit(fault("console_stall")).start()
    console = open_console(unit.wire)
    assert console.take(0).endswith(b">")
    console.give(b"TRANS 2\r\n", 150_000_000)
    assert console.take(199_999_999) == b""
    assert console.next_due_ns() == 200_000_000
    expected = b"TRANS 2\r\nActive: Transducer = 2 Calibration = 1\r\n>"
    assert console.take(200_000_000) == expected


def test_what_was_printed_before_a_stall_and_not_taken_does_not_spin_the_host() -> None:
    console = open_console(FaultyUnit(fault("console_stall")).start().wire)
    assert console.take(150_000_000) == b""
    assert console.next_due_ns() == 200_000_000
    assert console.take(200_000_000).endswith(b">")
    endless = open_console(FaultyUnit('[[fault]]\nkind = "console_stall"').start().wire)
    assert endless.take(1) == b""
    assert endless.next_due_ns() is None


def test_a_split_console_prints_in_pieces() -> None:
    unit = FaultyUnit(fault("split_console", "piece_bytes = 4", "gap_s = 0.002")).start()
    console = open_console(unit.wire)
    console.take(0)
    console.give(b"T ON\r\n", 100_000_000)
    heard = [console.take(100_000_000 + 1_000_000 * i) for i in range(5)]
    assert heard == [b"T ON", b"", b"\r\n>", b"", b""]
    console.give(b"T ON\r\n", 200_000_000)
    assert console.take(200_000_000) == b"T ON\r\n>"


# What is assumed about the unit.


def words(text: str, command: bytes) -> bytes:
    console = open_console(FaultyUnit("[force_unit]\n" + text).wire)
    console.take(0)
    console.give(command, 0)
    return console.take(0)


def test_what_its_console_says_is_assumed() -> None:
    assert words("", b"\r\n") == b"\r\n>"
    assert words('empty_line = ">"', b"\r\n") == b">"
    assert words("", b"XYZ\r\n") == b"XYZ\r\nUnknown command: XYZ\r\n>"
    assert words('unknown_command = "? "', b"XYZ\r\n") == b"XYZ\r\n? XYZ\r\n>"
    assert words("blank_line = true", b"T ON\r\n") == b"T ON\r\n\r\n>"
    silent = open_console(FaultyUnit("[force_unit]\nbanner = false").wire)
    assert silent.take(0) == b""


def test_what_its_records_say_is_assumed() -> None:
    settings = "[force_unit]\nbattery = 5\nextra_status = 0x2000"
    (record,) = FaultyUnit(settings).start().heard(0.01)
    assert record == sound_record(1, status="00012a82 00000000 05 01")
    echo = FaultyUnit("[force_unit]\nacknowledges = true").start()
    assert echo.heard(0.01) == [START, sound_record(1)]


@pytest.mark.parametrize(("restarts", "numbers"), [("false", [2, 3]), ("true", [1, 2])])
def test_what_a_start_does_to_the_sequence_is_assumed(restarts: str, numbers: list[int]) -> None:
    unit = FaultyUnit(f"[force_unit]\nsequence_restarts = {restarts}").start()
    assert unit.heard(0.01) == [sound_record(1)]
    unit.wire.command(STOP, 10_000_000, 49152)
    unit.start(0.02)
    assert [int.from_bytes(data[4:8], "big") for data in unit.heard(0.04)] == numbers


def test_quantised_rates_are_assumed_not_to_be() -> None:
    """243 Hz would be 16.46 ticks of 4 kHz; a unit that can do whole ticks only sends 250 Hz."""
    unit = FaultyUnit("[force_unit]\nadc_clock_hz = 4000")
    unit.unit.rate_hz = 243
    assert len(unit.start().heard(1.0)) == 250
    exact = FaultyUnit("")
    exact.unit.rate_hz = 243
    assert len(exact.start().heard(1.0)) == 243


# The driver in front of it, in virtual time.


def stream_on(text: str) -> tuple[ForceStream, VirtualClock]:
    unit, clock = FaultyUnit(text, SIX), VirtualClock(SECOND)
    links = MemoryDatagramLink(unit.wire, clock), MemoryTextLink(unit.wire, clock)
    return ForceStream(*links, load_robot().force_sensor, clock), clock


def test_the_driver_counts_what_the_air_does() -> None:
    kinds = ("packet_loss", "duplicate_packet", "reordered_packet")
    faults = [f'[[fault]]\nkind = "{kind}"\nrate = 0.05\nstart_s = 3.0' for kind in kinds]
    stream, clock = stream_on("\n".join(["seed = 4", *faults]))
    stream.connect()
    read: list[ForceRecord] = []
    for _ in range(1000):
        clock.advance(10_000_000)
        read += stream.read()
    numbers = [record.sequence for record in read]
    assert numbers == sorted(set(numbers)), "in order, none twice"
    counters = stream.counters
    assert counters.missing > 20
    assert counters.duplicate > 20
    assert counters.late > 20
    assert len(read) + counters.duplicate + counters.late == counters.records
    assert len(read) + counters.missing == numbers[-1] - numbers[0] + 1
    assert counters.malformed == 0
    assert counters.restarts == 0


def test_the_driver_restarts_a_stream_that_stopped() -> None:
    stop = '[[fault]]\nkind = "silent_stop"\nstart_s = 5.0\nduration_s = 0.5'
    stream, clock = stream_on(stop)
    stream.connect()
    kinds, last_ns = set(), 0
    while clock.now_ns() < 8 * SECOND:
        clock.advance(10_000_000)
        records = stream.read()
        last_ns = records[-1].t_ns if records else last_ns
        kinds |= {fault.kind for fault in stream.take_faults()}
    assert FaultKind.FORCE_SILENT in kinds
    assert stream.counters.restarts > 0
    assert clock.now_ns() - last_ns < 20_000_000, "it runs again"


def test_the_driver_refuses_a_unit_bound_to_another_port() -> None:
    stream, _ = stream_on('[[fault]]\nkind = "port_change_stall"\nstored_port = 50000')
    with pytest.raises(ForceStreamError, match="may be bound to another port than 49152"):
        stream.connect()


def test_the_driver_waits_for_a_console_that_stalls_and_not_for_ever() -> None:
    stall = '[[fault]]\nkind = "console_stall"\n'
    stream, _ = stream_on(stall + "duration_s = 2.0")
    stream.connect()
    stream, _ = stream_on(stall)
    with pytest.raises(ForceStreamError, match=r"did not answer 'RATE .*' in 3 s"):
        stream.connect()


def test_the_driver_reads_a_console_in_pieces_and_records_in_batches() -> None:
    pieces = '[[fault]]\nkind = "split_console"\npiece_bytes = 3\n'
    stream, clock = stream_on(pieces + '[[fault]]\nkind = "batching"\nrecords = 4')
    stream.connect()
    assert all(calibration is not None for calibration in stream.calibrations)
    stream.read()
    rate_hz = load_robot().force_sensor.rate_hz
    counts = []
    for _ in range(100):
        clock.advance(10_000_000)
        counts.append(len(stream.read()))
    assert set(counts) <= {0, 4}
    assert sum(counts) == pytest.approx(rate_hz, abs=4)
    assert stream.counters.missing == 0


# Over real sockets; the time of the wire is ours.


def served(sockets: WnetSockets, t_ns: int) -> None:
    """Serve once, when what was sent has arrived."""
    select.select(sockets.filenos(), [], [], 5.0)
    sockets.service(t_ns)


def test_faults_over_udp() -> None:
    unit = FaultyUnit(fault("duplicate_packet") + "\n" + fault("batching", "records = 6"))
    sockets = WnetSockets(unit.wire)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as host:
        try:
            host.settimeout(5.0)
            host.bind(("127.0.0.1", 0))
            host.sendto(START, ("127.0.0.1", sockets.udp_port))
            served(sockets, 0)
            for t_ms in range(0, 210, 2):
                sockets.service(t_ms * 1_000_000)
            heard = [host.recv(2048) for _ in range(12 + 2 * 2 + 1)]
        finally:
            sockets.close()
    batches = [b"".join(sound(numbers)) for numbers in (range(13, 19), range(19, 25))]
    assert heard[:12] == sound(BEFORE)
    assert heard[12:16] == [batch for batch in batches for _ in range(2)]
    assert heard[16:] == [sound_record(25)]
    parsed = parse_datagram(heard[12], 0)
    assert not isinstance(parsed, Malformed)
    assert len(parsed) == 6


def test_faults_over_tcp_and_a_name_by_discovery() -> None:
    name = '[force_unit]\nbanner = false\napplication = "Wireless F/T in pieces"\n'
    unit = FaultyUnit(name + '[[fault]]\nkind = "split_console"\npiece_bytes = 3\n')
    sockets = WnetSockets(unit.wire)
    host = socket.create_connection(("127.0.0.1", sockets.console_port), 5.0)
    asker = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    asker.settimeout(5.0)
    try:
        served(sockets, 0)
        host.sendall(b"T ON\r\n")
        served(sockets, 1_000_000)
        heard = [host.recv(100)]
        for t_ms in (2, 3):
            sockets.service(t_ms * 1_000_000)
            heard.append(host.recv(100))
        assert heard == [b"T O", b"N\r\n", b">"]
        asker.sendto(question(), ("127.0.0.1", sockets.discovery_port))
        served(sockets, 4_000_000)
        found = parse_answer(asker.recv(2048))
        assert found is not None
        assert found.text == "Wireless F/T in pieces"
    finally:
        asker.close()
        host.close()
        sockets.close()
