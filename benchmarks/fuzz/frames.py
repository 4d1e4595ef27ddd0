"""Mutated bytes through both parsers: no crash, no hang, no frame with a wrong CRC, bounded memory.

``python -m benchmarks fuzz`` sends 2,000,000 mutated frames; a test sends a few thousand. What is
checked on the way does not use the code under test: the CRC is the SDK's for servos and ``binascii``'s
for the unit, and every byte fed has to come out again exactly once, in its place.
"""

import argparse
import binascii
import random
import resource
import time
from collections.abc import Callable
from dataclasses import dataclass

from dynamixel_sdk import Protocol2PacketHandler

from drivers.ati.packets import (
    Malformed,
    UnitCommand,
    build_command,
    build_record,
    parse_command,
    parse_datagram,
)
from drivers.dynamixel.frames import (
    LARGEST_LENGTH,
    BadFrame,
    FrameParser,
    build_instruction,
    build_status,
)

FRAMES = 1_000_000  # of each of the two kinds
TRICKY = b"\xff\xff\xfd\x00\xfd\xff\x55"  # what headers and stuffing are made of
_SDK = Protocol2PacketHandler()


class FuzzError(AssertionError):
    """A parser broke one of its promises; the message holds the seed and the bytes."""


@dataclass(frozen=True, slots=True)
class FuzzFigures:
    """What came of a run.

    Attributes:
        sent: Frames or datagrams sent, each mutated with probability 0.9.
        accepted: Those taken as sound.
        refused: Pieces reported as damaged.
        most_pending: Most bytes that a parser ever kept.
        seconds: Wall time.
    """

    sent: int
    accepted: int
    refused: int
    most_pending: int
    seconds: float


def fuzz_servo_frames(count: int, seed: int) -> FuzzFigures:
    """Send mutated servo frames in random cuts through ``FrameParser``.

    Raises:
        FuzzError: A frame with a wrong CRC was accepted, a byte was lost or came out twice, too much was
            kept, or anything at all was raised.
    """
    rng, parser = random.Random(seed), FrameParser()
    began, accepted, refused, most_pending = time.perf_counter(), 0, 0, 0
    stream = bytearray()  # fed and not yet come out
    for number in range(count):
        data = _mutated(_servo_frame(rng), rng, _servo_frame)
        stream += data
        found = []
        for piece in _cut(data, rng):
            found += parser.feed(piece)
            most_pending = max(most_pending, parser.pending)
        if rng.random() < 0.01:  # the line fell silent
            found += parser.give_up()
        for item in found:
            if isinstance(item, BadFrame):
                refused, length = refused + 1, len(item.raw)
                good = bytes(stream[:length]) == item.raw
            else:
                accepted, length = accepted + 1, 7 + int.from_bytes(stream[5:7], "little")
                good = _sound(bytes(stream[:length]), item.servo_id)
            if not good:
                raise FuzzError(f"seed {seed}, frame {number}: {item} from {stream[:length].hex()}")
            del stream[:length]
        if len(stream) != parser.pending or parser.pending > 2 * LARGEST_LENGTH:
            raise FuzzError(
                f"seed {seed}, frame {number}: {len(stream)} bytes, {parser.pending} kept"
            )
    return FuzzFigures(count, accepted, refused, most_pending, time.perf_counter() - began)


def fuzz_force_datagrams(count: int, seed: int) -> FuzzFigures:
    """Send mutated records and commands through ``parse_datagram`` and ``parse_command``.

    Records carry no check, so what can be asked is that exactly the bytes fed were understood.

    Raises:
        FuzzError: Bytes were made up or lost, or a wrong CRC was accepted.
    """
    rng = random.Random(seed)
    began, accepted, refused = time.perf_counter(), 0, 0
    for number in range(count):
        if rng.random() < 0.2:
            data = _mutated(_force_command(rng), rng, _force_command)
            command = parse_command(data)
            good = command is None or binascii.crc_hqx(data, 0x1234) == 0
            understood = command is not None
        else:
            data = _mutated(_force_record(rng), rng, _force_record)
            records = parse_datagram(data, 0)
            understood = not isinstance(records, Malformed)
            good = isinstance(records, Malformed) or b"".join(map(build_record, records)) == data
        if not good:
            raise FuzzError(f"seed {seed}, datagram {number}: {data.hex()}")
        accepted, refused = accepted + understood, refused + (not understood)
    return FuzzFigures(count, accepted, refused, 0, time.perf_counter() - began)


def _sound(raw: bytes, servo_id: int) -> bool:
    """Whether a frame is what it was taken for, by the SDK's CRC."""
    crc: int = _SDK.updateCRC(0, raw, len(raw) - 2)
    return raw[4] == servo_id and crc == int.from_bytes(raw[-2:], "little")


def _servo_frame(rng: random.Random) -> bytes:
    tail = bytes(
        rng.choice(TRICKY) if rng.random() < 0.3 else rng.randrange(256)
        for _ in range(rng.randrange(24))
    )
    if rng.random() < 0.7:
        return build_status(rng.randrange(253), rng.choice((0, 0, 0x80, rng.randrange(256))), tail)
    return build_instruction(rng.randrange(255), rng.choice((1, 2, 3, 0x82, 0x83)), tail)


def _force_record(rng: random.Random) -> bytes:
    mask = rng.choice((0b111111, rng.randrange(1, 64)))
    head = rng.randbytes(17) + bytes([mask])
    return head + rng.randbytes(24 * mask.bit_count())


def _force_command(rng: random.Random) -> bytes:
    command = rng.choice(tuple(UnitCommand))
    return build_command(command, rng.choice((None, 0, rng.randrange(2**32))), rng.randrange(256))


def _mutated(frame: bytes, rng: random.Random, another: Callable[[random.Random], bytes]) -> bytes:
    """Damage a frame in up to four ways; one in ten stays whole."""
    data = bytearray(frame)
    if rng.random() < 0.1:
        return frame
    for _ in range(rng.randrange(1, 5)):
        at = rng.randrange(len(data) + 1)
        match rng.randrange(7):
            case 0 if at < len(data):
                data[at] ^= 1 << rng.randrange(8)
            case 1 if at < len(data):
                data[at] = rng.randrange(256)
            case 2:
                del data[at : at + rng.randrange(1, 4)]
            case 3:
                data[at:at] = rng.randbytes(rng.randrange(1, 8))
            case 4:
                data[at:at] = TRICKY[: rng.randrange(1, len(TRICKY) + 1)]
            case 5:
                data[at:] = b""
            case _:
                data[at:at] = another(rng)
    return bytes(data)


def _cut(data: bytes, rng: random.Random) -> list[bytes]:
    at = sorted(rng.randrange(len(data) + 1) for _ in range(rng.randrange(3)))
    return [data[a:b] for a, b in zip([0, *at], [*at, len(data)], strict=True)]


def main() -> None:
    """Run both and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--seed", type=int, default=1)
    options, _ = parser.parse_known_args()
    for name, run in (
        ("servo frames", fuzz_servo_frames),
        ("force datagrams", fuzz_force_datagrams),
    ):
        figures = run(options.frames, options.seed)
        print(
            f"{name}: {figures.sent:,} sent, {figures.accepted:,} accepted, {figures.refused:,} refused,"
        )
        print(
            f"  {figures.most_pending} bytes kept at most, {figures.seconds:.1f} s, no promise broken",
            flush=True,
        )
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"peak memory {peak_mb:.0f} MB")


if __name__ == "__main__":
    main()
