"""Predictions on processes of this computer, which inherit the simulator and the trials.

Only indices and causes travel; answers come back through memory that all processes share, because to send
half a megabyte through a pipe takes as long as to predict it.
"""

import mmap
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from queue import SimpleQueue

import numpy as np

from gap.interfaces import Cause, DataFault, Drive, Simulator
from gap.worker_pool import worker_pool
from model.errors import GapError
from model.values.arrays import FloatArray, readonly
from record.trial.trial import Trial

LANES = 2  # calls at a time: while one waits for predictions, another works on what it got
SLOTS = 48  # answers of a call that shared memory has room for
CHUNKS = 4  # of a call for each worker: the last one should not be waited for long
NUMBER_BYTES = 8
Shape = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class PredictionRequest:
    """One prediction: of a trial by its index, with causes added, under a drive."""

    trial: int
    causes: tuple[Cause, ...]
    drive: Drive


@dataclass(frozen=True, slots=True)
class _Shared:
    """What every process has: the simulator, trials, and slots for answers of so many numbers."""

    simulator: Simulator
    trials: tuple[Trial, ...]
    memory: mmap.mmap
    slot_numbers: int

    def slot(self, number: int, shape: Shape) -> FloatArray:
        """Return the room for an answer."""
        start = number * self.slot_numbers * NUMBER_BYTES
        count = int(np.prod(shape))
        return np.frombuffer(self.memory, np.float64, count, start).reshape(shape)


_installed: list[_Shared] = []


def _install(shared: _Shared) -> None:
    _installed[:] = [shared]


def _started() -> None:
    """Take the first task, with which processes begin."""


def _predict_into_slots(
    first: int, requests: Sequence[PredictionRequest]
) -> list[Shape | FloatArray]:
    """Predict into slots from the first on; return shapes, or an answer itself that has no room there."""
    shared = _installed[0]
    sent: list[Shape | FloatArray] = []
    for number, one in enumerate(requests, first):
        answer = shared.simulator.predict(shared.trials[one.trial], one.causes, one.drive)
        if answer.size > shared.slot_numbers:
            sent.append(answer)
        else:
            shared.slot(number, answer.shape)[...] = answer
            sent.append(answer.shape)
    return sent


def _check(trial: int) -> tuple[DataFault, ...]:
    shared = _installed[0]
    return shared.simulator.check(shared.trials[trial])


@dataclass(frozen=True, slots=True)
class PooledPredictions:
    """Where predictions are made, if not here: so many processes."""

    executor: Executor
    workers: int
    shared: _Shared
    lanes: SimpleQueue[int]

    @property
    def at_once(self) -> int:
        """How many calls may be made at a time, by threads."""
        return LANES

    def predict(self, requests: Sequence[PredictionRequest]) -> list[FloatArray]:
        """Return (F, C) for each.

        Raises:
            GapError: One cannot be predicted.
        """
        # a process that stays with a trial finds more of what it has solved before
        order = sorted(range(len(requests)), key=lambda i: requests[i].trial)
        answers: dict[int, FloatArray] = {}
        lane = self.lanes.get()
        try:
            for at in range(0, len(order), SLOTS):
                answers |= self._round(requests, order[at : at + SLOTS], lane * SLOTS)
        finally:
            self.lanes.put(lane)
        return [answers[i] for i in range(len(requests))]

    def check(self, trials: Sequence[int]) -> Iterator[tuple[DataFault, ...]]:
        """Return what is wrong with the data of each trial, as it is known; this one need not wait."""
        return self.executor.map(_check, trials)

    def _round(
        self, requests: Sequence[PredictionRequest], order: Sequence[int], first: int
    ) -> dict[int, FloatArray]:
        """Predict as many as there are slots in a lane; ``first`` is the number of its first slot."""
        size = -(-len(order) // (CHUNKS * self.workers))
        firsts = range(first, first + len(order), size)
        asked = [[requests[i] for i in order[at : at + size]] for at in range(0, len(order), size)]
        sent = [
            one for some in self.executor.map(_predict_into_slots, firsts, asked) for one in some
        ]
        return {
            i: one
            if isinstance(one, np.ndarray)
            else readonly(self.shared.slot(number, one).copy())
            for number, (i, one) in enumerate(zip(order, sent, strict=True), first)
        }


@contextmanager
def prediction_pool(
    simulator: Simulator, trials: Sequence[Trial], references: Sequence[Trial], workers: int
) -> Iterator[PooledPredictions]:
    """Start processes that predict; to be given to ``diagnose`` as its executor.

    Raises:
        GapError: ``workers`` is not positive.
    """
    if workers < 1:
        raise GapError(f"at least one worker process is needed, not {workers}")
    every = (*trials, *references)
    longest = max((len(trial.time_s) for trial in every), default=1)
    numbers = max(1, longest * len(simulator.channels))
    # nobody's file: it goes with the last process that has it
    memory = mmap.mmap(-1, LANES * SLOTS * numbers * NUMBER_BYTES)
    shared = _Shared(simulator, every, memory, numbers)
    lanes: SimpleQueue[int] = SimpleQueue()
    for lane in range(LANES):
        lanes.put(lane)
    with worker_pool(workers, partial(_install, shared), inherit=True) as pool:
        pool.submit(_started).result()  # forks them all: this process has no other threads yet
        yield PooledPredictions(pool, workers, shared, lanes)
