"""Dynamixel protocol 2.0 frames: pure bytes, both directions.

Written out rather than taken from the SDK because the SDK's Python half never stuffs what it sends
and its unstuffing is not the inverse of stuffing. Source: ROBOTIS e-manual, "Protocol 2.0".

Instruction: ``FF FF FD 00 | id | length | instruction | parameters | CRC``; a status frame has
instruction 55 followed by an error byte. Length counts everything behind it, the CRC included.
Inside instruction and parameters each ``FF FF FD`` gets one more ``FD`` (stuffing), so that no
header can appear by chance.
"""

import enum
import struct
from array import array
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

HEADER = b"\xff\xff\xfd\x00"
STUFFING_MARK = b"\xff\xff\xfd"
LARGEST_ID = 252
BROADCAST_ID = 0xFE
ALERT = 0x80
# A sync write of goals to six servos is 44 bytes; anything near this is no frame of ours.
LARGEST_LENGTH = 4096
_FIXED = 7  # header, id, length
# Requests of a loop are the same in every tick; longer ones hold goals, which are not.
SHORT_FRAME_BYTES = 24
_HEAD, _CRC = struct.Struct("<4sBH"), struct.Struct("<H")
# Reasons of a ``BadFrame`` that callers tell apart: noise on the line is not a damaged answer.
OUTSIDE = "bytes outside a frame"
TRUNCATED = "truncated"
WRONG_CRC = "wrong CRC"


class Instruction(enum.IntEnum):
    """Instruction codes."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    CLEAR = 0x10
    CONTROL_TABLE_BACKUP = 0x20
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93
    FAST_BULK_READ = 0x9A


STATUS_BYTES = 11  # a status frame without parameters
STATUS = int(Instruction.STATUS)  # every answer is compared with it: an enum takes its time


class StatusError(enum.IntEnum):
    """Bits 0-6 of a status frame's error byte; bit 7 is ``ALERT``."""

    NONE = 0
    RESULT_FAIL = 1
    INSTRUCTION = 2
    CRC = 3
    DATA_RANGE = 4
    DATA_LENGTH = 5
    DATA_LIMIT = 6
    ACCESS = 7


def _crc_of_pairs() -> "array[int]":
    """Return the CRC of every two bytes, the first one high: a frame takes half as many steps then."""
    value: NDArray[np.int64] = np.arange(1 << 16, dtype=np.int64)
    for _ in range(16):
        value = np.where(value & 0x8000, value << 1 ^ 0x8005, value << 1) & 0xFFFF
    return array("H", value.astype(np.uint16).tobytes())


_CRC_OF_PAIRS = _crc_of_pairs()
CRC_OF_BYTES = tuple(_CRC_OF_PAIRS[:256])


@cache
def _pairs(size: int) -> struct.Struct:
    return struct.Struct(f">{size // 2}H")


@lru_cache(maxsize=64)  # the loop's own requests are the same in every tick
def crc16(data: bytes) -> int:
    """CRC-16, polynomial 0x8005, initial 0, most significant bit first; check value 0xFEE8."""
    return _crc16(data)


def _crc16(data: bytes) -> int:
    even = data if len(data) % 2 == 0 else b"\0" + data  # zeros in front change nothing
    crc = 0
    for pair in _pairs(len(even)).unpack(even):
        crc = _CRC_OF_PAIRS[crc ^ pair]
    return crc


def stuff(payload: bytes) -> bytes:
    """Put an ``FD`` behind each ``FF FF FD`` of instruction and parameters."""
    return payload.replace(STUFFING_MARK, STUFFING_MARK + b"\xfd")


def unstuff(payload: bytes) -> bytes:
    """Inverse of ``stuff``.

    Raises:
        ValueError: An ``FF FF FD`` is not followed by ``FD``; no sender stuffs like that.
    """
    if STUFFING_MARK not in payload:
        return payload
    parts = payload.split(STUFFING_MARK)
    for part in parts[1:]:
        if not part.startswith(b"\xfd"):
            raise ValueError("FF FF FD without its stuffing byte")
    return STUFFING_MARK.join([parts[0], *(part[1:] for part in parts[1:])])


def _build(servo_id: int, payload: bytes) -> bytes:
    stuffed = stuff(payload)
    body = _HEAD.pack(HEADER, servo_id, len(stuffed) + 2) + stuffed
    return body + _CRC.pack(crc16(body))


_built_often = lru_cache(maxsize=64)(_build)


def build_instruction(servo_id: int, instruction: int, parameters: bytes = b"") -> bytes:
    """Return an instruction frame, stuffed and with its CRC."""
    if len(parameters) <= SHORT_FRAME_BYTES - _FIXED - 3:
        return _built_often(servo_id, bytes((instruction,)) + parameters)
    return _build(servo_id, bytes((instruction,)) + parameters)


def build_status(servo_id: int, error: int, parameters: bytes = b"") -> bytes:
    """Return a status frame, stuffed and with its CRC."""
    return _build(servo_id, bytes((STATUS, error)) + parameters)


class Frame(NamedTuple):
    """One sound frame; a tuple, because one is made of every answer.

    Attributes:
        servo_id: Id in the frame.
        instruction: Instruction code, ``Instruction.STATUS`` for a reply.
        parameters: Parameters, unstuffed; for a reply without the error byte.
        error: Error byte of a reply, None for an instruction.
    """

    servo_id: int
    instruction: int
    parameters: bytes
    error: int | None


class BadFrame(NamedTuple):
    """Bytes that are no sound frame.

    Attributes:
        reason: What is wrong, in words.
        raw: The bytes.
    """

    reason: str
    raw: bytes


class FrameParser:
    """Finds frames in a stream of bytes, however it is cut, and takes up again after damage.

    Every byte comes out once: in a frame, in a ``BadFrame``, or it is still pending.
    """

    def __init__(self) -> None:
        self._buffer = b""

    @property
    def pending(self) -> int:
        """Bytes kept, waiting for the rest of a frame."""
        return len(self._buffer)

    def clear(self) -> None:
        """Forget what is pending."""
        self._buffer = b""

    def feed(self, data: bytes) -> list[Frame | BadFrame]:
        """Take bytes and return the frames they complete, in order."""
        if not self._buffer and len(data) <= SHORT_FRAME_BYTES:
            frame = _whole_frame(bytes(data))
            if frame is not None:
                return [frame]
        self._buffer = self._buffer + data if self._buffer else bytes(data)
        items: list[Frame | BadFrame] = []
        while self._buffer and (item := self._next()) is not None:
            items.append(item)
        return items

    def give_up(self) -> list[Frame | BadFrame]:
        """Wait no longer: what is pending is damaged, save for sound frames inside it.

        A wrong length byte makes one frame swallow those behind it; this gives them back.
        """
        items: list[Frame | BadFrame] = []
        while self._buffer:
            reason = TRUNCATED if self._buffer.startswith(HEADER) else OUTSIDE
            end = self._buffer.find(HEADER, len(HEADER))
            items.append(self._drop(end if end > 0 else len(self._buffer), reason))
            items += self.feed(b"")
        return items

    def _next(self) -> Frame | BadFrame | None:
        buffer = self._buffer
        if not buffer.startswith(HEADER):
            start = buffer.find(HEADER)
            if start > 0:
                return self._drop(start, OUTSIDE)
            surplus = len(buffer) - LARGEST_LENGTH
            return self._drop(LARGEST_LENGTH, OUTSIDE) if surplus > len(HEADER) else None
        if len(buffer) < _FIXED:
            return None
        length = buffer[5] | buffer[6] << 8
        if not 3 <= length <= LARGEST_LENGTH:
            return self._drop(len(HEADER), f"impossible length {length}")
        end = _FIXED + length
        if len(buffer) < end:
            return None
        raw = buffer[:end]
        if crc16(raw[:-2]) != raw[-2] | raw[-1] << 8:
            return self._drop(_damaged_length(raw), WRONG_CRC)
        self._buffer = buffer[end:]
        return _decode(raw)

    def _drop(self, count: int, reason: str) -> BadFrame:
        raw, self._buffer = self._buffer[:count], self._buffer[count:]
        return BadFrame(reason, raw)


def statuses_in_order(data: bytes, ids: bytes, length: int) -> list[tuple[int, bytes]] | None:
    """Return what servos that were asked together have answered, where nothing is out of the way.

    Args:
        data: All that has come.
        ids: Whom to expect, in this order.
        length: Bytes of parameters of each.

    Returns:
        Error byte and parameters of each; None if anything is missing, damaged, stuffed or too much:
        ``FrameParser`` finds out what.
    """
    size = STATUS_BYTES + length
    if not ids or len(data) != size * len(ids) or data.count(STUFFING_MARK) != len(ids):
        return None
    answered, begin, head_bytes = [], 0, _FIXED + 1
    for head in _status_heads(ids, length):
        if not data.startswith(head, begin):
            return None
        end = begin + size
        answered.append((data[begin + head_bytes], data[begin + head_bytes + 1 : end - 2]))
        begin = end
    places, shares = _crc_shares(size)
    of_bytes = shares.take(np.frombuffer(data, np.uint8).reshape(len(ids), size) + places)
    return None if any(np.bitwise_xor.reduce(of_bytes, axis=1).tolist()) else answered


@lru_cache(maxsize=64)
def _crc_shares(size: int) -> tuple[NDArray[np.int64], NDArray[np.uint16]]:
    """What each byte of a frame of so many bytes adds to its CRC less the one it brings along.

    A CRC of a frame is what the CRCs of its bytes, each with zeros in all other places, make by exclusive
    or: that takes all frames of one size at once.

    Returns:
        Where the shares of each place begin, (size,), and those of all values of all places, (256 size,);
        together they make 0 where the CRC is right.
    """
    of_byte = np.array(_CRC_OF_PAIRS[:256], dtype=np.int64)
    values = np.arange(256)
    shares = [values << 8, values, of_byte]  # from the last place on
    while len(shares) < size:
        shares.append((shares[-1] << 8 & 0xFFFF) ^ of_byte[shares[-1] >> 8])
    return 256 * np.arange(size), np.concatenate(shares[::-1]).astype(np.uint16)


@lru_cache(maxsize=64)
def _status_heads(ids: bytes, length: int) -> tuple[bytes, ...]:
    """How the answers of servos begin, up to the error byte."""
    size = STATUS_BYTES + length - _FIXED
    return tuple(_HEAD.pack(HEADER, one, size) + bytes((STATUS,)) for one in ids)


def _damaged_length(raw: bytes) -> int:
    """Return how many bytes of a frame with a wrong CRC are its own.

    One that lost bytes on the way has swallowed the beginning of the next.
    """
    inside = raw.find(HEADER, len(HEADER))
    if inside >= 0:
        return inside
    return len(raw) - next((n for n in (3, 2, 1) if raw.endswith(HEADER[:n])), 0)


@lru_cache(maxsize=64)
def _whole_frame(data: bytes) -> Frame | None:
    """Return the frame that the bytes are; None if they are none, or not one alone."""
    head_bytes = _FIXED + 3
    if len(data) < head_bytes or not data.startswith(HEADER):
        return None
    if (
        len(data) != _FIXED + (data[5] | data[6] << 8)
        or crc16(data[:-2]) != data[-2] | data[-1] << 8
    ):
        return None
    frame = _decode(data)
    return frame if isinstance(frame, Frame) else None


def _decode(raw: bytes) -> Frame | BadFrame:
    try:
        payload = unstuff(raw[_FIXED:-2])
    except ValueError as error:
        return BadFrame(str(error), raw)
    instruction = payload[0]
    if instruction != STATUS:
        return Frame(raw[4], instruction, payload[1:], None)
    if len(payload) < 2:
        return BadFrame("a status without its error byte", raw)
    return Frame(raw[4], instruction, payload[2:], payload[1])
