"""A case whose causes are known, and how they are drawn."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.check.cases import PAIR, Truth
from gap.interfaces import Cause, Effect, Scope, Simulator
from record.trial.trial import Trial

SINGLE_SIZES, PAIR_SIZES = (0.15, 1.5), (0.6, 2.0)  # of a cause, in spreads


@dataclass(frozen=True, slots=True, eq=False)
class KnownCase:
    """What is diagnosed, and what was wrong."""

    name: str
    kind: str
    truths: tuple[Truth, ...]
    simulator: Simulator
    trials: tuple[Trial, ...]
    references: tuple[Trial, ...]


def drawn(effect: Effect, joints: Sequence[str], kind: str, rng: np.random.Generator) -> Cause:
    """Return an effect at one of the joints and of a size, the small ones as often as the large ones."""
    smallest, largest = PAIR_SIZES if kind == PAIR else SINGLE_SIZES
    place = () if Scope.ALL in effect.scopes else (str(rng.choice(list(joints))),)
    values = []
    for one in effect.parameters:
        size = one.spread * smallest * (largest / smallest) ** rng.uniform()
        sign = 1.0 if one.lower >= one.neutral else rng.choice([-1.0, 1.0])
        values.append(rng.uniform(-0.3, 0.3) if one.located else one.neutral + sign * size)
    return Cause(effect.name, place, tuple(map(float, values)))


def truths_of(effects: Sequence[Effect], causes: Sequence[Cause]) -> tuple[Truth, ...]:
    """Return what was wrong, as a check takes it."""
    return tuple(
        Truth(
            cause.effect,
            effect.stage,
            "".join(cause.joints),
            tuple(effect.named(cause.values).items()),
        )
        for effect, cause in zip(effects, causes, strict=True)
    )
