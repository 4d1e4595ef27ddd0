"""A log as arrays, block by block, so that memory does not grow with its length."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from model.values.machine_names import MachineNames
from model.values.tick import Tick
from model.values.tick_rows import SensedRows
from record.log.blocks.tick_columns import stack_messages
from record.log.blocks.tick_forms import FormBook
from record.log.reader import LogContents, TopicMessage, damage_of, nothing_left, read_tick_messages
from record.log.recording import Recording, join_recordings, recording_of
from record.log.salvage import DAMAGE
from record.log.stretches import Stretch, read_stretch
from record.log.tick_message import decode_tick

BLOCK_TICKS = 1024  # a power of two: thinned by halves, blocks stay in step
NO_MACHINE = MachineNames((), ())
Take = Callable[[Sequence[int], SensedRows], None]


def read_blocks(
    path: Path,
    contents: LogContents | None = None,
    block_ticks: int = BLOCK_TICKS,
    take: Take | None = None,
    stretch: Stretch | None = None,
) -> Iterator[Recording]:
    """Yield a log as arrays, a block of ticks at a time, in bounded memory.

    The damage of a block is what had been found when it was complete; the last one knows all.

    Args:
        path: The log.
        contents: Filled with robot file, metadata and damage on the way.
        block_ticks: Ticks of a block.
        take: Given the UNIX times [ns] of a block's ticks and what was sensed in them, in order, before the
            block is yielded.
        stretch: Only these ticks; None for all.

    Raises:
        RecordError: The file cannot be opened, or holds no tick that can be read.
    """
    contents = contents or LogContents()
    reader = _Blocks(contents)
    readable = False
    messages = (
        read_tick_messages(path, contents)
        if stretch is None
        else read_stretch(path, contents, stretch)
    )
    while block := list(_with_positions(islice(messages, block_ticks), contents)):
        recording = reader.recording(block, take)
        if recording is not None:
            readable = True
            yield recording
    if not readable:
        raise nothing_left(path, contents)


def read_log(
    path: Path,
    contents: LogContents | None = None,
    take: Take | None = None,
    stretch: Stretch | None = None,
) -> Recording:
    """Read a log into arrays, all of it; an hour is a gigabyte, see ``read_blocks`` for the arguments.

    Raises:
        RecordError: The file cannot be opened, or holds no tick that can be read.
    """
    contents = contents or LogContents()
    joined = join_recordings(read_blocks(path, contents, take=take, stretch=stretch), damage="")
    return replace(joined, damage=contents.damage)


def _with_positions(
    messages: Iterator[TopicMessage], contents: LogContents
) -> Iterator[tuple[TopicMessage, int]]:
    """Yield messages with the place in the file where they were found."""
    for message in messages:
        yield message, contents.progress.position


class _Blocks:
    """What is known of a log from block to block."""

    def __init__(self, contents: LogContents) -> None:
        self._contents = contents
        self._book = FormBook()
        self._start_unix_ns: int | None = None

    def recording(
        self, block: list[tuple[TopicMessage, int]], take: Take | None
    ) -> Recording | None:
        """Return a block as arrays; None if no tick of it can be read."""
        contents, messages = self._contents, [message for message, _ in block]
        first = next(filter(None, map(_decoded, messages)), None)
        machine = contents.machine(first) if first is not None else NO_MACHINE
        stacked = stack_messages(messages, machine, self._book, with_sensed=take is not None)
        self._note_damage([(*block[place], error) for place, error in stacked.broken])
        if first is None:
            return None
        unix_ns = np.array([message.unix_ns for message in messages])[stacked.kept]
        if self._start_unix_ns is None:
            self._start_unix_ns = contents.start_unix_ns(int(unix_ns[0]))
        if take is not None and stacked.sensed is not None:
            take(unix_ns.tolist(), stacked.sensed)
        return recording_of(
            {"t_s": (unix_ns - self._start_unix_ns) * 1e-9, **stacked.arrays},
            stacked.faults,
            machine=machine,
            config_text=contents.config_text,
            metadata=contents.metadata,
            damage=contents.damage,
        )

    def _note_damage(self, broken: list[tuple[TopicMessage, int, Exception]]) -> None:
        """Note ticks that cannot be taken apart, in file order with all other damage."""
        damages = self._contents.progress.damages
        damages += [damage_of(*one) for one in broken]
        if broken:
            damages.sort(key=lambda damage: damage.offset)


def _decoded(message: TopicMessage) -> Tick | None:
    try:
        return decode_tick(message.data, message.layout)
    except DAMAGE:
        return None
