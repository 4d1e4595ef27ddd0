"""Frames of protocol 2.0: the manual's bytes, stuffing, and a parser that finds its way back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel.frames import (
    BROADCAST_ID,
    HEADER,
    LARGEST_LENGTH,
    OUTSIDE,
    STUFFING_MARK,
    TRUNCATED,
    BadFrame,
    Frame,
    FrameParser,
    Instruction,
    build_instruction,
    build_status,
    crc16,
    statuses_in_order,
    stuff,
    unstuff,
)

ALL = BROADCAST_ID
SIX_SPEEDS_OF_50 = "".join(f"0{i} 32 00 00 00 " for i in range(1, 7))

# (servo id, instruction, parameters, the whole frame); all but the last few are the e-manual's own
INSTRUCTIONS = {
    "ping": (1, 0x01, "", "FF FF FD 00 01 03 00 01 19 4E"),
    "ping to all": (ALL, 0x01, "", "FF FF FD 00 FE 03 00 01 31 42"),
    "read position": (1, 0x02, "84 00 04 00", "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    "write goal 512": (
        1,
        0x03,
        "74 00 00 02 00 00",
        "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89",
    ),
    "torque on": (1, 0x03, "40 00 01", "FF FF FD 00 01 06 00 03 40 00 01 DB 66"),
    "torque off to all": (ALL, 0x03, "40 00 00", "FF FF FD 00 FE 06 00 03 40 00 00 2E 16"),
    "velocity mode": (1, 0x03, "0B 00 01", "FF FF FD 00 01 06 00 03 0B 00 01 47 63"),
    "extended position": (1, 0x03, "0B 00 04", "FF FF FD 00 01 06 00 03 0B 00 04 59 63"),
    "watchdog 100 ms": (1, 0x03, "62 00 05", "FF FF FD 00 01 06 00 03 62 00 05 68 E4"),
    "reg write speed 200": (
        1,
        0x04,
        "68 00 C8 00 00 00",
        "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E",
    ),
    "action": (1, 0x05, "", "FF FF FD 00 01 03 00 05 02 CE"),
    "factory reset, keep id": (1, 0x06, "01", "FF FF FD 00 01 04 00 06 01 A1 E6"),
    "reboot": (1, 0x08, "", "FF FF FD 00 01 03 00 08 2F 4E"),
    "clear": (1, 0x10, "01 44 58 4C 22", "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC"),
    "sync read six": (
        ALL,
        0x82,
        "7E 00 0A 00 01 02 03 04 05 06",
        "FF FF FD 00 FE 0D 00 82 7E 00 0A 00 01 02 03 04 05 06 18 B7",
    ),
    "sync read two": (
        ALL,
        0x82,
        "84 00 04 00 01 02",
        "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
    ),
    "sync write": (
        ALL,
        0x83,
        "68 00 04 00 " + SIX_SPEEDS_OF_50,
        "FF FF FD 00 FE 25 00 83 68 00 04 00 " + SIX_SPEEDS_OF_50 + "9A 49",
    ),
    "bulk read": (
        ALL,
        0x92,
        "01 90 00 02 00 02 92 00 01 00",
        "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
    ),
    "bulk write": (
        ALL,
        0x93,
        "01 20 00 02 00 A0 00 02 1F 00 01 00 50",
        "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68",
    ),
    "fast sync read": (
        ALL,
        0x8A,
        "84 00 04 00 03 07 04",
        "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2",
    ),
    "backup store": (1, 0x20, "01 43 54 52 4C", "FF FF FD 00 01 08 00 20 01 43 54 52 4C 16 F5"),
    "backup restore": (1, 0x20, "02 43 54 52 4C", "FF FF FD 00 01 08 00 20 02 43 54 52 4C 9E F5"),
    "fast bulk read": (
        ALL,
        0x9A,
        "03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00",
        "FF FF FD 00 FE 12 00 9A 03 84 00 04 00 07 7C 00 02 00 04 92 00 01 00 DA 2D",
    ),
    "stuffed write": (
        1,
        0x03,
        "6C 00 FF FF FD 00",
        "FF FF FD 00 01 0A 00 03 6C 00 FF FF FD FD 00 A1 FE",
    ),
}
# (error byte, parameters, the whole frame), all from servo 1
STATUSES = {
    "ping": (0x00, "41 01 2A", "FF FF FD 00 01 07 00 55 00 41 01 2A 21 46"),
    "position 166": (0x00, "A6 00 00 00", "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
    "2048, alert": (0x80, "00 08 00 00", "FF FF FD 00 01 08 00 55 80 00 08 00 00 1F 84"),
    "ok": (0x00, "", "FF FF FD 00 01 04 00 55 00 A1 0C"),
    "ok, alert": (0x80, "", "FF FF FD 00 01 04 00 55 80 A2 8F"),
    "data range": (0x04, "", "FF FF FD 00 01 04 00 55 04 BA 8C"),
    "access": (0x07, "", "FF FF FD 00 01 04 00 55 07 B0 8C"),
    "stuffed: current 0, velocity -1, position 253": (
        0x00,
        "00 00 FF FF FF FF FD 00 00 00",
        "FF FF FD 00 01 0F 00 55 00 00 00 FF FF FF FF FD FD 00 00 00 DA 98",
    ),
}


def parse(data: bytes) -> list[Frame | BadFrame]:
    return FrameParser().feed(data)


@pytest.mark.parametrize("name", INSTRUCTIONS)
def test_an_instruction_is_these_bytes_and_back(name: str) -> None:
    servo_id, code, parameters, frame = INSTRUCTIONS[name]
    given_parameters = bytes.fromhex(parameters)
    assert build_instruction(servo_id, code, given_parameters) == bytes.fromhex(frame)
    assert parse(bytes.fromhex(frame)) == [Frame(servo_id, code, given_parameters, None)]
    assert Instruction(code)


@pytest.mark.parametrize("name", STATUSES)
def test_a_status_is_these_bytes_and_back(name: str) -> None:
    error, parameters, frame = STATUSES[name]
    given_parameters = bytes.fromhex(parameters)
    assert build_status(1, error, given_parameters) == bytes.fromhex(frame)
    assert parse(bytes.fromhex(frame)) == [Frame(1, Instruction.STATUS, given_parameters, error)]


def test_the_unstuffed_write_that_the_sdk_sends_is_no_frame() -> None:
    frame = bytes.fromhex("FF FF FD 00 01 09 00 03 6C 00 FF FF FD 00 D2 C7")
    (found,) = parse(frame)
    assert isinstance(found, BadFrame)
    assert found.raw == frame


def test_crc_check_value() -> None:
    assert crc16(b"123456789") == 0xFEE8


@given(st.binary(max_size=40))
def test_crc_is_the_remainder_of_the_polynomial_division(data: bytes) -> None:
    remainder = int.from_bytes(data, "big") << 16
    for bit in range(8 * len(data) + 15, 15, -1):
        if remainder >> bit & 1:
            remainder ^= 0x18005 << (bit - 16)
    assert crc16(data) == remainder


# headers and stuffing must come up often, or the property says little
payloads = st.lists(st.sampled_from([0xFF, 0xFF, 0xFD, 0x00, 0x55, 0xFE]), max_size=24).map(bytes)


@given(payloads)
def test_unstuff_is_the_inverse_of_stuff(payload: bytes) -> None:
    stuffed = stuff(payload)
    assert unstuff(stuffed) == payload
    assert HEADER not in stuffed


@pytest.mark.parametrize("text", ["FF FF FD", "01 FF FF FD 00", "FF FF FD FD FF FF FD 01"])
def test_what_no_sender_stuffs_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="stuffing"):
        unstuff(bytes.fromhex(text))


@given(payloads, st.integers(0, 252), st.integers(0, 255))
def test_a_frame_comes_back_as_it_was(payload: bytes, servo_id: int, error: int) -> None:
    assert parse(build_status(servo_id, error, payload)) == [
        Frame(servo_id, Instruction.STATUS, payload, error)
    ]


frames = st.builds(build_status, st.integers(0, 252), st.integers(0, 255), payloads)
noise = st.binary(max_size=12)


@st.composite
def damaged(draw: st.DrawFn) -> bytes:
    frame = bytearray(draw(frames))
    if draw(st.booleans()):
        frame[draw(st.integers(0, len(frame) - 1))] ^= 1 << draw(st.integers(0, 7))
        return bytes(frame)
    return bytes(frame[: draw(st.integers(1, len(frame) - 1))])


streams = st.lists(st.one_of(frames, noise, damaged()), max_size=8).map(b"".join)


@given(streams, st.lists(st.integers(1, 9)))
def test_how_the_stream_is_cut_makes_no_difference(stream: bytes, cuts: list[int]) -> None:
    parser, found, start = FrameParser(), [], 0
    for length in [*cuts, len(stream)]:
        found += parser.feed(stream[start : start + length])
        start += length
    assert found == parse(stream)


@given(streams)
def test_every_byte_comes_out_once(stream: bytes) -> None:
    parser = FrameParser()
    found = parser.feed(stream)
    waiting = parser.pending
    taken = b"".join(
        item.raw
        if isinstance(item, BadFrame)
        else build_status(item.servo_id, item.error, item.parameters)
        if item.error is not None
        else build_instruction(item.servo_id, item.instruction, item.parameters)
        for item in found
    )
    assert taken == stream[: len(stream) - waiting]


@given(st.lists(frames, min_size=1, max_size=5), st.data())
def test_one_flipped_bit_costs_one_frame(whole: list[bytes], data: st.DataObject) -> None:
    hit = data.draw(st.integers(0, len(whole) - 1))
    frame = bytearray(whole[hit])
    # not in id, length or header: those may make it look like the beginning of something else
    frame[data.draw(st.integers(7, len(frame) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    stream = [bytes(frame) if i == hit else f for i, f in enumerate(whole)]
    parser = FrameParser()
    found = parser.feed(b"".join(stream)) + parser.give_up()
    expected = [parse(f)[0] for i, f in enumerate(whole) if i != hit]
    assert [item for item in found if isinstance(item, Frame)] == expected


POSITION_166 = bytes.fromhex("FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0")
FRAME_166 = Frame(1, Instruction.STATUS, b"\xa6\x00\x00\x00", 0)


def test_bytes_outside_a_frame_are_told_apart_from_damage() -> None:
    assert parse(b"\x00\xff" + POSITION_166) == [BadFrame(OUTSIDE, b"\x00\xff"), FRAME_166]


@pytest.mark.parametrize("kept", range(1, len(POSITION_166)))
def test_a_truncated_frame_does_not_take_the_next_one_with_it(kept: int) -> None:
    parser = FrameParser()
    found = parser.feed(POSITION_166[:kept] + POSITION_166) + parser.give_up()
    assert [item for item in found if isinstance(item, Frame)] == [FRAME_166]
    assert any(isinstance(item, BadFrame) for item in found)


def test_giving_up_names_a_truncated_frame_and_frees_what_it_swallowed() -> None:
    longer_than_said = bytearray(POSITION_166)
    longer_than_said[6] = 0x04  # length 1032
    parser = FrameParser()
    assert parser.feed(bytes(longer_than_said) + POSITION_166) == []
    assert parser.give_up() == [BadFrame(TRUNCATED, bytes(longer_than_said)), FRAME_166]
    assert parser.pending == 0


@pytest.mark.parametrize("length", [0, 2, LARGEST_LENGTH + 1])
def test_an_impossible_length_is_not_waited_for(length: int) -> None:
    broken = HEADER + b"\x01" + length.to_bytes(2, "little")
    found = parse(broken + POSITION_166)
    assert found[0] == BadFrame(f"impossible length {length}", HEADER)
    assert found[-1] == FRAME_166


def test_endless_noise_does_not_fill_the_memory() -> None:
    parser = FrameParser()
    for _ in range(20):
        parser.feed(b"\x00" * 1000)
    assert parser.pending <= 2 * LARGEST_LENGTH


def test_a_status_needs_its_error_byte() -> None:
    (found,) = parse(build_instruction(1, Instruction.STATUS))
    assert isinstance(found, BadFrame)
    assert "error byte" in found.reason


def test_clear_forgets_what_is_pending() -> None:
    parser = FrameParser()
    parser.feed(POSITION_166[:9])
    assert parser.pending == 9
    parser.clear()
    assert parser.feed(POSITION_166) == [FRAME_166]


@given(
    st.lists(st.integers(0, 252), min_size=1, max_size=7, unique=True),
    st.integers(0, 40),
    st.data(),
)
def test_answers_in_order_are_those_that_the_parser_finds(
    ids: list[int], length: int, data: st.DataObject
) -> None:
    """Also with a bit that fell over somewhere: the same answers, or none."""
    answers = [
        (data.draw(st.integers(0, 255)), data.draw(st.binary(min_size=length, max_size=length)))
        for _ in ids
    ]
    raw = bytearray(
        b"".join(build_status(i, *answer) for i, answer in zip(ids, answers, strict=True))
    )
    if data.draw(st.booleans()):
        raw[data.draw(st.integers(0, len(raw) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    found = FrameParser().feed(bytes(raw))
    parsed = [(f.servo_id, f.error, f.parameters) for f in found if isinstance(f, Frame)]
    in_order = statuses_in_order(bytes(raw), bytes(ids), length)
    if in_order is not None:
        assert parsed == [(i, *answer) for i, answer in zip(ids, in_order, strict=True)]
    stuffed = any(STUFFING_MARK in bytes([error]) + sent for error, sent in answers)
    if not stuffed and parsed == [(i, *answer) for i, answer in zip(ids, answers, strict=True)]:
        assert in_order == answers
