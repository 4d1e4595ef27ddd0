"""Levenberg-Marquardt on the robust score with a prior and bounds.

Written out here because the loss acts on blocks, not on single residuals, and because the Jacobian at the
end is what cross-validation needs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap.interfaces import Cause, Effect, Parameter
from gap.residuals.evidence import Evidence
from gap.search.candidates import FINE_STEP, step_of
from model.values.arrays import FloatArray

ROUNDS = 8
ENOUGH_NATS = 0.05
ENOUGH_SHARE = 1e-4
DAMPING = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Causes with fitted values.

    Attributes:
        causes: The causes.
        residual: Whitened, (F, C).
        slopes: Change of the prediction for one spread of each of P parameters, (P, F, C).
        away: Distance from neutral in spreads, (P,).
        nats: Score and prior together.
    """

    causes: tuple[Cause, ...]
    residual: FloatArray
    slopes: FloatArray
    away: FloatArray
    nats: float


@dataclass(frozen=True, slots=True)
class _Free:
    cause: int
    place: int
    parameter: Parameter


def fit_causes(
    evidence: Evidence,
    start: Sequence[Cause],
    effects: Mapping[str, Effect],
    rounds: int = ROUNDS,
) -> Fitted:
    """Fit the values of causes together.

    Args:
        evidence: What to fit to.
        start: Causes with the values to begin from.
        effects: The catalogue by name.
        rounds: Most steps.
    """
    free = [
        _Free(i, k, p)
        for i, cause in enumerate(start)
        for k, p in enumerate(effects[cause.effect].parameters)
    ]
    causes = tuple(start)
    residual = evidence.residuals([causes])[0]
    nats = _nats(evidence, residual, _away(causes, free))
    damping = DAMPING
    slopes = _slopes(evidence, causes, free, residual)
    for _ in range(rounds if free else 0):
        weights = evidence.weights(residual)
        weighted = slopes * weights
        gram = np.einsum("pfc,qfc->pq", weighted, slopes) + np.eye(len(free))
        pull = np.einsum("pfc,fc->p", weighted, residual) - _away(causes, free)
        better = False
        for _ in range(4):
            step = np.linalg.solve(gram + damping * np.diag(np.diag(gram)), pull)
            trial = _stepped(causes, free, step)
            if trial == causes:
                break
            found = evidence.residuals([trial])[0]
            reached = _nats(evidence, found, _away(trial, free))
            if reached < nats:
                better = True
                break
            damping = max(damping * 30, 0.1)
        if not better:
            break
        gained = nats - reached
        causes, residual, nats, damping = trial, found, reached, damping / 10
        slopes = _slopes(evidence, causes, free, residual)
        if gained < ENOUGH_NATS + ENOUGH_SHARE * abs(nats):
            break
    return Fitted(causes, residual, slopes, _away(causes, free), nats)


def _nats(evidence: Evidence, residual: FloatArray, away: FloatArray) -> float:
    return float(evidence.score(residual).sum() + 0.5 * away @ away)


def _away(causes: tuple[Cause, ...], free: Sequence[_Free]) -> FloatArray:
    return np.array(
        [(causes[f.cause].values[f.place] - f.parameter.neutral) / f.parameter.spread for f in free]
    )


def _stepped(
    causes: tuple[Cause, ...], free: Sequence[_Free], step: FloatArray
) -> tuple[Cause, ...]:
    values = [list(cause.values) for cause in causes]
    for f, size in zip(free, step, strict=True):
        moved = values[f.cause][f.place] + size * f.parameter.spread
        values[f.cause][f.place] = float(np.clip(moved, f.parameter.lower, f.parameter.upper))
    return tuple(
        Cause(cause.effect, cause.joints, tuple(v)) for cause, v in zip(causes, values, strict=True)
    )


def _slopes(
    evidence: Evidence, causes: tuple[Cause, ...], free: Sequence[_Free], residual: FloatArray
) -> FloatArray:
    steps = [step_of(f.parameter, causes[f.cause].values[f.place], FINE_STEP) for f in free]
    moved = []
    for i, (f, step) in enumerate(zip(free, steps, strict=True)):
        unit = np.zeros(len(free))
        unit[i] = step / f.parameter.spread
        moved.append(_stepped(causes, free, unit))
    found = evidence.residuals(moved) if moved else []
    slopes = np.zeros((len(free), *residual.shape))
    for i, (f, step, there) in enumerate(zip(free, steps, found, strict=True)):
        slopes[i] = (residual - there) * (f.parameter.spread / step)
    return slopes
