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
DRAWS = 4000  # of outcomes, for what a calibrated answer would show: the chance is known to 0.01


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


@dataclass(frozen=True, slots=True)
class CalibrationError:
    """How far probabilities were from how often they were right, and how far they would be by chance.

    The error is of few answers in ten bins, so that it is not 0 even if every probability is right.

    Attributes:
        error: Expected calibration error in ten bins; NaN for no answer.
        by_chance: Its expectation if every outcome were drawn with the probability that was given.
        p: Chance of so large an error in that case.
        count: How many probabilities.
    """

    error: float
    by_chance: float
    p: float
    count: int

    @property
    def beyond_chance(self) -> float:
        """The error minus what chance explains of it, at least 0."""
        return max(self.error - self.by_chance, 0.0) if self.count else math.nan


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
    return float(_binned_errors(probability, outcomes[None])[0]) if len(outcomes) else math.nan


def _binned_errors(probability: FloatArray, outcomes: BoolArray) -> FloatArray:
    """The same for each row of outcomes, (K, N)."""
    bins = np.minimum((probability * BINS).astype(int), BINS - 1)
    of_bin = (bins[:, None] == np.arange(BINS)).astype(np.float64)
    off: FloatArray = np.abs((probability - outcomes) @ of_bin).sum(axis=1) / len(probability)
    return off


def calibration_of(probability: FloatArray, outcomes: BoolArray, seed: int = 0) -> CalibrationError:
    """Return the calibration error with what it would be if the probabilities, (N,), were right.

    Outcomes are then drawn with these probabilities, each by itself, and binned as the true ones are
    (Broecker and Smith 2007, Weather and Forecasting 22:651, who draw diagrams by this resampling).
    Causes of one case are not quite independent, so that ``p`` is a little too small.
    """
    error = binned_error(probability, outcomes)
    if not len(outcomes):
        return CalibrationError(error, math.nan, math.nan, 0)
    drawn = np.random.default_rng(seed).random((DRAWS, len(probability))) < probability
    errors = _binned_errors(probability, drawn)
    beyond = (1 + int((errors >= error - 1e-12).sum())) / (1 + DRAWS)
    return CalibrationError(error, float(errors.mean()), beyond, len(outcomes))


def _probabilities(rows: CaseRows, constants: FloatArray) -> FloatArray:
    chance: FloatArray = expit(rows.features @ constants)
    return chance


def _loss(rows: CaseRows, constants: FloatArray) -> float:
    sign = np.where(rows.outcomes, 1.0, -1.0)
    return -float(log_expit(sign * (rows.features @ constants)).mean())
