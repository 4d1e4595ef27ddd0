"""Our writer of MCAP files against the library's: the same bytes."""

from io import BytesIO

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from record.log.mcap_file import CHUNK_BYTES, McapFile

TOPICS = ("/a", "/b", "/c")
CALLS = tuple[int, tuple[tuple[int, bytes], ...], int, int]


def calls(seed: int, count: int) -> list[CALLS]:
    """Messages of several moments: time, channel and bytes of each, number, time of sending."""
    random = np.random.default_rng(seed)
    made: list[CALLS] = []
    for number in range(count):
        at_ns = 10**18 + int(
            random.integers(-(10**9), 10**9)
        )  # not in order: an IMU has its own stamps
        moments = tuple(
            (int(random.integers(1, len(TOPICS) + 1)), random.bytes(int(random.integers(0, 3000))))
            for _ in range(int(random.integers(0, 6)))
        )
        made.append((at_ns, moments, number, at_ns - number))
    return made


def begin(writer: Writer | McapFile) -> None:
    """What both write before the first message."""
    writer.start(profile="ros2", library="bigant")
    schema = writer.register_schema("s", "ros2msg", b"uint8 a")
    for topic in TOPICS[:2]:
        writer.register_channel(topic, "cdr", schema, {"k": topic})
    writer.add_metadata("m", {"a": "1", "b": "\u00fc"})
    writer.add_attachment(1, 2, "robot.toml", "application/toml", b"text")


def by_the_library(moments: list[CALLS]) -> bytes:
    out = BytesIO()
    writer = Writer(
        out, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD, enable_data_crcs=True
    )
    begin(writer)
    for number, (at_ns, messages, sequence, sent_ns) in enumerate(moments):
        if number == 3:  # a topic that begins later
            late = writer.register_schema("late", "ros2msg", b"x" * 100)
            writer.register_channel(TOPICS[2], "cdr", late, {})
        for channel, data in messages:
            if channel < 3 or number >= 3:
                writer.add_message(channel, at_ns, data, sent_ns, sequence)
        if number % 17 == 16:
            writer.flush()  # type: ignore[no-untyped-call]
    writer.finish()  # type: ignore[no-untyped-call]
    return out.getvalue()


def by_us(moments: list[CALLS]) -> bytes:
    out = BytesIO()
    writer = McapFile(out)
    begin(writer)
    for number, (at_ns, messages, sequence, sent_ns) in enumerate(moments):
        if number == 3:
            late = writer.register_schema("late", "ros2msg", b"x" * 100)
            writer.register_channel(TOPICS[2], "cdr", late, {})
        known = [one for one in messages if one[0] < 3 or number >= 3]
        writer.add_messages(at_ns, known, sequence, sent_ns)
        if number % 17 == 16:
            writer.flush()
    writer.finish()
    return out.getvalue()


@pytest.mark.parametrize(("seed", "count"), [(1, 0), (2, 1), (3, 40), (4, 400)])
def test_the_bytes_are_those_of_the_library(seed: int, count: int) -> None:
    moments = calls(seed, count)
    ours = by_us(moments)
    assert ours == by_the_library(moments)
    read = list(make_reader(BytesIO(ours)).iter_messages(log_time_order=False))
    assert len(read) == sum(
        channel < 3 or number >= 3 for number, one in enumerate(moments) for channel, _ in one[1]
    )
