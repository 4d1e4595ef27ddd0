"""Which causes, and how many: forward, judged on unseen blocks, with drops and swaps."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from gap.candidates import APART_M, Candidate, off_bounds
from gap.cross_validation import Advantage, advantage, unseen_score
from gap.evidence import Evidence
from gap.fit import ROUNDS, Fitted, fit_causes
from gap.interfaces import Cause, Effect
from gap.novelty import novelty
from gap.screen import Gain, Signatures, gains, make_signatures
from model.signals import FloatArray

MOST_CAUSES = 5
SHORTLIST = 8
MOST_OF_AN_EFFECT = 3
LEAST_NATS = 4.0
# Without references: of the score of the channels in which it acts, what a cause must close.
LEAST_SHARE = 0.02
ACTS = 0.1  # of the largest gain of a channel
# With references: of the score beyond a healthy machine's, in the channels in which it acts, what one more
# cause must close. Less is the shape of a cause that is there already, mended with that of another.
REST_SHARE = 0.24
TRIMMED = (
    0.03  # share of the blocks, those that are explained worst, that a verdict does not hang on
)
ERRORS = 2.0
# Chance that a healthy machine shows any of the candidates so large. Far below what is wanted of a
# diagnosis, because scatter pooled over unlike legs has heavier tails than Student's.
LEVEL = 0.001
NEAR_PLACES = (-1.0, -0.6, -0.3, 0.3, 0.6, 1.0)  # of the distance of places that were tried
NEAR = 0.2  # a candidate with a smaller share of the best's first-order gain is not fitted
NOTHING_LEFT = (
    1.2  # energy over expectation, little more than healthy runs', where old signatures do
)
ANEW = 0.3  # share of the score that a law must have closed for all signatures to be made anew


@dataclass(frozen=True, slots=True, eq=False)
class Option:
    """A set of causes that was fitted.

    Attributes:
        added: The candidate that it adds to what stood.
        fitted: The fit.
        unseen: Score of each block without its fold, (B,).
        over: How much better than what stood.
    """

    added: Candidate
    fitted: Fitted
    unseen: FloatArray
    over: Advantage


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One cause that was taken, and the others that were fitted in its place.

    Attributes:
        chosen: What was taken.
        rivals: The others, best first.
    """

    chosen: Option
    rivals: tuple[Option, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """The causes.

    Attributes:
        fitted: All of them together.
        unseen: Score of each block without its fold, (B,).
        steps: One a cause, in the order of ``fitted.causes``.
        refused: The best that was not taken at the end; None if nothing was left to try.
        p: Chance that a healthy machine shows any candidate as large as the best of the first step; 1 if
            there was none.
    """

    fitted: Fitted
    unseen: FloatArray
    steps: tuple[Step, ...]
    refused: Option | None
    p: float = 1.0


@dataclass(frozen=True, slots=True)
class Search:
    """How far to look.

    Attributes:
        shortlist: Candidates that are fitted at each step.
        most: Causes.
        least_share: Share of the score, in the channels in which it acts, that a cause must close where
            there are no references.
        rounds: Most steps of a fit.
    """

    shortlist: int = SHORTLIST
    most: int = MOST_CAUSES
    least_share: float = LEAST_SHARE
    rounds: int = ROUNDS


def select(
    evidence: Evidence,
    candidates: Sequence[Candidate],
    signatures: Signatures,
    effects: Mapping[str, Effect],
    threshold: float,
    progress: Callable[[float], None],
    healthy: Evidence | None = None,
    search: Search = Search(),
) -> Selection:
    """Find the causes.

    Args:
        evidence: What to fit to.
        candidates: All candidates.
        signatures: Theirs, about the simulator as it stands.
        effects: The catalogue by name.
        threshold: Nats that a cause must gain beyond its scatter, at least.
        progress: Told the share that is done.
        healthy: References; what helps them as much is nothing new.
        search: How far to look.
    """
    fitted = fit_causes(evidence, (), effects)
    tried = len(candidates)
    found = Selection(fitted, unseen_score(evidence, fitted), (), None)
    while len(found.steps) < search.most:
        options = _options(evidence, found, signatures, effects, search)
        if not options:
            break
        chosen = [
            one for one in options if worth(one.over, len(one.added.effect.parameters), threshold,
            len(one.unseen))
        ]  # fmt: skip
        best, p = options[0], 1.0
        usual: list[Option] = []
        for one in chosen:
            p_one = min(1.0, tried * chance_healthy(one, evidence, healthy))
            p = min(p, p_one)
            if p_one < LEVEL:
                best = one
                break
            usual.append(one)  # healthy runs show it as well: no rival of what is new
        if not found.steps:
            found = replace(found, p=p)
        if healthy is None:
            small = _share(evidence, best, found.fitted, 0.0) < search.least_share
        else:
            usual_score = _usual(evidence, healthy)
            small = (
                bool(found.steps) and _share(evidence, best, found.fitted, usual_score) < REST_SHARE
            )
        if small or p >= LEVEL:
            found = replace(found, refused=best)
            break
        share = best.over.nats / max(float(found.unseen.sum()), 1e-9)
        others = tuple(one for one in options if one is not best and one not in usual)
        steps = (*found.steps, Step(best, others))
        found = Selection(best.fitted, best.unseen, steps, None, found.p)
        found = _dropped(evidence, found, effects, threshold)
        left = float((found.fitted.residual**2).sum() / evidence.count.sum())
        if left > NOTHING_LEFT and (not best.added.effect.parameters or share > ANEW):
            signatures = make_signatures(evidence, candidates, found.fitted.causes, lambda _: None)
        progress(len(found.steps) / search.most)
    return _swapped(
        evidence, found, effects, lambda o: chance_healthy(o, evidence, healthy) * tried
    )


def _share(
    evidence: Evidence, option: Option, standing: Fitted, usual: FloatArray | float
) -> float:
    """Share of the score beyond the usual that an option closes in the channels in which it acts."""
    before = evidence.score(standing.residual).sum(axis=0)
    gain = before - evidence.score(option.fitted.residual).sum(axis=0)
    on = gain > ACTS * gain.max()
    beyond = np.fmax(before - usual, gain)[on]  # what is closed was there to be closed
    return float(gain[on].sum() / beyond.sum()) if on.any() else 0.0


def _usual(evidence: Evidence, healthy: Evidence) -> FloatArray:
    """Score of each channel that as many frames of healthy runs have, (C,)."""
    count = np.fmax(healthy.count.sum(axis=0), 1e-9)
    found: FloatArray = healthy.score(healthy.base).sum(axis=0) / count * evidence.count.sum(axis=0)
    return found


def chance_healthy(option: Option, evidence: Evidence, healthy: Evidence | None) -> float:
    """Chance of so large a cause in a healthy machine; 0 where there is none to compare with."""
    if healthy is None:
        return 0.0
    causes = option.fitted.causes
    added = next(c for c in causes if (c.effect, c.joints) == option.added.key)
    joints = evidence.predictor.simulator.joints
    return novelty(evidence, healthy, causes, option.fitted.residual, added, joints).p


def worth(over: Advantage, parameters: int, threshold: float, blocks: int) -> bool:
    """Tell whether an advantage is more than scatter."""
    needed = ERRORS * float(stats.t.ppf(0.977, max(blocks - 1, 1))) / 2.0 * over.error
    return over.nats > max(needed, LEAST_NATS + parameters, 0.5 * threshold)


def _options(
    evidence: Evidence,
    found: Selection,
    signatures: Signatures,
    effects: Mapping[str, Effect],
    search: Search,
) -> list[Option]:
    taken = {(cause.effect, cause.joints) for cause in found.fitted.causes}
    residual = found.fitted.residual
    ranked = gains(signatures, residual, evidence.weights(residual))
    ranked = [one for one in ranked if one.signature.candidate.key not in taken]
    options = []
    for one in shortlist(ranked, search.shortlist):
        added = one.signature.candidate
        start = (*found.fitted.causes, added.cause(one.values))
        options.append(_option(evidence, added, start, found.unseen, effects, search.rounds))
    return sorted(options, key=lambda o: (-o.over.nats, o.added.key))


def _option(
    evidence: Evidence,
    added: Candidate,
    start: tuple[Cause, ...],
    standing: FloatArray,
    effects: Mapping[str, Effect],
    rounds: int = ROUNDS,
) -> Option:
    fitted = fit_causes(evidence, start, effects, rounds)
    freed = off_bounds(start, effects)
    if freed != start:
        # a cause that took the place of one that was missing may be stuck where it went for that
        again = fit_causes(evidence, freed, effects)
        fitted = again if again.nats < fitted.nats else fitted
    fitted = _placed(evidence, fitted, effects, rounds)
    unseen = unseen_score(evidence, fitted)
    return Option(added, fitted, unseen, advantage(unseen, standing, evidence.block_part))


def _placed(
    evidence: Evidence, fitted: Fitted, effects: Mapping[str, Effect], rounds: int
) -> Fitted:
    """Move edges in the world a little: feet cross them one by one, so that a descent sticks between."""
    for number, cause in enumerate(fitted.causes):
        for at, parameter in enumerate(effects[cause.effect].parameters):
            if not parameter.located:
                continue
            near = [fitted.causes]
            for share in NEAR_PLACES:
                values = list(cause.values)
                moved = values[at] + share * APART_M
                values[at] = min(max(moved, parameter.lower), parameter.upper)
                near.append((
                    *fitted.causes[:number],
                    replace(cause, values=tuple(values)),
                    *fitted.causes[number + 1 :],
                ))  # fmt: skip
            scores = [float(evidence.score(one).sum()) for one in evidence.residuals(near)]
            best = min(range(len(near)), key=scores.__getitem__)
            if best > 0:
                again = fit_causes(evidence, near[best], effects, rounds)
                fitted = again if again.nats < fitted.nats else fitted
    return fitted


def shortlist(ranked: Sequence[Gain], most: int = SHORTLIST) -> list[Gain]:
    """Return the candidates worth a fit: near the best, and not all of one effect."""
    chosen: list[Gain] = []
    counts: dict[str, int] = {}
    for one in ranked:
        name = one.signature.candidate.effect.name
        if one.nats <= 0.5 or len(chosen) >= most:
            break
        if counts.get(name, 0) >= MOST_OF_AN_EFFECT:
            continue
        if chosen and one.nats < NEAR * chosen[0].nats and len(chosen) >= 3:
            break
        counts[name] = counts.get(name, 0) + 1
        chosen.append(one)
    # a law has no size: to first order it is worth nothing until the others have adjusted to it
    laws = [one for one in ranked if not one.signature.candidate.effect.parameters]
    return [*chosen, *(one for one in laws if one not in chosen)]


def _without(causes: tuple[Cause, ...], at: int) -> tuple[Cause, ...]:
    return (*causes[:at], *causes[at + 1 :])


def _dropped(
    evidence: Evidence, found: Selection, effects: Mapping[str, Effect], threshold: float
) -> Selection:
    """Drop an earlier cause that a later one has made idle."""
    at = 0
    while len(found.steps) > 1 and at < len(found.steps) - 1:
        fitted = fit_causes(evidence, _without(found.fitted.causes, at), effects)
        unseen = unseen_score(evidence, fitted)
        loss = advantage(found.unseen, unseen, evidence.block_part)
        step = found.steps[at]
        if worth(loss, len(step.chosen.added.effect.parameters), threshold, len(unseen)):
            at += 1
            continue
        steps = (*found.steps[:at], *found.steps[at + 1 :])
        found = Selection(fitted, unseen, steps, found.refused, found.p)
    return found


def _swapped(
    evidence: Evidence,
    found: Selection,
    effects: Mapping[str, Effect],
    chance: Callable[[Option], float],
) -> Selection:
    """Put a rival in a cause's place where the whole set then predicts better."""
    if len(found.steps) < 2:
        return found
    for at in range(len(found.steps)):
        step = found.steps[at]
        others = {(c.effect, c.joints) for c in _without(found.fitted.causes, at)}
        for rival in step.rivals[:2]:
            if rival.added.key in others:
                continue
            causes = list(found.fitted.causes)
            causes[at] = next(
                c for c in rival.fitted.causes if (c.effect, c.joints) == rival.added.key
            )
            option = _option(evidence, rival.added, tuple(causes), found.unseen, effects)
            ahead = option.over.nats > max(option.over.error, 2.0)
            if ahead and chance(option) < LEVEL:
                rivals = (step.chosen, *(r for r in step.rivals if r is not rival))
                swapped = Step(option, tuple(rivals))
                steps = (*found.steps[:at], swapped, *found.steps[at + 1 :])
                found = Selection(option.fitted, option.unseen, steps, found.refused, found.p)
                break
    return found


def closed_share(evidence: Evidence, residual: FloatArray) -> float:
    """Share of the energy above expectation that a fit closes; 0 where there is none above it.

    What is left at or below expectation counts as closed altogether.
    """
    blocks = evidence.per_block(residual**2).sum(axis=1)
    kept = np.argsort(blocks, kind="stable")[: len(blocks) - int(TRIMMED * len(blocks))]
    before = float(evidence.per_block(evidence.base**2)[kept].sum())
    after = float(blocks[kept].sum())
    floor = min(float(evidence.count[kept].sum()), after)
    return float(np.clip((before - after) / (before - floor), 0.0, 1.0)) if before > floor else 0.0
