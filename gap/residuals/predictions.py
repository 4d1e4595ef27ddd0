"""What a simulator predicts for many sets of causes, in this process or elsewhere, and what a fit costs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from threading import Lock
from typing import Protocol

import numpy as np

from gap.delegate import many_of
from gap.interfaces import Cause, DataFault, Effect, Simulator
from gap.residuals.pool import PredictionRequest
from model.values.arrays import FloatArray
from record.trial.trial import Trial

REMEMBERED = 64


class PredictsElsewhere(Protocol):
    """Predicts the trials by their indices, on other processes or computers."""

    @property
    def at_once(self) -> int:
        """How many calls may be made at a time, by threads."""

    def predict(self, requests: Sequence[PredictionRequest], /) -> list[FloatArray]:
        """Return (F, C) for each."""

    def check(self, trials: Sequence[int], /) -> Iterator[tuple[DataFault, ...]]:
        """Return what is wrong with the data of each trial, as it is known."""


class Predictor:
    """Predicts, and remembers the latest answers.

    Args:
        simulator: The simulator.
        trials: Trials and then references, in the order of ``prediction_pool``.
        elsewhere: Made by ``prediction_pool``, or a cluster; None predicts here.
        standing: Causes that every prediction has.
    """

    def __init__(
        self,
        simulator: Simulator,
        trials: Sequence[Trial],
        elsewhere: PredictsElsewhere | None = None,
        standing: tuple[Cause, ...] = (),
    ) -> None:
        self.simulator, self.trials, self.standing = simulator, tuple(trials), standing
        self._asked: set[PredictionRequest] = set()
        self._elsewhere = elsewhere
        self._known: dict[PredictionRequest, FloatArray] = {}
        self._lock = Lock()

    @property
    def at_once(self) -> int:
        """How many calls may be made at a time, by threads; 1 where predictions are made here."""
        return 1 if self._elsewhere is None else self._elsewhere.at_once

    @property
    def count(self) -> int:
        """How many different predictions were asked for, whichever thread was first to ask."""
        return len(self._asked)

    def with_standing(self, standing: tuple[Cause, ...]) -> "Predictor":
        """Return the same with these causes behind those that stand."""
        return Predictor(self.simulator, self.trials, self._elsewhere, (*self.standing, *standing))

    def checked(self) -> Iterator[tuple[DataFault, ...]]:
        """Return what is wrong with the data of each trial, as it is known elsewhere, or at once."""
        if self._elsewhere is not None:
            return self._elsewhere.check(range(len(self.trials)))
        return iter([self.simulator.check(one) for one in self.trials])

    def predict(self, requests: Sequence[PredictionRequest]) -> list[FloatArray]:
        """Return (F, C) for each."""
        before = self._known  # never changed, only replaced
        fresh = list(dict.fromkeys(one for one in requests if one not in before))
        whole = [replace(one, causes=(*self.standing, *one.causes)) for one in fresh]
        many = many_of(self.simulator)
        # one alone is as soon made here, unless other threads predict: the simulator here is for one
        many_threads = self.at_once > 1
        if self._elsewhere is not None and whole and (len(whole) > 1 or many_threads):
            predicted = self._elsewhere.predict(whole)
        elif many is not None:
            predicted = many([(self.trials[w.trial], w.causes, w.drive) for w in whole])
        else:
            predicted = [
                self.simulator.predict(self.trials[w.trial], w.causes, w.drive) for w in whole
            ]
        made = dict(zip(fresh, predicted, strict=True))
        with self._lock:
            self._asked.update(fresh)
            self._known = dict(list((self._known | made).items())[-REMEMBERED:])
        return [made[one] if one in made else before[one] for one in requests]


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
