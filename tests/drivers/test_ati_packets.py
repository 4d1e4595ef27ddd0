"""Bytes of the wireless force-torque unit."""

import binascii
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.ati.packets import (
    U32,
    Malformed,
    ParsedCommand,
    UnitCommand,
    build_command,
    build_record,
    crc16,
    device_ticks,
    parse_command,
    parse_datagram,
    unix_ns,
)
from drivers.ati.sequence import LARGEST_GAP, RESTART_JUMP, Arrival, SequenceWatch, classify
from model.values.readings import ForceRecord

V0 = bytes.fromhex("4e886762 0004085e 00150aaa 01050009 07 1f")
V1 = bytes.fromhex(
    "c41c0000 00000001 00010aaa 00000000 07 01 000f4240 ffd9da60 01c9c380 ffe91ca0 0003d090 ffffffff"
)


def record(
    ticks: int,
    sequence: int,
    status: tuple[int, int],
    battery: int,
    mask: int,
    counts: dict[int, list[int]],
) -> ForceRecord:
    table = np.zeros((6, 6), dtype=np.int64)
    for number, values in counts.items():
        table[number - 1] = values
    present = np.array([bool(mask >> i & 1) for i in range(6)])
    saturated = np.array([bool(w >> 24 + i & 1) for w in status for i in range(3)])
    return ForceRecord(
        0, ticks, sequence, np.array(status), battery, mask, table, present, saturated
    )


@pytest.mark.parametrize(
    ("command", "samples", "sequence", "wire"),
    [
        (UnitCommand.START, 0, 0, "00 0a 00 01 00 00 00 00 73 46"),
        (UnitCommand.START, 1, 0, "00 0a 00 01 00 00 00 01 63 67"),
        (UnitCommand.START, 25, 0, "00 0a 00 01 00 00 00 19 f0 5e"),
        (UnitCommand.START, 100, 0, "00 0a 00 01 00 00 00 64 5f 64"),
        (UnitCommand.START, 6000, 0, "00 0a 00 01 00 00 17 70 97 35"),
        (UnitCommand.START, 0, 1, "00 0a 01 01 00 00 00 00 36 e6"),
        (UnitCommand.STOP, None, 0, "00 06 00 02 7d 48"),
        (UnitCommand.STOP, None, 1, "00 06 01 02 4e 79"),
        (UnitCommand.PING, None, 0, "00 06 00 04 1d 8e"),
        (UnitCommand.RESET_CONSOLE, None, 0, "00 06 00 05 0d af"),
    ],
)
def test_commands(command: UnitCommand, samples: int | None, sequence: int, wire: str) -> None:
    data = build_command(command, samples, sequence)
    assert data == bytes.fromhex(wire)
    assert parse_command(data) == ParsedCommand(command, samples or 0)
    assert crc16(data) == 0


def bitwise_crc(data: bytes) -> int:
    """The definition: x^16 + x^12 + x^5 + 1, begun with 0x1234, bit by bit."""
    crc = 0x1234
    for byte in data:
        for bit in range(7, -1, -1):
            crc = crc << 1 ^ (0x1021 if (crc >> 15 ^ byte >> bit) & 1 else 0)
    return crc & 0xFFFF


@given(st.binary(max_size=64))
def test_the_crc_is_that_of_its_definition_and_of_the_standard_library(data: bytes) -> None:
    assert crc16(data) == bitwise_crc(data) == binascii.crc_hqx(data, 0x1234)


def test_crc_check_values() -> None:
    assert (crc16(b"123456789"), crc16(b"")) == (0xEDEB, 0x1234)


def test_a_damaged_command_is_none() -> None:
    assert parse_command(bytes.fromhex("00 06 00 02 7d 49")) is None
    assert parse_command(bytes.fromhex("00 0a 00 02 7d 48")) is None
    assert parse_command(b"") is None


def test_a_real_header_says_five_transducers_and_one_saturated() -> None:
    records = parse_datagram(V0 + bytes(5 * 24), 5)
    assert not isinstance(records, Malformed)
    (first,) = records
    assert first.sequence == 264286
    assert np.flatnonzero(first.present).tolist() == [0, 1, 2, 3, 4]
    assert np.flatnonzero(first.saturated).tolist() == [3]
    assert first.battery == 7
    assert first.t_ns == 5


def test_one_sensor() -> None:
    assert len(V1) == 42
    assert zlib.crc32(V1) == 0xB7095C70
    records = parse_datagram(V1, 0)
    assert not isinstance(records, Malformed)
    expected = [1000000, -2500000, 30000000, -1500000, 250000, -1]
    assert records[0].counts[0].tolist() == expected
    made = record(0xC41C0000, 1, (0x00010AAA, 0), 7, 1, {1: expected})
    assert build_record(made) == V1


def test_six_sensors() -> None:
    counts = {
        t: [t * a * 1_000_000 * (1 if a % 2 else -1) for a in range(1, 7)] for t in range(1, 7)
    }
    made = record(0xC41C0029, 0xFFFFFFFF, (0x02150AAA, 0x0015002A), 7, 0x3F, counts)
    data = build_record(made)
    assert len(data) == 162
    assert zlib.crc32(data) == 0xF0B25FE3
    records = parse_datagram(data, 0)
    assert not isinstance(records, Malformed)
    assert np.flatnonzero(records[0].saturated).tolist() == [1]
    assert unix_ns(records[0].device_ticks, 1709294400_000000000) == pytest.approx(
        1709294400.0100098e9, abs=1e3
    )


def test_two_records_in_one_datagram() -> None:
    records = []
    for ticks, sequence, at in ((0xC41C0000, 0xFFFFFFFF, 1), (0xC41C0029, 0, 7)):
        counts = {2: list(range(at, at + 6)), 5: [-v for v in range(at, at + 6)]}
        records.append(record(ticks, sequence, (0x00010AAA, 0), 5, 0x12, counts))
    data = b"".join(build_record(r) for r in records)
    assert len(data) == 132
    assert zlib.crc32(data) == 0x303C8C24
    parsed = parse_datagram(data, 0)
    assert not isinstance(parsed, Malformed)
    assert [r.sequence for r in parsed] == [0xFFFFFFFF, 0]
    assert parsed[1].counts[4].tolist() == [-7, -8, -9, -10, -11, -12]
    assert classify(parsed[1].sequence, parsed[0].sequence) == (Arrival.NEXT, 0)


@pytest.mark.parametrize(
    ("sequence", "last", "expected"),
    [
        (11, 10, (Arrival.NEXT, 0)),
        (13, 10, (Arrival.AFTER_GAP, 2)),
        (10, 10, (Arrival.DUPLICATE, 0)),
        (9, 10, (Arrival.LATE, 0)),
        (1, U32 - 2, (Arrival.AFTER_GAP, 2)),
        (U32 - 1, 0, (Arrival.LATE, 0)),
        (RESTART_JUMP + 12, 11, (Arrival.RESTART, 0)),
        (1, 5_000_000, (Arrival.RESTART, 0)),
    ],
)
def test_what_a_sequence_number_says(
    sequence: int, last: int, expected: tuple[Arrival, int]
) -> None:
    assert classify(sequence, last) == expected


@pytest.mark.parametrize("far", [RESTART_JUMP + 500, LARGEST_GAP + 202, U32 - RESTART_JUMP])
def test_one_number_far_away_is_not_believed(far: int) -> None:
    watch = SequenceWatch()
    judged = [watch.judge(n) for n in (99, 100, far, 101, 102)]
    assert [a for a, _ in judged] == [*[Arrival.NEXT] * 2, Arrival.LATE, *[Arrival.NEXT] * 2]
    other = (far + 5 * RESTART_JUMP) % U32
    assert [watch.judge(n)[0] for n in (far, other, 103)] == [*[Arrival.LATE] * 2, Arrival.NEXT]


@pytest.mark.parametrize(
    ("numbers", "believed"),
    [
        ((RESTART_JUMP + 500, RESTART_JUMP + 503), (Arrival.RESTART, 0)),
        ((U32 - RESTART_JUMP, U32 - RESTART_JUMP + 1), (Arrival.RESTART, 0)),
        ((5000, 5001), (Arrival.AFTER_GAP, 4900)),
    ],
)
def test_two_that_agree_are_believed(
    numbers: tuple[int, int], believed: tuple[Arrival, int]
) -> None:
    watch = SequenceWatch()
    judged = [watch.judge(n) for n in (100, *numbers, numbers[1] + 1)]
    assert judged == [(Arrival.NEXT, 0), (Arrival.LATE, 0), believed, (Arrival.NEXT, 0)]


@pytest.mark.parametrize("count", [1, 2, 3, 6])
def test_mask_zero_of_old_firmware_goes_by_the_length(count: int) -> None:
    data = V0[:17] + b"\0" + b"\0\0\0\1" * (6 * count)
    records = parse_datagram(data, 0)
    assert not isinstance(records, Malformed)
    assert len(records) == 1, "90 and 162 bytes are no pile of empty records"
    assert int(records[0].present.sum()) == count


@given(st.binary(max_size=400))
def test_whatever_arrives_is_records_or_malformed(data: bytes) -> None:
    parsed = parse_datagram(data, 0)
    assert isinstance(parsed, Malformed | tuple)


@given(
    st.integers(0, U32 - 1),
    st.integers(0, U32 - 1),
    st.integers(1, 63),
    st.integers(-(2**31), 2**31 - 1),
)
def test_records_survive_the_bytes(ticks: int, sequence: int, mask: int, count: int) -> None:
    numbers = [i + 1 for i in range(6) if mask >> i & 1]
    made = record(ticks, sequence, (1, 2), 9, mask, {n: [count] * 6 for n in numbers})
    parsed = parse_datagram(build_record(made), 0)
    assert not isinstance(parsed, Malformed)
    assert (parsed[0].counts == made.counts).all()
    assert (parsed[0].device_ticks, parsed[0].sequence) == (ticks, sequence)


@given(st.integers(0, 4_000_000_000), st.integers(-6 * 86400, 6 * 86400))
def test_stamps_are_found_through_clock_errors_of_six_days(unix_s: int, error_s: int) -> None:
    true_ns = unix_s * 1_000_000_000
    found = unix_ns(device_ticks(true_ns), true_ns + error_s * 1_000_000_000)
    assert abs(found - true_ns) <= 244_141


def test_a_stamp_from_a_real_recording() -> None:
    seconds = unix_ns(0xA86A81F9, 1481582000_000000000) * 1e-9
    assert seconds == pytest.approx(1481639976.123, abs=1e-3)  # 2016-12-13 14:39:36.123 UTC
