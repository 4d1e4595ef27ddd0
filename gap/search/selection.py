"""Which causes, and how many: forward, judged on unseen blocks, with drops and swaps."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.interfaces import Cause, Effect
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate
from gap.search.cross_validation import advantage, unseen_score
from gap.search.fit import ROUNDS, Fitted, fit_causes
from gap.search.options import (
    MISFIT_SHARE,
    NEAR,
    SHORTLIST,
    Option,
    chance_healthy,
    fit_option,
    nats_beyond,
    on_bound,
    share_of,
    shortlist,
    usual_score,
    worth,
)
from gap.search.screen import Signatures, gains, make_signatures
from model.values.arrays import FloatArray

MOST_CAUSES = 5
# Without references: of the score of the channels in which it acts, what a cause must close.
LEAST_SHARE = 0.02
# With references: of the score beyond a healthy machine's, in the channels in which it acts, what one more
# cause must close. Less is the shape of a cause that is there already, mended with that of another.
REST_SHARE = 0.24
TRIMMED = (
    0.03  # share of the blocks, those that are explained worst, that a verdict does not hang on
)
# Chance that a healthy machine shows any of the candidates so large. Far below what is wanted of a
# diagnosis, because scatter pooled over unlike legs has heavier tails than Student's.
LEVEL = 0.001
# Of a first and of a second list: share of the best's first-order gain and nats that candidates must have.
LISTS = ((NEAR, 0.5), (0.0, 10.0))
IDLE = 1e-6  # of a parameter's spread
NOTHING_LEFT = (
    1.2  # energy over expectation, little more than healthy runs', where old signatures do
)
ANEW = 0.3  # share of the score that a law must have closed for all signatures to be made anew


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
        least_gain: Share of the whole score that a cause must gain where there are no references.
    """

    shortlist: int = SHORTLIST
    most: int = MOST_CAUSES
    least_share: float = LEAST_SHARE
    rounds: int = ROUNDS
    least_gain: float = 0.0


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

    def chance(option: Option) -> float:
        """Return its chance in a healthy machine, among all candidates that were tried."""
        return min(1.0, len(candidates) * chance_healthy(option, evidence, healthy))

    found = Selection(fitted, unseen_score(evidence, fitted), (), None)
    while len(found.steps) < search.most:
        taken = _look(evidence, found, signatures, effects, chance, threshold, healthy, search)
        if taken is None:
            break
        best, p, others = taken
        if not found.steps:
            found = replace(found, p=p)
        if p >= LEVEL:
            found = replace(found, refused=best)
            break
        share = best.over.nats / max(float(found.unseen.sum()), 1e-9)
        steps = (*found.steps, Step(best, others))
        found = Selection(best.fitted, best.unseen, steps, None, found.p)
        found = _dropped(evidence, found, effects, threshold)
        left = float((found.fitted.residual**2).sum() / evidence.count.sum())
        if left > NOTHING_LEFT and (not best.added.effect.parameters or share > ANEW):
            signatures = make_signatures(evidence, candidates, found.fitted.causes, lambda _: None)
        progress(len(found.steps) / search.most)
    swapped = _swapped(evidence, found, effects, chance)
    if swapped is found:
        return found
    return _dropped(evidence, swapped, effects, threshold, len(swapped.steps))


def _look(
    evidence: Evidence,
    found: Selection,
    signatures: Signatures,
    effects: Mapping[str, Effect],
    chance: Callable[[Option], float],
    threshold: float,
    healthy: Evidence | None,
    search: Search,
) -> tuple[Option, float, tuple[Option, ...]] | None:
    """Look for one more cause: the best, its chance in a healthy machine (1: not to be taken), its rivals.

    With references, what differs most between days may be all of the first list; so there is a second.
    """
    taken = {(cause.effect, cause.joints) for cause in found.fitted.causes}
    residual = found.fitted.residual
    ranked = gains(signatures, residual, evidence.weights(residual))
    ranked = [gain for gain in ranked if gain.signature.candidate.key not in taken]
    options: list[Option] = []
    usual: list[Option] = []
    least_p = 1.0
    for near, least in LISTS if healthy is not None else LISTS[:1]:
        listed = shortlist(ranked, search.shortlist, near, least)
        ranked = [gain for gain in ranked if gain not in listed]
        fresh = []
        for gain in listed:
            added = gain.signature.candidate
            start = (*found.fitted.causes, added.cause(gain.values))
            fresh.append(fit_option(evidence, added, start, found.unseen, effects, search.rounds))
        fresh.sort(key=_rank)
        options += fresh
        for one in fresh:
            parameters = len(one.added.effect.parameters)
            if not worth(one.over, parameters, threshold, len(one.unseen)):
                continue
            p = chance(one)
            if p < LEVEL and _closes_enough(evidence, one, found, healthy, search):
                one, p = _off_bound(evidence, one, p, options, effects, healthy, chance)
                rivals = [other for other in options if other is not one and other not in usual]
                return one, p, tuple(sorted(rivals, key=_rank))
            if healthy is None:
                return one, 1.0, ()
            usual.append(one)  # healthy runs show it as well: no rival of what is new
            least_p = min(least_p, max(p, LEVEL))
    options.sort(key=_rank)
    return (options[0], least_p, ()) if options else None


def _rank(option: Option) -> tuple[float, object]:
    """Order of options: a parameter more must be worth a nat, or a patch below all feet is a level."""
    return len(option.added.effect.parameters) - option.over.nats, option.added.key


def _off_bound(
    evidence: Evidence,
    best: Option,
    p: float,
    options: Sequence[Option],
    effects: Mapping[str, Effect],
    healthy: Evidence | None,
    chance: Callable[[Option], float],
) -> tuple[Option, float]:
    """Prefer to one fitted to its bound another that is no farther behind than the misfit hides."""
    if healthy is None or not on_bound(best, effects):
        return best, p
    left = nats_beyond(evidence, best.unseen, healthy)
    for other in sorted(options, key=lambda o: -o.over.nats):
        near = best.over.nats - other.over.nats < MISFIT_SHARE * left
        if other is best or not near or on_bound(other, effects):
            continue
        other_p = chance(other)
        if other_p < LEVEL:
            return other, other_p
    return best, p


def _closes_enough(
    evidence: Evidence, one: Option, found: Selection, healthy: Evidence | None, search: Search
) -> bool:
    if healthy is None:
        gains_enough = one.over.nats >= search.least_gain * float(found.unseen.sum())
        return gains_enough and share_of(evidence, one, found.fitted, 0.0) >= search.least_share
    if not found.steps:
        return True
    return share_of(evidence, one, found.fitted, usual_score(evidence, healthy)) >= REST_SHARE


def _without(causes: tuple[Cause, ...], at: int) -> tuple[Cause, ...]:
    return (*causes[:at], *causes[at + 1 :])


def _dropped(
    evidence: Evidence,
    found: Selection,
    effects: Mapping[str, Effect],
    threshold: float,
    look_at: int | None = None,
) -> Selection:
    """Drop a cause that another has made idle, of the first so many; all but the last, if that is None."""
    at = 0
    count = len(found.steps) - 1 if look_at is None else look_at
    while len(found.steps) > 1 and at < count:
        fitted = fit_causes(evidence, _without(found.fitted.causes, at), effects)
        unseen = unseen_score(evidence, fitted)
        loss = advantage(found.unseen, unseen, evidence.block_part)
        step = found.steps[at]
        idle = _idle(found.fitted.causes[at], effects)
        if not idle and worth(
            loss, len(step.chosen.added.effect.parameters), threshold, len(unseen)
        ):
            at += 1
            continue
        steps = (*found.steps[:at], *found.steps[at + 1 :])
        found = Selection(fitted, unseen, steps, found.refused, found.p)
        count -= 1
    return found


def _idle(cause: Cause, effects: Mapping[str, Effect]) -> bool:
    """Whether a cause was fitted to where it does nothing."""
    parameters = effects[cause.effect].parameters
    return bool(parameters) and all(
        abs(value - p.neutral) < IDLE * p.spread
        for p, value in zip(parameters, cause.values, strict=True)
    )


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
            option = fit_option(evidence, rival.added, tuple(causes), found.unseen, effects)
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
