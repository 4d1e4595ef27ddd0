"""Protocol 2.0 frames, byte for byte. The vectors are the manual's where it prints one."""

import pytest
from dynamixel_sdk import Protocol2PacketHandler
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel_frames import (
    BROADCAST_ID,
    BadFrame,
    Frame,
    FrameParser,
    Instruction,
    build_instruction,
    build_status,
    crc16,
    stuff,
    unstuff,
)

I = Instruction  # noqa: E741 - a table of frames reads better


@pytest.mark.parametrize(
    ("servo_id", "instruction", "parameters", "wire"),
    [
        (1, I.PING, "", "FF FF FD 00 01 03 00 01 19 4E"),
        (BROADCAST_ID, I.PING, "", "FF FF FD 00 FE 03 00 01 31 42"),
        (1, I.READ, "84 00 04 00", "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
        (1, I.WRITE, "74 00 00 02 00 00", "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"),
        (1, I.WRITE, "40 00 01", "FF FF FD 00 01 06 00 03 40 00 01 DB 66"),
        (BROADCAST_ID, I.WRITE, "40 00 00", "FF FF FD 00 FE 06 00 03 40 00 00 2E 16"),
        (1, I.WRITE, "0B 00 01", "FF FF FD 00 01 06 00 03 0B 00 01 47 63"),
        (1, I.WRITE, "0B 00 04", "FF FF FD 00 01 06 00 03 0B 00 04 59 63"),
        (1, I.WRITE, "62 00 05", "FF FF FD 00 01 06 00 03 62 00 05 68 E4"),
        (1, I.REG_WRITE, "68 00 C8 00 00 00", "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E"),
        (1, I.ACTION, "", "FF FF FD 00 01 03 00 05 02 CE"),
        (1, I.REBOOT, "", "FF FF FD 00 01 03 00 08 2F 4E"),
        (1, I.FACTORY_RESET, "01", "FF FF FD 00 01 04 00 06 01 A1 E6"),
        (1, I.CLEAR, "01 44 58 4C 22", "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC"),
        (
            BROADCAST_ID,
            I.SYNC_READ,
            "7E 00 0A 00 01 02 03 04 05 06",
            "FF FF FD 00 FE 0D 00 82 7E 00 0A 00 01 02 03 04 05 06 18 B7",
        ),
        (
            BROADCAST_ID,
            I.SYNC_READ,
            "84 00 04 00 01 02",
            "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
        ),
        (
            BROADCAST_ID,
            I.SYNC_WRITE,
            "68 00 04 00 01 32 00 00 00 02 32 00 00 00 03 32 00 00 00 04 32 00 00 00"
            "05 32 00 00 00 06 32 00 00 00",
            "FF FF FD 00 FE 25 00 83 68 00 04 00 01 32 00 00 00 02 32 00 00 00"
            "03 32 00 00 00 04 32 00 00 00 05 32 00 00 00 06 32 00 00 00 9A 49",
        ),
        (
            BROADCAST_ID,
            I.BULK_READ,
            "01 90 00 02 00 02 92 00 01 00",
            "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
        ),
        (
            BROADCAST_ID,
            I.BULK_WRITE,
            "01 20 00 02 00 A0 00 02 1F 00 01 00 50",
            "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68",
        ),
        (1, I.WRITE, "6C 00 FF FF FD 00", "FF FF FD 00 01 0A 00 03 6C 00 FF FF FD FD 00 A1 FE"),
        (
            BROADCAST_ID,
            I.FAST_SYNC_READ,
            "84 00 04 00 03 07 04",
            "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2",
        ),
        (1, I.CONTROL_TABLE_BACKUP, "01 43 54 52 4C",
         "FF FF FD 00 01 08 00 20 01 43 54 52 4C 16 F5"),
        (1, I.CONTROL_TABLE_BACKUP, "02 43 54 52 4C",
         "FF FF FD 00 01 08 00 20 02 43 54 52 4C 9E F5"),
        (
            BROADCAST_ID,
            I.FAST_BULK_READ,
            "03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00",
            "FF FF FD 00 FE 12 00 9A 03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00 DA 2D",
        ),
    ],
)  # fmt: skip
def test_instruction_frames(
    servo_id: int, instruction: Instruction, parameters: str, wire: str
) -> None:
    frame = build_instruction(servo_id, instruction, bytes.fromhex(parameters))
    assert frame == bytes.fromhex(wire)
    expected = Frame(servo_id, instruction, bytes.fromhex(parameters), None)
    assert FrameParser().feed(frame) == [expected]


@pytest.mark.parametrize(
    ("error", "parameters", "wire"),
    [
        (0, "41 01 2A", "FF FF FD 00 01 07 00 55 00 41 01 2A 21 46"),
        (0, "A6 00 00 00", "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
        (0x80, "00 08 00 00", "FF FF FD 00 01 08 00 55 80 00 08 00 00 1F 84"),
        (0, "", "FF FF FD 00 01 04 00 55 00 A1 0C"),
        (0x80, "", "FF FF FD 00 01 04 00 55 80 A2 8F"),
        (4, "", "FF FF FD 00 01 04 00 55 04 BA 8C"),
        (7, "", "FF FF FD 00 01 04 00 55 07 B0 8C"),
        # current 0, velocity -1, position 253: a robot that turns backward
        (
            0,
            "00 00 FF FF FF FF FD 00 00 00",
            "FF FF FD 00 01 0F 00 55 00 00 00 FF FF FF FF FD FD 00 00 00 DA 98",
        ),
    ],
)
def test_status_frames(error: int, parameters: str, wire: str) -> None:
    frame = build_status(1, error, bytes.fromhex(parameters))
    assert frame == bytes.fromhex(wire)
    expected = Frame(1, Instruction.STATUS, bytes.fromhex(parameters), error)
    assert FrameParser().feed(frame) == [expected]


def test_crc_check_value() -> None:
    assert crc16(b"123456789") == 0xFEE8


@given(st.binary(max_size=200))
def test_crc_is_the_sdks(data: bytes) -> None:
    assert crc16(data) == Protocol2PacketHandler().updateCRC(0, list(data), len(data))


# Bytes that make headers likely.
nasty = st.lists(st.sampled_from([0xFF, 0xFD, 0x00, 0x01, 0x55]), max_size=60).map(bytes)


@given(nasty)
def test_unstuff_is_the_inverse_of_stuff(payload: bytes) -> None:
    stuffed = stuff(payload)
    assert unstuff(stuffed) == payload
    assert b"\xff\xff\xfd\x00" not in stuffed


@given(
    st.lists(st.tuples(st.integers(0, 252), nasty), min_size=1, max_size=5),
    nasty,
    st.randoms(use_true_random=False),
)
def test_parser_finds_every_frame_however_cut(
    items: list[tuple[int, bytes]], garbage: bytes, random: object
) -> None:
    frames = [build_status(servo_id, 0, data) for servo_id, data in items]
    stream = garbage.replace(b"\xff\xff\xfd\x00", b"") + b"".join(frames)
    parser = FrameParser()
    found = []
    while stream:
        size = random.randint(1, 9)  # type: ignore[attr-defined]
        found += parser.feed(stream[:size])
        stream = stream[size:]
    sound = [(f.servo_id, f.parameters) for f in found if isinstance(f, Frame)]
    assert sound == items


@given(st.integers(0, 252), nasty, st.integers(0, 10_000))
def test_one_flipped_bit_never_gives_a_frame(servo_id: int, data: bytes, where: int) -> None:
    frame = bytearray(build_status(servo_id, 0, data))
    bit = where % (8 * len(frame))
    frame[bit // 8] ^= 1 << bit % 8
    parser = FrameParser()
    found = parser.feed(bytes(frame)) + parser.feed(build_status(7, 0, b"next") * 2)
    sound = [f for f in found if isinstance(f, Frame) and f.parameters != b"next"]
    assert sound == []


def test_a_truncated_frame_does_not_swallow_the_next() -> None:
    parser = FrameParser()
    whole = build_status(2, 0, b"\x01\x02\x03\x04")
    found = parser.feed(build_status(1, 0, b"\x01\x02\x03\x04")[:-4] + whole + whole)
    assert [f.servo_id for f in found if isinstance(f, Frame)] == [2, 2]
    assert any(isinstance(f, BadFrame) for f in found)
