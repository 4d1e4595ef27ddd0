"""A chunk of an MCAP file, taken apart: the records in it, and the time that it says it spans."""

import struct

from mcap.opcode import Opcode
from mcap.records import Chunk

FRAME = struct.Struct("<BQ")  # of a record: opcode and length
MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, number and two times
_HEAD = struct.Struct("<BQH")  # both, up to the channel
MESSAGE = int(Opcode.MESSAGE)  # an enumeration asks twice as long


def split_chunk(data: bytes, unwanted: frozenset[int]) -> tuple[list[tuple[int, int, int]], int]:
    """Take a chunk apart, without the messages of some channels.

    Of nineteen of twenty messages the channel, their first two bytes, is all that is asked.

    Args:
        data: What is in it, uncompressed.
        unwanted: Numbers of these channels.

    Returns:
        Opcode of each record, and where its content begins and ends; and where that of the last message
        begins if it is left out, -1 if not.

    Raises:
        ValueError: A record is too long or too short; of one that is cut, ``struct.error``.
    """
    size, frame, least, at, passed = len(data), FRAME.size, MESSAGE_HEAD.size, 0, -1
    records: list[tuple[int, int, int]] = []
    head, whole = _HEAD.unpack_from, data + bytes(_HEAD.size - frame)  # of the last record, too
    while at < size:
        opcode, length, channel = head(whole, at)
        begin = at + frame
        if begin > size:
            FRAME.unpack_from(data, at)  # raises
        at = begin + length
        if at > size:
            raise ValueError("a record in it is longer than the chunk")
        if opcode == MESSAGE:
            if length < least:
                raise ValueError("a message in it is too short")
            if channel in unwanted:
                passed = begin
                continue
            passed = -1
        records.append((opcode, begin, at))
    return records, passed


def believable_span(chunk: Chunk, last_ns: int) -> tuple[int, int]:
    """Return a chunk's own time span, unless its header contradicts itself or the messages before."""
    begin, end = chunk.message_start_time, chunk.message_end_time
    longest_ns = 3600 * 10**9
    if begin <= end <= begin + longest_ns and (
        last_ns < 0 or last_ns <= begin <= last_ns + longest_ns
    ):
        return begin, end
    return last_ns, -1
