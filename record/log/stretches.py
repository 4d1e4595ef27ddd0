"""A log in stretches between the states that the controller left in it, each to be read by itself.

A replay that begins with such a state and ends with the next one is as good as one from the first tick on:
if every stretch ends with the state that the next begins with, all of them together are the whole. So they
can be replayed at the same time.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from model.errors import RecordError
from record.input_file import open_file
from record.log.cdr import HEADER
from record.log.framing.file_index import read_index
from record.log.reader import LogContents, TopicMessage, check_layout, read_messages
from record.log.salvage import DAMAGE, MAGIC
from record.log.state_message import STATE_TOPIC, LoggedState, decode_state
from record.topics import TICK_TOPIC

_INDEX = struct.Struct(f"<{len(HEADER)}xqq")  # t_ns and number of a tick
_FOOTER = struct.Struct("<BQQQI")
_DATA_END = struct.Struct("<BQI")
PIECE = 1 << 22  # bytes read at a time


@dataclass(frozen=True, slots=True)
class Stretch:
    """Some ticks of a log, one after the other.

    Attributes:
        begin: Number of the first.
        end: Number of the first one after them; None for all that follow.
        span: Where the first chunk begins that can hold one of them, and where the last such chunk ends
            [bytes].
        before: The controller's state before the first; None at the log's first tick.
        after: Its state after the last; None at the log's end.
    """

    begin: int
    end: int | None
    span: tuple[int, int]
    before: bytes | None
    after: bytes | None


def find_stretches(path: Path) -> tuple[Stretch, ...]:
    """Return the stretches of a log; a single one, or none, if it cannot be divided.

    Args:
        path: The log, readable.
    """
    try:
        with open_file(path) as stream:
            index = read_index(stream)
    except DAMAGE:
        return ()
    if index is None or not index.chunks:
        return ()
    channels = {one.id for one in index.channels if one.topic == STATE_TOPIC}
    states: list[tuple[LoggedState, tuple[int, int]]] = []
    for chunk in index.chunks:
        if not channels & chunk.channels:
            continue
        span = chunk.begin, chunk.end
        contents = LogContents()
        for message in read_messages(path, contents, {STATE_TOPIC}, span):
            try:
                states.append((decode_state(message.data), span))
            except DAMAGE:
                return ()
        if contents.damages:
            return ()
    numbers = [0, *(state.index for state, _ in states)]
    if any(one >= other for one, other in pairwise(numbers)):
        return ()  # several runs in one file
    first, last = index.chunks[0].begin, index.chunks[-1].end
    begins = [(0, None, first), *((state.index, state.data, span[0]) for state, span in states)]
    ends = [*((state.index, state.data, span[1]) for state, span in states), (None, None, last)]
    stretches = [
        Stretch(begin, end, (at, to), before, after)
        for (begin, before, at), (end, after, to) in zip(begins, ends, strict=True)
    ]
    if states and _is_empty(path, stretches[-1]):  # the run ended when its state was written
        del stretches[-1]
    return tuple(stretches)


def _is_empty(path: Path, stretch: Stretch) -> bool:
    contents = LogContents()
    try:
        first = next(read_stretch(path, contents, stretch), None)
    except RecordError:  # said by whoever replays it
        return False
    return first is None and not contents.damages


def read_stretch(path: Path, contents: LogContents, stretch: Stretch) -> Iterator[TopicMessage]:
    """Yield the ticks of a stretch as messages; see ``read_tick_messages``.

    Raises:
        RecordError: The file cannot be opened, or its ticks have a layout that is not known.
    """
    for message in read_messages(path, contents, {TICK_TOPIC}, stretch.span):
        check_layout(path, message, contents)
        try:
            _, index = _INDEX.unpack_from(message.data)
        except struct.error:
            index = stretch.begin  # whoever takes it apart finds it broken
        if stretch.end is not None and index >= stretch.end:
            return
        if index >= stretch.begin:
            yield message


def checksum_fits(path: Path) -> bool:
    """Whether the checksum of the whole file is that of its bytes, as far as it has one.

    Args:
        path: The log, with a proper end.
    """
    with open_file(path) as stream:
        size = stream.seek(0, 2)
        stream.seek(size - _FOOTER.size - len(MAGIC))
        _, _, summary, _, _ = _FOOTER.unpack(stream.read(_FOOTER.size))
        end = summary - _DATA_END.size
        stream.seek(end)
        _, _, expected = _DATA_END.unpack(stream.read(_DATA_END.size))
        if not expected:
            return True
        stream.seek(0)
        crc = at = 0
        while at < end:
            piece = stream.read(min(PIECE, end - at))
            if not piece:
                return False
            crc, at = zlib.crc32(piece, crc), at + len(piece)
        return crc == int(expected)
