"""Bytes of the ATI wireless force-torque unit (WNet): commands to it, records from it. Pure.

All integers are big-endian. Sources: ATI's own Java demo and the data and console session published by
TAMS-Group/tams_wireless_ft (firmware 2.1.27). What those leave open is said where it matters.
"""

import enum
import struct
from binascii import crc_hqx
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from model.values.arrays import BoolArray, IntArray, readonly
from model.values.readings import ForceRecord

TRANSDUCERS = 6
AXES = 6
TICKS_PER_SECOND = 4096
# Device stamps count from 1900, NTP's era, and wrap every 2^20 s.
NTP_TO_UNIX_S = 2_208_988_800
WRAP_S = 2**20
U32 = 2**32
_HEADER = struct.Struct(">4IBB")
_BLOCK, _COUNT = AXES * 4, np.dtype(">i4")
EVERY_TRANSDUCER = (1 << TRANSDUCERS) - 1


class UnitCommand(enum.IntEnum):
    """Commands over UDP."""

    START = 1
    STOP = 2
    PING = 4
    RESET_CONSOLE = 5


def crc16(data: bytes) -> int:
    """CRC-16, polynomial 0x1021, initial 0x1234, most significant bit first; check value 0xEDEB."""
    return crc_hqx(data, 0x1234)


def build_command(command: UnitCommand, samples: int | None = None, sequence: int = 0) -> bytes:
    """Return a command.

    Args:
        command: What to do.
        samples: For START: samples to send, 0 for endless.
        sequence: Sequence byte; the unit does not look at it.
    """
    tail = b"" if samples is None else struct.pack(">I", samples)
    body = struct.pack(">HBB", 6 + len(tail), sequence & 0xFF, command) + tail
    return body + struct.pack(">H", crc16(body))


@dataclass(frozen=True, slots=True)
class ParsedCommand:
    """A sound command, as the unit reads it.

    Attributes:
        command: Command number.
        samples: Samples asked for, 0 for endless or none given.
    """

    command: int
    samples: int


def parse_command(data: bytes) -> ParsedCommand | None:
    """Return a command, or None if length or CRC are wrong."""
    if len(data) < 6 or crc16(data) != 0 or int.from_bytes(data[:2], "big") != len(data):
        return None
    samples = int.from_bytes(data[4:8], "big") if len(data) == 10 else 0
    return ParsedCommand(data[3], samples)


@dataclass(frozen=True, slots=True)
class Malformed:
    """A datagram that holds no records.

    Attributes:
        reason: Why, in words.
    """

    reason: str


def parse_datagram(data: bytes, t_ns: int) -> tuple[ForceRecord, ...] | Malformed:
    """Return the records of a datagram, which may hold several back to back.

    A record is 18 bytes and 24 more for every bit of its transducer mask. Very old firmware sends
    mask 0; then the datagram must be one record, and its length says how many transducers it has.
    """
    records: list[ForceRecord] = []
    at = 0
    while at < len(data):
        if len(data) - at < _HEADER.size:
            return Malformed(f"{len(data) - at} bytes left over")
        ticks, sequence, status_1, status_2, battery, mask = _HEADER.unpack_from(data, at)
        if mask >= 1 << TRANSDUCERS:
            return Malformed(f"impossible transducer mask {mask:#04x}")
        shown = mask
        if mask == 0 and at == 0 and len(data) > _HEADER.size:
            count, odd = divmod(len(data) - _HEADER.size, _BLOCK)
            if odd or count > TRANSDUCERS:
                return Malformed(f"length {len(data)} fits no number of transducers")
            shown = (1 << count) - 1
        at += _HEADER.size
        size = shown.bit_count() * _BLOCK
        if len(data) - at < size:
            return Malformed(f"a record with mask {mask:#04x} is cut short")
        present = _in_mask(shown)
        block = np.frombuffer(data, _COUNT, size // 4, at).reshape(-1, AXES)
        if shown == EVERY_TRANSDUCER:
            counts = block.astype(np.int64)
        else:
            counts = np.zeros((TRANSDUCERS, AXES), dtype=np.int64)
            counts[present] = block
        at += size
        records.append(
            ForceRecord(
                t_ns=t_ns,
                device_ticks=ticks,
                sequence=sequence,
                status=_status(status_1, status_2),
                battery=battery,
                mask=mask,
                counts=readonly(counts),
                present=present,
                saturated=saturation(status_1, status_2),
            )
        )
    return tuple(records) if records else Malformed("empty")


@lru_cache(maxsize=64)
def _status(status_1: int, status_2: int) -> IntArray:
    """Both status words as an array, (2,); the same in nearly every record."""
    made: IntArray = readonly(np.array((status_1, status_2), dtype=np.int64))
    return made


def saturation(status_1: int, status_2: int) -> BoolArray:
    """Return which transducers are saturated, (6,): bits 24-26 of each status word."""
    return _in_mask(status_1 >> 24 & 0b111 | (status_2 >> 24 & 0b111) << 3)


@lru_cache(maxsize=1 << TRANSDUCERS)
def _in_mask(mask: int) -> BoolArray:
    """Whether the bit of each transducer is set, (6,); the same in nearly every record."""
    return flags(tuple(bool(mask >> i & 1) for i in range(TRANSDUCERS)))


@lru_cache(maxsize=1 << TRANSDUCERS)
def flags(of_each: tuple[bool, ...]) -> BoolArray:
    """Return a flag of each transducer as an array, (6,)."""
    made: BoolArray = readonly(np.array(of_each))
    return made


class Led(enum.IntEnum):
    """Colour of one of the unit's lights; a blinking one is off in some records."""

    OFF = 0
    RED = 1
    GREEN = 2
    ORANGE = 3


_LEDS = tuple(Led)  # by their numbers


def battery_led(status_1: int) -> Led:
    """Return the battery light, bits 10-11 of the first status word.

    The battery byte next to it has no documented scale; the light is what the unit itself thinks.
    """
    return _LEDS[status_1 >> 10 & 0b11]


def build_record(record: ForceRecord) -> bytes:
    """Return a record's bytes; the inverse of ``parse_datagram`` for one record."""
    status_1, status_2 = record.status.tolist()
    head = _HEADER.pack(
        record.device_ticks, record.sequence, status_1, status_2, record.battery, record.mask
    )
    sent = record.counts if record.mask == EVERY_TRANSDUCER else record.counts[record.present]
    return head + sent.astype(_COUNT).tobytes()


def unix_ns(device_ticks: int, near_unix_ns: int) -> int:
    """Return the UNIX time of a device stamp, taking the era nearest to a time known roughly.

    Args:
        device_ticks: Stamp, 1/4096 s, wraps every 12.1 days.
        near_unix_ns: Host time; right as long as the clocks agree to six days.
    """
    seconds, fraction = divmod(device_ticks, TICKS_PER_SECOND)
    base_ns = (seconds - NTP_TO_UNIX_S) * 1_000_000_000 + fraction * 1_000_000_000 // 4096
    wrap_ns = WRAP_S * 1_000_000_000
    turns = round((near_unix_ns - base_ns) / wrap_ns)
    return base_ns + turns * wrap_ns


def device_ticks(unix_time_ns: int) -> int:
    """Return the device stamp of a UNIX time."""
    ticks = unix_time_ns * TICKS_PER_SECOND // 1_000_000_000 + NTP_TO_UNIX_S * TICKS_PER_SECOND
    return ticks % U32
