"""Predictions on the workers of a cluster: each makes the simulator once, and predicts batch by batch.

A simulator is not sent: it holds compiled models and what it remembers. What makes it is sent once, and
then only indices and causes.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, Future, wait
from dataclasses import dataclass
from threading import Lock
from typing import Any, Protocol, TypeVar

from gap.delegate import many_of
from gap.interfaces import Cause, DataFault, Drive, Simulator
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial

BATCHES = (
    2  # of one call for each worker: few, because candidates in a batch may share a simulation
)
WATCH_S = 5.0  # how often it is looked whether there is still a worker
LOST = (
    "the cluster lost all its workers in the middle of the diagnosis; start workers and try again"
)

Answer = TypeVar("Answer")
Made = tuple[Simulator, tuple[Trial, ...]]


class Prediction(Protocol):
    """What is asked: a trial by its index, causes, and what feeds the stages."""

    @property
    def trial(self) -> int:
        """Number of the trial."""

    @property
    def causes(self) -> tuple[Cause, ...]:
        """Causes that are added."""

    @property
    def drive(self) -> Drive:
        """What feeds the stages."""


class Installation:
    """What every worker gets once; the first call there makes the simulator, one call at a time uses it.

    Args:
        make: Makes the simulator and the trials, in the order of the indices. It is pickled.
    """

    def __init__(self, make: Callable[[], Made]) -> None:
        self._make = make
        self._lock = Lock()
        self._made: Made | None = None

    def __reduce__(self) -> tuple[type["Installation"], tuple[Callable[[], Made]]]:
        """Travel as what makes it."""
        return Installation, (self._make,)

    def predict(self, requests: Sequence[Prediction]) -> list[FloatArray]:
        """Return (F, C) for each."""
        with self._lock:
            simulator, trials = self._ready()
            asked = [(trials[one.trial], one.causes, one.drive) for one in requests]
            many = many_of(simulator)
            return many(asked) if many else [simulator.predict(*one) for one in asked]

    def check(self, trial: int) -> tuple[DataFault, ...]:
        """Return what is wrong with the data of a trial."""
        with self._lock:
            simulator, trials = self._ready()
            return simulator.check(trials[trial])

    def _ready(self) -> Made:
        self._made = self._made or self._make()
        return self._made


@dataclass(frozen=True, slots=True)
class ClusterPredictions:
    """Where predictions are made, if not here.

    Attributes:
        executor: Of the cluster.
        installed: The ``Installation``, or the cluster's own reference to it.
        workers: Returns how many workers there are now.
    """

    executor: Executor
    installed: Any
    workers: Callable[[], int]

    @property
    def at_once(self) -> int:
        """How many calls may be made at a time, by threads."""
        return 1

    def predict(self, requests: Sequence[Prediction]) -> list[FloatArray]:
        """Return (F, C) for each.

        Raises:
            GapError: No worker is left, or one cannot predict.
        """
        size = -(-len(requests) // max(1, BATCHES * self.workers()))
        batches = [requests[at : at + size] for at in range(0, len(requests), size)]
        futures = [self.executor.submit(_predict, self.installed, batch) for batch in batches]
        try:
            return [one for future in futures for one in self._result(future)]
        except BaseException:
            for future in futures:
                future.cancel()
            raise

    def check(self, trials: Sequence[int]) -> Iterator[tuple[DataFault, ...]]:
        """Return what is wrong with the data of each trial, as it is known.

        Raises:
            GapError: No worker is left.
        """
        futures = [self.executor.submit(_check, self.installed, trial) for trial in trials]
        return map(self._result, futures)

    def _result(self, future: "Future[Answer]") -> Answer:
        while not wait([future], timeout=WATCH_S).done:
            if not self.workers():
                raise GapError(LOST)
        try:
            return future.result()
        except CancelledError as error:
            raise GapError(LOST) from error


def _predict(installed: Installation, requests: Sequence[Prediction]) -> list[FloatArray]:
    return installed.predict(requests)


def _check(installed: Installation, trial: int) -> tuple[DataFault, ...]:
    return installed.check(trial)
