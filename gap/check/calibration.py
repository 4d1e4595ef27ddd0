"""Constants of a probability, fitted on some realities and judged on one that was left out.

A probability here is logistic in what is known of a case: log odds = features @ constants. Where the
constants live and what they are called is the caller's affair: it hands over rows of features with their
outcomes, and the constants as they stand, from which few rows cannot lead far away.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, log_expit

from model.values.arrays import BoolArray, FloatArray

BINS = 10


@dataclass(frozen=True, slots=True, eq=False)
class CaseRows:
    """What is known of N cases, and how each turned out.

    Attributes:
        features: (N, K), with a column of ones where there is an offset.
        outcomes: Whether it is so, (N,).
    """

    features: FloatArray
    outcomes: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class ConstantPrior:
    """Constants as they stand.

    Attributes:
        names: K of them.
        values: (K,).
        spread: How far a fit may go from each, one standard deviation, (K,); 0 keeps it as it is.
        signs: The sign that each must keep, (K,); 0 for either.
    """

    names: tuple[str, ...]
    values: FloatArray
    spread: FloatArray
    signs: FloatArray


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A reality judged by constants that have not seen it.

    Attributes:
        cases: Its rows.
        error: Its calibration error with constants fitted on the others.
        error_now: The same with the constants as they stand.
        loss: Mean negative log likelihood of its outcomes with the fitted ones [nats].
        loss_now: The same as they stand.
        constants: The fitted ones, by name.
    """

    name: str
    cases: int
    error: float
    error_now: float
    loss: float
    loss_now: float
    constants: tuple[tuple[str, float], ...]


def fit_constants(rows: CaseRows, prior: ConstantPrior) -> FloatArray:
    """Return the constants of greatest posterior density, (K,): a normal prior about those that stand.

    Convex, so that there is one answer; without rows it is the constants as they stand.
    """
    free = prior.spread > 0
    scale = np.where(free, prior.spread, 1.0)

    def cost(moved: FloatArray) -> tuple[float, FloatArray]:
        constants = prior.values + scale * np.where(free, moved, 0.0)
        odds = rows.features @ constants
        sign = np.where(rows.outcomes, 1.0, -1.0)
        slope = -(sign * expit(-sign * odds)) @ rows.features * scale
        value = -float(log_expit(sign * odds).sum()) + 0.5 * float(moved @ moved)
        return value, np.where(free, slope, 0.0) + moved

    bounds = [
        _bounds(sign, value, size)
        for sign, value, size in zip(prior.signs, prior.values, scale, strict=True)
    ]
    start = np.zeros(len(prior.values))
    best = minimize(cost, start, jac=True, method="L-BFGS-B", bounds=bounds)
    fitted: FloatArray = prior.values + scale * np.where(free, best.x, 0.0)
    return fitted


def _bounds(sign: float, value: float, size: float) -> tuple[float | None, float | None]:
    """Bounds of a move in spreads that keep the sign of a constant."""
    if sign == 0:
        return (None, None)
    edge = -value / size
    return (edge, None) if sign > 0 else (None, edge)


def leave_one_out(rows: Mapping[str, CaseRows], prior: ConstantPrior) -> tuple[LeftOut, ...]:
    """Judge each reality by constants fitted on all the others."""
    judged = []
    for name, own in rows.items():
        others = [one for other, one in rows.items() if other != name]
        if not len(own.outcomes) or not any(len(one.outcomes) for one in others):
            continue
        fitted = fit_constants(joined(others), prior)
        now = _probabilities(own, prior.values)
        then = _probabilities(own, fitted)
        judged.append(
            LeftOut(
                name,
                len(own.outcomes),
                binned_error(then, own.outcomes),
                binned_error(now, own.outcomes),
                _loss(own, fitted),
                _loss(own, prior.values),
                tuple(zip(prior.names, map(float, fitted), strict=True)),
            )
        )
    return tuple(judged)


def joined(rows: Sequence[CaseRows]) -> CaseRows:
    """Return all rows, one behind the other."""
    return CaseRows(
        np.concatenate([one.features for one in rows]),
        np.concatenate([one.outcomes for one in rows]),
    )


def binned_error(probability: FloatArray, outcomes: BoolArray) -> float:
    """Return the expected calibration error of probabilities, in ten bins; NaN for none."""
    if not len(outcomes):
        return math.nan
    bins = np.minimum((probability * BINS).astype(int), BINS - 1)
    off = [
        abs(float((probability[bins == one] - outcomes[bins == one]).sum())) for one in range(BINS)
    ]
    return sum(off) / len(outcomes)


def _probabilities(rows: CaseRows, constants: FloatArray) -> FloatArray:
    chance: FloatArray = expit(rows.features @ constants)
    return chance


def _loss(rows: CaseRows, constants: FloatArray) -> float:
    sign = np.where(rows.outcomes, 1.0, -1.0)
    return -float(log_expit(sign * (rows.features @ constants)).mean())
