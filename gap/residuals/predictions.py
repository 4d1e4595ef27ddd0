"""What a simulator predicts for many sets of causes, in this process or on several, and what a fit costs.

A pool is made by ``prediction_pool``: its workers inherit the simulator and the trials, so that only
indices and causes travel.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from gap.delegate import many_of
from gap.interfaces import Cause, Drive, Effect, Simulator
from gap.residuals.cluster import ClusterPredictions
from gap.worker_pool import worker_pool
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial

REMEMBERED = 64
CHUNKS = 8  # into which a batch is cut for other processes
_installed: list[tuple[Simulator, tuple[Trial, ...]]] = []


@dataclass(frozen=True, slots=True)
class PredictionRequest:
    """One prediction: of a trial by its index, with causes added, under a drive."""

    trial: int
    causes: tuple[Cause, ...]
    drive: Drive


def prediction_pool(
    simulator: Simulator, trials: Sequence[Trial], references: Sequence[Trial], workers: int
) -> AbstractContextManager[Executor]:
    """Start processes that predict; to be given to ``diagnose`` as its executor."""
    return worker_pool(workers, partial(_install, simulator, (*trials, *references)), inherit=True)


def _install(simulator: Simulator, trials: tuple[Trial, ...]) -> None:
    _installed[:] = [(simulator, trials)]


def _predict_installed(request: PredictionRequest) -> FloatArray:
    if not _installed:
        raise GapError(
            "the executor knows no simulator; make it with gap.residuals.predictions.prediction_pool"
        )
    simulator, trials = _installed[0]
    return simulator.predict(trials[request.trial], request.causes, request.drive)


class Predictor:
    """Predicts, and remembers the latest answers.

    Args:
        simulator: The simulator.
        trials: Trials and then references, in the order of ``prediction_pool``.
        executor: Made by ``prediction_pool``, or a cluster; None predicts here.
        standing: Causes that every prediction has.
    """

    def __init__(
        self,
        simulator: Simulator,
        trials: Sequence[Trial],
        executor: Executor | ClusterPredictions | None = None,
        standing: tuple[Cause, ...] = (),
    ) -> None:
        self.simulator, self.trials, self.standing = simulator, tuple(trials), standing
        self.count = 0
        self._executor = executor
        self._known: dict[PredictionRequest, FloatArray] = {}

    def with_standing(self, standing: tuple[Cause, ...]) -> "Predictor":
        """Return the same with these causes behind those that stand."""
        return Predictor(self.simulator, self.trials, self._executor, (*self.standing, *standing))

    def predict(self, requests: Sequence[PredictionRequest]) -> list[FloatArray]:
        """Return (F, C) for each."""
        fresh = list(dict.fromkeys(one for one in requests if one not in self._known))
        whole = [replace(one, causes=(*self.standing, *one.causes)) for one in fresh]
        many = many_of(self.simulator)
        if isinstance(self._executor, ClusterPredictions) and len(whole) > 1:
            predicted = self._executor.predict(whole)
        elif many is not None:
            predicted = many([(self.trials[w.trial], w.causes, w.drive) for w in whole])
        elif not isinstance(self._executor, Executor) or len(fresh) == 1:
            predicted = [
                self.simulator.predict(self.trials[w.trial], w.causes, w.drive) for w in whole
            ]
        else:
            chunk = max(1, len(whole) // CHUNKS)
            predicted = list(self._executor.map(_predict_installed, whole, chunksize=chunk))
        self.count += len(fresh)
        answers = self._known | dict(zip(fresh, predicted, strict=True))
        self._known = dict(list(answers.items())[-REMEMBERED:])
        return [answers[one] for one in requests]


@dataclass(frozen=True)
class Misfit:
    """Plain squares of a residual; subclasses say which, and may weigh it."""

    predictor: Predictor

    @property
    def simulator(self) -> Simulator:
        """The simulator whose effects are fitted."""
        return self.predictor.simulator

    @cached_property
    def effects(self) -> dict[str, Effect]:
        """Its catalogue by name."""
        return {effect.name: effect for effect in self.simulator.effects}

    def residuals(self, sets: Sequence[tuple[Cause, ...]]) -> list[FloatArray]:
        """Return the residual with each set of causes, (F, C)."""
        raise NotImplementedError

    def score(self, residual: FloatArray) -> FloatArray:
        """Return the cost of parts of a residual in nats; a fit makes their sum small."""
        return 0.5 * residual**2

    def weights(self, residual: FloatArray) -> FloatArray:
        """Return the weight of each value in a quadratic that is tangent to the score, (F, C)."""
        return np.ones(residual.shape)
