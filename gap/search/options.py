"""One more cause: which candidates are worth a fit, how they fit, and whether that is anything new."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import special

from gap.constants import (
    ACTS,
    CAUSES_PART,
    CLEAR_ERRORS,
    FALSE_ALARMS,
    FIRST_NATS,
    MUCH_LESS,
    NEAR_BEST,
    WORTH_NATS,
)
from gap.interfaces import Cause, Parameter
from gap.residuals.at_once import ahead_of
from gap.residuals.evidence import Evidence
from gap.residuals.healthy import Healthy
from gap.search.candidates import APART_M, Candidate, off_bounds, on_bound
from gap.search.cross_validation import Advantage, advantage, unseen_score
from gap.search.fit import ROUNDS, Fitted, fit_causes, free_values, least_squares, moved
from gap.search.screen import BATCH, Gain
from model.values.arrays import BoolArray, FloatArray

SHORTLIST = 8
MOST_OF_AN_EFFECT = 3
NEAR_PLACES = (-1.0, -0.6, -0.3, 0.3, 0.6, 1.0)  # of the distance of places that were tried
# Chance, among all candidates, of a healthy machine showing a cause that is named.
CAUSE_LEVEL = CAUSES_PART * FALSE_ALARMS
WALK = (2.5, 6.0)  # times what the first order asks for
MOST_TIMES = 3  # that a descent begins again because it got stuck


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """A set of causes that was fitted.

    Attributes:
        added: The candidate that it adds to what stood.
        unseen: Score of each block without its fold, (B,).
        over: How much better than what stood, minus the price of the forms that were tried.
    """

    added: Candidate
    fitted: Fitted
    unseen: FloatArray
    over: Advantage

    @property
    def cause(self) -> Cause:
        """What it adds, as fitted."""
        return next(c for c in self.fitted.causes if (c.effect, c.joints) == self.added.key)


class Walked(NamedTuple):
    """What a candidate gains at the best of a few sizes, and the share that it closes in its channels."""

    gain: Gain
    share: float


def share_of(
    evidence: Evidence, option: Option, standing: Fitted, usual: FloatArray | float
) -> float:
    """Share of the score beyond the usual that an option closes in the channels in which it acts."""
    return share_closed(evidence, standing.residual, option.fitted.residual, usual)


def share_closed(
    evidence: Evidence, before: FloatArray, after: FloatArray, usual: FloatArray | float = 0.0
) -> float:
    """Return the same share of residuals before and after, (F, C)."""
    score = evidence.score(before).sum(axis=0)
    gain = score - evidence.score(after).sum(axis=0)
    return _closed(score, gain, usual, acting(gain))


def energy_share_of(
    evidence: Evidence, option: Option, standing: Fitted, healthy: Evidence
) -> float:
    """Share of the energy beyond that of healthy runs that an option closes, in the same channels.

    The score counts a large misfit by its logarithm: what halves one of a thousand times the expectation
    closes a tenth of its score.
    """
    score = evidence.score(standing.residual) - evidence.score(option.fitted.residual)
    on = acting(score.sum(axis=0))
    usual = usual_energy(evidence, healthy).sum(axis=0)
    before = (standing.residual**2).sum(axis=0)
    gain = before - (option.fitted.residual**2).sum(axis=0)
    return _closed(before, gain, usual, on)


def closed_beyond(evidence: Evidence, residual: FloatArray, healthy: Sequence[Healthy]) -> float:
    """Share of the energy that no healthy run shows which causes close, in channels in which they act.

    Args:
        evidence: What was fitted to.
        residual: What the causes leave, whitened, (F, C).
        healthy: References in units of what the others predict; without any the share is 1.
    """
    runs = np.array([one.excess for one in healthy]).reshape(-1, evidence.base.shape[1])
    known = np.isfinite(runs).any(axis=0) & (evidence.count.sum(axis=0) > 0)
    if not known.any():
        return 1.0
    before = (evidence.base**2).sum(axis=0)[known]
    gain = before - (residual**2).sum(axis=0)[known]
    usual = np.nanmax(runs[:, known], axis=0) * evidence.count.sum(axis=0)[known]
    return float(np.clip(_closed(before, gain, usual, acting(gain)), 0.0, 1.0))


def acting(gain: FloatArray) -> BoolArray:
    """Return the channels in which a cause acts, given what it gains in the score of each, (C,)."""
    return np.asarray(gain > ACTS * gain.max())


def _closed(
    before: FloatArray, gain: FloatArray, usual: FloatArray | float, on: BoolArray
) -> float:
    beyond = np.fmax(before - usual, gain)[on]  # what is closed was there to be closed
    return float(gain[on].sum() / beyond.sum()) if on.any() else 0.0


def ends_on_bound(option: Option) -> bool:
    """Whether what an option adds was fitted to a bound of one of its parameters."""
    parameters = option.added.effect.parameters
    return any(on_bound(p, value) for p, value in zip(parameters, option.cause.values, strict=True))


def usual_energy(evidence: Evidence, healthy: Evidence) -> FloatArray:
    """Energy of each block and channel that as many frames of healthy runs have, (B, C)."""
    count = np.fmax(healthy.count.sum(axis=0), 1e-9)
    return np.asarray((healthy.base**2).sum(axis=0) / count * evidence.count)


def usual_score(evidence: Evidence, healthy: Evidence) -> FloatArray:
    """Score of each channel that as many frames of healthy runs have, (C,)."""
    count = np.fmax(healthy.count.sum(axis=0), 1e-9)
    expected: FloatArray = healthy.base_score.sum(axis=0) / count * evidence.count.sum(axis=0)
    return expected


def nats_beyond(evidence: Evidence, unseen: FloatArray, healthy: Evidence | None) -> float:
    """Score of blocks, (B,), beyond that of as many healthy frames; beyond noise where there are none."""
    usual = usual_score(evidence, healthy) if healthy else evidence.count.sum(axis=0) / 2
    return float(unseen.sum() - usual.sum())


def worth(over: Advantage, parameters: int, blocks: int) -> bool:
    """Whether an advantage is more than scatter."""
    return over.nats > max(_clear_errors(blocks) * over.error, WORTH_NATS + parameters)


def worth_size(parameters: int, blocks: int, share: float) -> float:
    """Return the size of a change whose advantage is more than scatter in a share of cases.

    In standard errors by noise alone: one of x gains x^2 / 2 nats on average, with a standard error of x.
    """
    short = float(special.ndtri(share))
    enough = short + np.sqrt(short**2 + 2.0 * (WORTH_NATS + parameters))
    return float(max(2.0 * (_clear_errors(blocks) + short), enough))


def _clear_errors(blocks: int) -> float:
    """Standard errors over so many blocks from which an advantage is clear."""
    return CLEAR_ERRORS * float(special.stdtrit(max(blocks - 1, 1), 0.977)) / 2.0


def fit_option(
    evidence: Evidence,
    added: Candidate,
    start: tuple[Cause, ...],
    standing: FloatArray,
    rounds: int = ROUNDS,
    near: Fitted | None = None,
) -> Option:
    """Fit a candidate together with the causes so far, and judge it on blocks that were not fitted to.

    The start has all causes with the values to begin from; ``standing`` is the score of each block with
    what stood before, (B,); ``near`` is a fit of some of the causes.
    """
    fitted = fit_causes(evidence, start, rounds, near=near)
    freed = off_bounds(start, evidence.effects)
    if freed != start:
        # a cause that took the place of one that was missing may be stuck where it went for that
        again = fit_causes(evidence, freed)
        fitted = again if again.nats < fitted.nats else fitted
    fitted = _for_most(evidence, fitted, rounds)
    fitted = _farther_along(evidence, added, fitted, rounds)
    fitted = _placed(evidence, fitted, rounds)
    unseen = unseen_score(evidence, fitted)
    over = advantage(unseen, standing, evidence.block_part)
    return Option(added, fitted, unseen, replace(over, nats=over.nats - added.price))


def _for_most(evidence: Evidence, fitted: Fitted, rounds: int) -> Fitted:
    """Begin again where least squares would leave much less, and keep the better fit.

    A large misfit counts by its logarithm, so that a descent may stop where a few blocks fit well and most
    do not: a turned pose, at the angle that one hip's wrong place hides at its own leg.
    """
    free = free_values(fitted.causes, evidence.effects)
    if not free:
        return fitted
    energy = float((fitted.residual**2).sum())
    step, left = least_squares(fitted.residual, fitted.slopes)
    if left > MUCH_LESS * energy:
        return fitted
    again = fit_causes(evidence, moved(fitted.causes, free, step), rounds)
    return again if again.nats < fitted.nats else fitted


def _farther_along(evidence: Evidence, added: Candidate, fitted: Fitted, rounds: int) -> Fitted:
    """Begin again farther away where a descent got stuck, and keep the better fit, a few times over.

    Feet begin and cease to slip one by one, so that each step of a descent may be a small part of the way.
    One foot that sticks at the right moment may also make the descent begin towards the wrong side: which
    is farther, least squares say as well, because they do not count a large misfit for little.
    """
    if not fitted.stuck or rounds < ROUNDS:  # few rounds are no descent to the end
        return fitted
    at = [(c.effect, c.joints) for c in fitted.causes].index(added.key)
    free = free_values(fitted.causes, evidence.effects)
    for _ in range(MOST_TIMES):
        if not fitted.stuck:
            break
        own = fitted.causes[at]
        starts = [
            (*fitted.causes[:at], replace(own, values=values), *fitted.causes[at + 1 :])
            for values in _larger(added.effect.parameters, own.values)
        ]
        step, _ = least_squares(fitted.residual, fitted.slopes)
        starts += [moved(fitted.causes, free, times * step) for times in WALK]
        again = _from_best(
            evidence, fitted, [one for one in starts if one != fitted.causes], rounds
        )
        if again is fitted:
            break
        fitted = again
    return fitted


def _placed(evidence: Evidence, fitted: Fitted, rounds: int) -> Fitted:
    """Move edges in the world a little: feet cross them one by one, so that a descent sticks between."""
    for value in free_values(fitted.causes, evidence.effects):
        if not value.parameter.located:
            continue
        steps = [share * APART_M / value.parameter.spread for share in NEAR_PLACES]
        near = [moved(fitted.causes, [value], [step]) for step in steps]
        fitted = _from_best(evidence, fitted, near, rounds)
    return fitted


def _from_best(
    evidence: Evidence, fitted: Fitted, starts: Sequence[tuple[Cause, ...]], rounds: int
) -> Fitted:
    """Begin again at the best of some starts, if that is better than the fit, and keep the better fit."""
    if not starts:
        return fitted
    scores = evidence.nats(starts)
    best = min(range(len(starts)), key=scores.__getitem__)
    if scores[best] >= float(evidence.score(fitted.residual).sum()):
        return fitted
    again = fit_causes(evidence, starts[best], rounds)
    return again if again.nats < fitted.nats else fitted


def as_they_act(evidence: Evidence, standing: Fitted, candidates: Sequence[Gain]) -> list[Walked]:
    """Return what candidates gain at a few sizes, each at its best size, best first.

    Where a residual is large, its weight is small: to first order, a cause that explains it gains little
    and asks for a small part of its size. So each is predicted at that size and at larger ones. As in a
    fit, numbers away from neutral cost their prior.

    Args:
        evidence: What is fitted to.
        standing: The causes so far, fitted.
        candidates: What they gain to first order, and at which values.
    """
    tried = [(i, values) for i, gain in enumerate(candidates) for values in _walk(gain)]
    batches = [tried[at : at + BATCH] for at in range(0, len(tried), BATCH)]
    before = evidence.score(standing.residual).sum(axis=0)

    def won_by(batch: Sequence[tuple[int, tuple[float, ...]]]) -> list[FloatArray]:
        sets = [
            (*standing.causes, candidates[i].signature.candidate.cause(values))
            for i, values in batch
        ]
        return [before - evidence.score(one).sum(axis=0) for one in evidence.residuals(sets)]

    best: dict[int, Walked] = {}
    made = ahead_of(batches, won_by, evidence.predictor.at_once)
    for (i, values), won in zip(tried, itertools.chain.from_iterable(made), strict=True):
        nats = float(won.sum()) - 0.5 * _away(candidates[i], values)
        share = _closed(before, won, 0.0, acting(won)) if won.max() > 0.0 else 0.0
        if i not in best or nats > best[i].gain.nats:
            best[i] = Walked(replace(candidates[i], values=values, nats=nats), share)
    return sorted(best.values(), key=lambda one: -one.gain.nats)


def _walk(gain: Gain) -> list[tuple[float, ...]]:
    """The values that the first order asks for, and larger ones that are within bounds."""
    larger = _larger(gain.signature.candidate.effect.parameters, gain.values)
    return list(dict.fromkeys([gain.values, *larger]))


def _larger(
    parameters: Sequence[Parameter], values: tuple[float, ...]
) -> Iterator[tuple[float, ...]]:
    """Values that are farther from neutral and within bounds."""
    for times in WALK:
        farther = tuple(
            value if p.located else _farther(p, value, times)
            for p, value in zip(parameters, values, strict=True)
        )
        if all(p.lower <= one <= p.upper for p, one in zip(parameters, farther, strict=True)):
            yield farther


def _farther(p: Parameter, value: float, times: float) -> float:
    """A value so many times as far from neutral; what cannot be negative is a ratio."""
    if p.lower > 0.0 and p.neutral > 0.0:
        return float(p.neutral * (value / p.neutral) ** times)
    return p.neutral + times * (value - p.neutral)


def _away(gain: Gain, values: tuple[float, ...]) -> float:
    """Squared distance from neutral in spreads."""
    parameters = gain.signature.candidate.effect.parameters
    pairs = zip(parameters, values, strict=True)
    return float(sum(((value - p.neutral) / p.spread) ** 2 for p, value in pairs))


def shortlist(
    ranked: Sequence[Gain],
    most: int = SHORTLIST,
    near: float = NEAR_BEST,
    least: float = FIRST_NATS,
) -> list[Gain]:
    """Return the candidates worth a fit: near the best, and not all of one effect.

    Args:
        ranked: Candidates, best first.
        most: How many.
        near: Share of the best's gain that they must have.
        least: Nats that they must have.
    """
    chosen: list[Gain] = []
    counts: dict[str, int] = {}
    for one in ranked:
        name = one.signature.candidate.effect.name
        if one.nats <= least or len(chosen) >= most:
            break
        if counts.get(name, 0) >= MOST_OF_AN_EFFECT:
            continue
        if chosen and one.nats < near * chosen[0].nats and len(chosen) >= 3:
            break
        counts[name] = counts.get(name, 0) + 1
        chosen.append(one)
    # a law has no size: to first order it is worth nothing until the others have adjusted to it
    laws = [one for one in ranked if not one.signature.candidate.effect.parameters]
    return [*chosen, *(one for one in laws if one not in chosen)]
