"""The model over many frames on several processes, through shared memory.

Frames do not depend on each other, so each process takes a run of them. Feet and answers lie in memory
that all of them see; nothing but the ends of the runs goes through pipes.
"""

import contextlib
import shutil
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from gap.worker_pool import worker_pool
from model.errors import ModelError
from model.quasistatic.frames import FrameSolutions, FrictionLaw, solve_frames
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters

ALIGNMENT = 64
SHARED = Path("/dev/shm")


class SharedFrames:
    """Room for frames in memory that other processes see; to be filled, solved and read in place.

    Args:
        frames: Number of frames F.
        legs: Number of legs N.
        name: Attach to a room that another process made.

    Attributes:
        feet: To be filled in place, (F, N, 3) each [m], [m/s].
        answer: Written by ``ModelProcesses.solve``.

    Raises:
        ModelError: There is not enough shared memory.
    """

    def __init__(self, frames: int, legs: int, name: str | None = None) -> None:
        self.frames, self.legs = frames, legs
        self._made = name is None
        places = ((frames, legs, 3), np.float64)
        rows = (places, places, *_layout(frames, legs))
        size = sum(_bytes(shape, kind) for shape, kind in rows)
        if self._made and SHARED.is_dir() and size > shutil.disk_usage(SHARED).free:
            raise ModelError(
                f"{size / 1e6:.0f} MB of shared memory cannot be had; solve fewer frames at a time"
            )
        self._memory = SharedMemory(name, create=self._made, size=size if self._made else 0)
        views: list[NDArray[Any]] = []
        start = 0
        for shape, kind in rows:
            views.append(np.ndarray(shape, kind, self._memory.buf, start))
            start += _bytes(shape, kind)
        self.feet = FootMotion(*views[:2])
        self.answer = FrameSolutions(*views[2:])

    @property
    def name(self) -> str:
        """What other processes attach by."""
        return self._memory.name

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Give the memory back; ``feet`` and ``answer`` are gone then."""
        del self.feet, self.answer
        if self._made:
            self._memory.unlink()
        with contextlib.suppress(BufferError):  # somebody still looks at an array: freed with it
            self._memory.close()


@dataclass(frozen=True, slots=True)
class _Job:
    """A run of frames for one process."""

    name: str
    frames: int
    legs: int
    first: int
    last: int
    contact: ContactParameters
    weight_n: float
    law: FrictionLaw


class ModelProcesses:
    """Worker processes that keep their machine code and wait for frames.

    Args:
        count: Number of processes.

    Raises:
        ModelError: ``count`` is not positive.
    """

    def __init__(self, count: int) -> None:
        if count < 1:
            raise ModelError(f"at least one process is needed, not {count}")
        self.count = count
        self._workers: AbstractContextManager[Executor] = worker_pool(count)

    def __enter__(self) -> Self:
        self._pool = self._workers.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._workers.__exit__(kind, error, trace)

    def solve(
        self,
        room: SharedFrames,
        contact: ContactParameters,
        weight_n: float,
        *,
        law: FrictionLaw = FrictionLaw.VISCOUS,
    ) -> FrameSolutions:
        """Do what ``model.quasistatic.frames.solve_frames`` does, on level ground, with proper contacts.

        Args:
            room: Filled with feet.
            contact: Of the N legs.
            weight_n: [N].
            law: Friction law.

        Returns:
            ``room.answer``.
        """
        ends = np.linspace(0, room.frames, self.count + 1).astype(int).tolist()
        jobs = [
            _Job(room.name, room.frames, room.legs, first, last, contact, weight_n, law)
            for first, last in pairwise(ends)
        ]
        list(self._pool.map(_run, jobs))
        return room.answer


def _layout(frames: int, legs: int) -> tuple[tuple[tuple[int, ...], type], ...]:
    """Shape and type of each array of ``FrameSolutions``."""
    number, flag, integer = np.float64, np.bool_, np.int64
    per_foot = (frames, legs)
    return (
        ((frames, 3), number), (per_foot, number), ((frames,), integer),
        ((frames, 3), number), ((*per_foot, 2), number), ((*per_foot, 2), number),
        (per_foot, flag), ((frames,), flag), ((frames,), integer),
    )  # fmt: skip


def _bytes(shape: tuple[int, ...], kind: type) -> int:
    size = int(np.prod(shape)) * np.dtype(kind).itemsize
    return size + -size % ALIGNMENT


# The rooms that a worker knows, so that it attaches once to each.
_rooms: dict[str, SharedFrames] = {}


def _run(job: _Job) -> None:
    if job.name not in _rooms:
        for old in list(_rooms):
            _rooms.pop(old).close()
        _rooms[job.name] = SharedFrames(job.frames, job.legs, job.name)
    room, part = _rooms[job.name], slice(job.first, job.last)
    feet = FootMotion(room.feet.position_m[part], room.feet.velocity_m_s[part])
    answer = solve_frames(feet, job.contact, job.weight_n, law=job.law)
    for shared, values in zip(room.answer, answer, strict=True):
        shared[part] = values
