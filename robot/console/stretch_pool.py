"""The stretches of a log on all cores at once, where each counts only if all of them do.

This process works on stretches, too, instead of waiting: that is one process less to start, which takes as
long as two thousand ticks of a replay.
"""

import gc
import pickle
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future
from functools import partial
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory
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
        work: What is done with one, in this or another process; returns None if it does not count.
        progress: How far it has come is told in it.
        take: Given what each came to, in order.

    Returns:
        Whether all count; False if one does not, the log is damaged, or a process or what it left is gone.
        What was taken until then counts for nothing.
    """
    try:
        with (
            TemporaryDirectory(prefix="bigant-stretches-") as folder,
            worker_pool(max(1, min(cores(), len(tasks)) - 1)) as pool,
        ):
            job, apart = partial(_worked, work), partial(_laid_down, work, Path(folder))
            waiting = {place: pool.submit(apart, task) for place, task in enumerate(tasks)}
            if not checksum_fits(path):
                raise DifferentError  # the pool is left at once
            for task, result in zip(tasks, _results(tasks, job, waiting), strict=True):
                take(result)
                progress.position = task.stretch.span[1]
                progress.tell()
    except (
        DifferentError,
        BrokenExecutor,
        OSError,
    ):  # the last: no place for files, or one is gone
        return False
    progress.position, progress.finished = progress.size, True
    return True


def _results(
    tasks: Sequence[T], work: Callable[[T], R | None], waiting: "dict[int, Future[R | Path | None]]"
) -> Iterator[R]:
    """Yield results in order; while the next one is not there, work on the first that nobody has begun.

    Args:
        tasks: The tasks.
        work: What is done with one.
        waiting: The results to come, by the place of their task; each is let go as it is read.

    Raises:
        DifferentError: One does not count.
    """
    own: dict[int, R] = {}
    for place in range(len(tasks)):
        while place in waiting and not waiting[place].done():
            other = next((k for k, future in waiting.items() if future.cancel()), None)
            if other is None:
                break
            del waiting[other]
            own[other] = _counting(work(tasks[other]))
        yield own.pop(place) if place in own else _taken_up(waiting.pop(place).result())


def _laid_down(work: Callable[[T], R | None], folder: Path, task: T) -> R | Path | None:
    """Work on a stretch in another process, and leave in a file what it came to.

    Through a pipe megabytes would come in small pieces, for each of which both processes interrupt what
    they compute.
    """
    result = _worked(work, task)
    if result is None:
        return None
    try:
        with NamedTemporaryFile(dir=folder, delete=False) as file:
            pickle.dump(result, file, protocol=pickle.HIGHEST_PROTOCOL)
    except OSError:  # no room: it has to go through the pipe
        return result
    return Path(file.name)


def _taken_up(result: R | Path | None) -> R:
    """What a stretch came to; its file is not needed any more."""
    if not isinstance(result, Path):
        return _counting(result)
    with result.open("rb") as file:
        stretch: R = pickle.load(file)  # our own process wrote it a moment ago
    result.unlink()
    return stretch


def _worked(work: Callable[[T], R | None], task: T) -> R | None:
    """Work on a stretch without collections of garbage.

    Ticks leave no cycles behind, and each collection looks through all that a process has loaded: a
    twentieth of the time.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        return work(task)
    finally:
        if collects:
            gc.enable()


def _counting(result: R | None) -> R:
    if result is None:
        raise DifferentError
    return result
