"""The one descent of the diagnosis: Gauss-Newton steps on the values of causes, within their bounds.

Fits to trials are damped (Levenberg-Marquardt) and pay a prior; an alternative that imitates other causes
takes plain steps. Written out because the loss of a fit to trials acts on blocks, not on single residuals,
and because the Jacobian at the end is what cross-validation needs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.interfaces import Cause, Effect, Parameter
from gap.residuals.predictions import Misfit
from gap.search.candidates import FINE_STEP, fine_step
from model.values.arrays import FloatArray

ROUNDS = 8
# Energy between two predictions from which a likelihood-ratio choice errs once in a hundred times.
ENOUGH_SEPARATION = 4 * 2.33**2


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Causes with fitted values.

    Attributes:
        residual: Whitened, (F, C).
        slopes: Change of the prediction for one spread of each of P parameters, (P, F, C).
        away: Distance from neutral in spreads, (P,).
        nats: Score and prior together.
        stuck: Whether the descent ended with shortened steps, or still gained at its last.
    """

    causes: tuple[Cause, ...]
    residual: FloatArray
    slopes: FloatArray
    away: FloatArray
    nats: float
    stuck: bool = False


@dataclass(frozen=True, slots=True)
class Free:
    """A value that is fitted: that of a parameter, at a place in a cause's values."""

    cause: int
    place: int
    parameter: Parameter


@dataclass(frozen=True, slots=True)
class Rules:
    """How a descent steps.

    Attributes:
        shares: Of the step, tried one behind the other until one is good enough.
        damping: At the first try, as a share of the curvature; 30 times as much after one that failed, a
            tenth after one that was taken.
        least_damping: The least after one that failed.
        worth: A try is taken where the misfit falls below this share of what it was.
        enough_nats: A step that gains less, and
        enough_share: less than this share of the misfit, is the last.
        prior: Whether values away from neutral cost: half a nat at one spread.
        difference: Over which share of a spread slopes are taken.
    """

    shares: tuple[float, ...]
    damping: float
    least_damping: float
    worth: float
    enough_nats: float
    enough_share: float
    prior: bool
    difference: float = FINE_STEP


DAMPED = Rules((1.0,) * 4, 1e-3, 0.1, 1.0, 0.05, 1e-4, prior=True)
PLAIN = Rules((1.0, 0.3), 0.0, 0.0, 0.999, 0.0, 0.0, prior=False)


def fit_causes(
    misfit: Misfit,
    start: Sequence[Cause],
    rounds: int = ROUNDS,
    rules: Rules = DAMPED,
    only: int | None = None,
    near: Fitted | None = None,
) -> Fitted:
    """Fit the values of causes together.

    Slopes are what costs most. Those of the last step stay where it changed next to nothing.

    Args:
        misfit: What to make small.
        start: Causes with the values to begin from.
        rounds: Most steps.
        rules: How to step.
        only: Number of the one cause whose values are fitted; None fits all.
        near: A fit of some of these causes, whose slopes are good enough for the first step.
    """
    free = free_values(start, misfit.effects, only)

    def nats_of(residual: FloatArray, away: FloatArray) -> float:
        return float(misfit.score(residual).sum() + rules.prior * 0.5 * away @ away)

    causes = tuple(start)
    residual, away = misfit.residuals([causes])[0], _away(causes, free)
    nats, damping = nats_of(residual, away), rules.damping
    borrowed = _borrowed(near, causes, free, misfit.effects)
    slopes = slopes_of(misfit, causes, free, residual, rules.difference, borrowed)
    stuck = True
    for _ in range(rounds if free else 0):
        weighted = slopes * misfit.weights(residual)
        gram = np.einsum("pfc,qfc->pq", weighted, slopes) + np.eye(len(free))
        pull = np.einsum("pfc,fc->p", weighted, residual) - rules.prior * away
        better, shortened = False, False
        for share in rules.shares:
            step = share * np.linalg.solve(gram + damping * np.diag(np.diag(gram)), pull)
            trial = moved(causes, free, step)
            if trial == causes:
                break
            there, far = misfit.residuals([trial])[0], _away(trial, free)
            reached = nats_of(there, far)
            better = reached < rules.worth * nats
            if better:
                break
            damping, shortened = max(damping * 30, rules.least_damping), True
        last = True
        if better:
            last = nats - reached < rules.enough_nats + rules.enough_share * abs(reached)
            causes, residual, away, nats, damping = trial, there, far, reached, damping / 10
        if last and not borrowed:
            stuck = shortened
            break
        if not better:
            damping = rules.damping  # its own slopes may lead farther
        slopes, borrowed = slopes_of(misfit, causes, free, residual, rules.difference), {}
    return Fitted(causes, residual, slopes, away, nats, stuck and len(free) > 0)


def _borrowed(
    near: Fitted | None,
    causes: tuple[Cause, ...],
    free: Sequence[Free],
    effects: Mapping[str, Effect],
) -> dict[int, FloatArray]:
    """Slopes that a fit of some of these causes has already, by the number of the free value."""
    if near is None:
        return {}
    known = {
        (near.causes[one.cause].effect, near.causes[one.cause].joints, one.place): slopes
        for one, slopes in zip(free_values(near.causes, effects), near.slopes, strict=True)
    }
    keys = [(causes[one.cause].effect, causes[one.cause].joints, one.place) for one in free]
    return {number: known[key] for number, key in enumerate(keys) if key in known}


def free_values(
    causes: Sequence[Cause], effects: Mapping[str, Effect], only: int | None = None
) -> tuple[Free, ...]:
    """Return the values of causes, or of the one that is named, in their order."""
    return tuple(
        Free(i, k, p)
        for i, cause in enumerate(causes)
        if only is None or i == only
        for k, p in enumerate(effects[cause.effect].parameters)
    )


def moved(
    causes: tuple[Cause, ...], free: Sequence[Free], step: Sequence[float] | FloatArray
) -> tuple[Cause, ...]:
    """Return causes with free values moved by so many spreads, kept within their bounds."""
    values = [list(cause.values) for cause in causes]
    for f, size in zip(free, step, strict=True):
        value = values[f.cause][f.place] + size * f.parameter.spread
        values[f.cause][f.place] = float(np.clip(value, f.parameter.lower, f.parameter.upper))
    return tuple(replace(c, values=tuple(v)) for c, v in zip(causes, values, strict=True))


def _away(causes: tuple[Cause, ...], free: Sequence[Free]) -> FloatArray:
    return np.array(
        [(causes[f.cause].values[f.place] - f.parameter.neutral) / f.parameter.spread for f in free]
    )


def slopes_of(
    misfit: Misfit,
    causes: tuple[Cause, ...],
    free: Sequence[Free],
    residual: FloatArray,
    share: float = FINE_STEP,
    known: Mapping[int, FloatArray] = {},
) -> FloatArray:
    """Return the change of the prediction for one spread of each free value, (P, F, ...).

    Args:
        misfit: Predicts.
        causes: Causes about which it is differenced.
        free: P of their values.
        residual: Residual with the causes, (F, ...).
        share: Of a spread, by which a value is moved that is no limit.
        known: Slopes that are there already, by the number of the free value.
    """
    steps = np.array([
        fine_step(f.parameter, causes[f.cause].values[f.place], share) / f.parameter.spread
        for f in free
    ])  # fmt: skip
    wanted = [i for i in range(len(free)) if i not in known]
    sets = [moved(causes, free, row) for row in np.diag(steps)[wanted]] if wanted else []
    slopes = np.zeros((len(free), *residual.shape))
    for i, slope in known.items():
        slopes[i] = slope
    for i, there in zip(wanted, misfit.residuals(sets) if sets else [], strict=True):
        slopes[i] = (residual - there) / steps[i]
    return slopes


def energy_left(residual: FloatArray, slopes: FloatArray, prior: float = 0.0) -> float:
    """Return the energy of a residual that is left when values are adjusted to first order.

    Args:
        residual: What is to be explained, (F, ...).
        slopes: What one spread of each of P values changes, (P, F, ...).
        prior: Energy that a value costs one spread away.
    """
    return least_squares(residual, slopes, prior)[1]


def least_squares(
    residual: FloatArray, slopes: FloatArray, prior: float = 0.0
) -> tuple[FloatArray, float]:
    """Return the step of each value, (P,) [spreads], that leaves the least energy, and that energy.

    The arguments are those of ``energy_left``.
    """
    size = len(slopes)
    rows = np.vstack([slopes.reshape(size, residual.size).T, np.sqrt(prior) * np.eye(size)])
    goal = np.append(residual.ravel(), np.zeros(size))
    step = np.linalg.lstsq(rows, goal, rcond=None)[0] if size else np.zeros(0)
    left = goal - rows @ step if size else goal
    return step, float(left @ left)
