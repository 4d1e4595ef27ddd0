"""Writing the log from a thread of its own, so that a slow disk delays no tick.

Most of the work (compression, the disk) happens outside Python's interpreter lock.
"""

import contextlib
import os
import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from model.errors import RecordError
from model.values.tick import Tick
from model.values.wire import WireBytes
from record.log.writer import LogWriter

# Twenty seconds at 100 Hz. When it is full, the disk has been stuck for that long.
QUEUE_TICKS = 2000
SYNC_EVERY_TICKS = 500
CLOSE_LIMIT_S = 30.0  # for what is left in the queue, and for the disk to take it


@dataclass(frozen=True, slots=True)
class StateItem:
    """A state that waits: the arguments of ``LogWriter.write_state``."""

    t_ns: int
    index: int
    encode: Callable[[], bytes]


Item: TypeAlias = Tick | tuple[WireBytes, ...] | StateItem


class BackgroundWriter:
    """Passes ticks to a ``LogWriter`` in a thread.

    Args:
        writer: The writer; belongs to the thread from now on.
    """

    def __init__(self, writer: LogWriter) -> None:
        self.dropped = 0
        self._writer = writer
        self._queue: queue.Queue[Item | None] = queue.Queue(QUEUE_TICKS)
        self._failure: RecordError | None = None
        self._thread = threading.Thread(target=self._work, name="log", daemon=True)
        self._thread.start()

    @property
    def error(self) -> RecordError | None:
        """Why the log can no longer be written, None while it can."""
        return self._writer.error or self._failure

    def write(self, tick: Tick) -> None:
        """Hand over one tick; never waits."""
        self._put(tick)

    def write_wires(self, pieces: tuple[WireBytes, ...]) -> None:
        """Hand over raw bytes of the devices; never waits."""
        if pieces:
            self._put(pieces)

    def write_state(self, t_ns: int, index: int, encode: Callable[[], bytes]) -> None:
        """Hand over a state, which is made into bytes here and not between two ticks; never waits."""
        self._put(StateItem(t_ns, index, encode))

    def _put(self, item: Item) -> None:
        try:
            self._queue.put_nowait(item)
        except queue.Full:
            self.dropped += 1
            self._failure = RecordError(
                f"the disk of {self._writer.path} does not keep up: {self.dropped} ticks lost"
            )

    def _work(self) -> None:
        """Write until told to close; after an error what comes is dropped, so that nobody waits for us."""
        try:
            self._write_all()
        except Exception as error:  # noqa: BLE001 - a thread that dies silently leaves no log
            self._failure = RecordError(
                f"the log {self._writer.path} can no longer be written: "
                f"{type(error).__name__}: {error}"
            )
            while self._queue.get() is not None:
                self.dropped += 1
        self._writer.close()

    def _write_all(self) -> None:
        written = 0
        while (item := self._queue.get()) is not None:
            if isinstance(item, StateItem):
                self._writer.write_state(item.t_ns, item.index, item.encode)
                continue
            if isinstance(item, tuple):
                self._writer.write_wires(item)
                continue
            self._writer.write(item)
            written += 1
            if written % SYNC_EVERY_TICKS == 0:
                with contextlib.suppress(OSError):  # a pipe or device has nothing to sync
                    os.fsync(self._writer.fileno())

    def close(self) -> None:
        """Write what is left and finish the file; gives up on a disk that takes nothing any more."""
        with contextlib.suppress(queue.Full):
            self._queue.put(None, timeout=CLOSE_LIMIT_S)
        self._thread.join(CLOSE_LIMIT_S)
        if self._thread.is_alive():
            self._failure = RecordError(
                f"the disk of {self._writer.path} takes nothing any more; the log is cut, "
                f"bigant log repair {self._writer.path} keeps what is there"
            )
