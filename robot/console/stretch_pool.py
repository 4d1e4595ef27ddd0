"""The stretches of a log on all cores at once, where each counts only if all of them do."""

from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor
from pathlib import Path
from typing import Protocol, TypeVar

from gap.worker_pool import worker_pool
from record.log.damage import Pass
from record.log.stretches import Stretch, checksum_fits
from robot.console.processes import cores


class StretchWork(Protocol):
    """What a process needs for a stretch."""

    @property
    def stretch(self) -> Stretch:
        """The stretch."""


T = TypeVar("T", bound=StretchWork)
R = TypeVar("R")


class DifferentError(Exception):
    """A stretch did not come to what the log says."""


def in_stretches(
    path: Path,
    tasks: Sequence[T],
    work: Callable[[T], R | None],
    progress: Pass,
    take: Callable[[R], None],
) -> bool:
    """Work on every stretch of a log, on all cores.

    Args:
        path: The log.
        tasks: One a stretch, in order.
        work: What is done with one, in another process; returns None if it does not count.
        progress: How far it has come is told in it.
        take: Given what each came to, in order.

    Returns:
        Whether all count; False if one does not, the log is damaged, or a process is gone. What was taken
        until then counts for nothing.
    """
    try:
        with worker_pool(min(cores(), len(tasks))) as pool:
            futures = [pool.submit(work, task) for task in tasks]
            if not checksum_fits(path):
                raise DifferentError  # the pool is left at once
            futures.reverse()  # each is let go as it is read
            for task in tasks:
                result = futures.pop().result()
                if result is None:
                    raise DifferentError
                take(result)
                progress.position = task.stretch.span[1]
                progress.tell()
    except (DifferentError, BrokenExecutor):
        return False
    progress.position, progress.finished = progress.size, True
    return True
