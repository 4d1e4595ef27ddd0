"""The model over many frames on several processes, through shared memory.

Frames do not depend on each other, so each process takes a run of them; feet and answers lie in memory
that all of them see, and nothing but the ends of the runs goes through pipes.
"""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing import get_context
from multiprocessing.shared_memory import SharedMemory
from types import TracebackType
from typing import Self

import numpy as np

from model.errors import ModelError
from model.frames import FrameSolutions, FrictionLaw
from model.frames_kernel import frames_kernel
from model.params import ContactParameters
from model.signals import FloatArray, FootMotion

# name, type and numbers a frame and a foot of each output, in the kernel's order
OUTPUTS = (
    ("pose", np.float64, 3, 0),
    ("load_n", np.float64, 0, 1),
    ("switches", np.int64, 1, 0),
    ("velocity_B", np.float64, 3, 0),
    ("slip_B", np.float64, 0, 2),
    ("force_xy_B", np.float64, 0, 2),
    ("sticking", np.bool_, 0, 1),
    ("unique", np.bool_, 1, 0),
    ("reason", np.int64, 1, 0),
)


@dataclass(frozen=True, slots=True)
class _Job:
    """A run of frames for one process."""

    memory: str
    frames: int
    legs: int
    first: int
    last: int
    contact: ContactParameters
    weight_n: float
    coulomb: bool


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
        # a fresh interpreter each: forking a program with threads is asking for trouble
        self._pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"))

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
        """End the processes."""
        self._pool.shutdown()

    def solve(
        self,
        feet: FootMotion,
        contact: ContactParameters,
        weight_n: float,
        *,
        law: FrictionLaw = FrictionLaw.VISCOUS,
    ) -> FrameSolutions:
        """Do what ``model.frames.solve_frames`` does, on level ground, for parameters known to be good.

        Args:
            feet: (F, N, 3) each [m], [m/s].
            contact: Of the N legs.
            weight_n: [N].
            law: Friction law.
        """
        frames, legs, _ = feet.position_m.shape
        size = sum(
            np.dtype(kind).itemsize * shape_size for _, kind, shape_size in _sizes(frames, legs)
        )
        memory = SharedMemory(create=True, size=size + 128)
        try:
            given, _ = _arrays(memory, frames, legs)
            given[0][:] = feet.position_m
            given[1][:] = feet.velocity_m_s
            ends = np.linspace(0, frames, self.count + 1).astype(int).tolist()
            jobs = [
                _Job(memory.name, frames, legs, first, last, contact, weight_n,
                     law is FrictionLaw.COULOMB)
                for first, last in pairwise(ends)
            ]  # fmt: skip
            list(self._pool.map(_run, jobs))
            _, found = _arrays(memory, frames, legs)
            answer = FrameSolutions(*(values.copy() for values in found))
            del given, found
        finally:
            memory.close()
            memory.unlink()
        return answer


def _sizes(frames: int, legs: int) -> list[tuple[tuple[int, ...], type, int]]:
    shapes: list[tuple[tuple[int, ...], type]] = [((frames, legs, 3), np.float64)] * 2
    for _, kind, per_frame, per_foot in OUTPUTS:
        if per_foot:
            shape: tuple[int, ...] = (frames, legs) if per_foot == 1 else (frames, legs, per_foot)
        else:
            shape = (frames,) if per_frame == 1 else (frames, per_frame)
        shapes.append((shape, kind))
    return [(shape, kind, int(np.prod(shape))) for shape, kind in shapes]


def _arrays(
    memory: SharedMemory, frames: int, legs: int
) -> tuple[list[FloatArray], list[np.ndarray]]:
    """Inputs and outputs as views of the shared memory."""
    views = []
    start = 0
    for shape, kind, size in _sizes(frames, legs):
        views.append(np.ndarray(shape, kind, memory.buf, start))
        start += np.dtype(kind).itemsize * size
        start += -start % 8
    return views[:2], views[2:]


def _run(job: _Job) -> None:
    memory = SharedMemory(job.memory)
    try:
        _solve(job, memory)
    finally:
        memory.close()


def _solve(job: _Job, memory: SharedMemory) -> None:
    given, found = _arrays(memory, job.frames, job.legs)
    part = slice(job.first, job.last)
    contact = job.contact
    frames_kernel(
        given[0][part],
        given[1][part],
        np.zeros((job.last - job.first, job.legs)),
        np.array(contact.stiffness),
        np.array(contact.mu),
        np.array(contact.anisotropy[None]),
        float(job.weight_n),
        job.coulomb,
        False,
        *(values[part] for values in found),
    )
