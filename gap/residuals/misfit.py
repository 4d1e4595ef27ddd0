"""What a fit makes small: a residual with each set of causes, and what it costs."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gap.interfaces import Cause, Effect, Simulator
from gap.residuals.predictions import Predictor
from model.values.arrays import FloatArray


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
