"""Which causes, and how many: forward, judged on held-out blocks, with drops and replacements."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from gap.constants import MADE_AGAIN, NOTHING_LEFT, TRIMMED, VIBRATES_LEAST
from gap.interfaces import Cause, Effect
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate, families_of, too_small
from gap.search.cross_validation import advantage, unseen_score
from gap.search.fit import fit_causes
from gap.search.law_pairs import law_with_partner
from gap.search.look import Look, rank
from gap.search.options import CAUSE_LEVEL, Option, fit_option, worth
from gap.search.pairs import best_pair
from gap.search.replacement import in_its_place, left_out, replaced
from gap.search.screen import Signatures, gains, make_signatures
from gap.search.steps import Known, Search, Selection, Step
from model.values.arrays import FloatArray

WHOLE_SEARCH = Search(pairs=True)
BY_ITSELF = replace(WHOLE_SEARCH, walk=True)  # where no reference helps
IDLE = 1e-6  # of a parameter's spread
# Families whose signatures are made again, of those that gain most by the old ones. Where they were made
# for all (seven times, in pairs of 15 realities), one of the 16 that can be fitted was not among them; it
# gained an eighth of the best.
MAY_BE_NEXT = 60


def select(
    evidence: Evidence,
    candidates: Sequence[Candidate],
    signatures: Signatures,
    progress: Callable[[float], None],
    known: Known | None = None,
    search: Search = WHOLE_SEARCH,
) -> Selection:
    """Find the causes.

    Args:
        evidence: What to fit to.
        candidates: All candidates.
        signatures: Theirs, about the unchanged simulator.
        progress: Gets the share that is done.
        known: References and what the search finds in them; what helps them as much is nothing new.
        search: How far to look.
    """
    look = Look(evidence, known, search)
    fitted = fit_causes(evidence, ())
    selection = Selection(fitted, unseen_score(evidence, fitted), ())
    selection = _with_vibrating(look, selection, candidates)
    selection, signatures = _forward(look, selection, candidates, signatures, progress)
    other = replaced(look, selection, signatures)
    if other is not selection:
        selection = _dropped(evidence, other, len(other.steps))
        selection, signatures = _forward(look, selection, candidates, signatures, progress)
    if known is not None:
        return selection  # what is new there is judged for each cause (``gap.search.contained``)
    return widened(look, selection, candidates, signatures, progress)


def _with_vibrating(look: Look, selection: Selection, candidates: Sequence[Candidate]) -> Selection:
    """Begin with a cause that surely vibrates, whatever else there is.

    What it does in the mean may be little, or another in each gait, and help no prediction.
    """

    def fitted(one: Candidate) -> Option:
        start = [
            p.neutral if p.located else min(p.neutral + p.spread, p.upper)
            for p in one.effect.parameters
        ]
        return fit_option(look.evidence, one, (one.cause(start),), selection.unseen)

    for one in candidates if look.known is not None else ():
        if not one.vibrates or one.effect.shaking is None:
            continue
        option = fitted(one)
        p = look.chance(option)
        if p >= CAUSE_LEVEL or too_small(option.cause, one.effect, VIBRATES_LEAST):
            continue
        steady = (
            fitted(other)
            for other in candidates
            if other.effect.name in one.effect.shaking.steady and other.joints == one.joints
        )
        return Selection(
            option.fitted, option.unseen, (Step(option, tuple(sorted(steady, key=rank)), p),), p
        )
    return selection


def _seen_before(selection: Selection) -> bool:
    """Whether all causes so far were seen before any fit."""
    return all(step.chosen.added.vibrates for step in selection.steps)


def widened(
    look: Look, selection: Selection, candidates: Sequence[Candidate], signatures: Signatures,
    progress: Callable[[float], None],
) -> Selection:  # fmt: skip
    """Put an effect that has a cause's numbers and more in its place, if the whole set is then better.

    What a cause leaves others imitate: dry friction leaves viscous friction and a rotor's inertia, which
    offsets and a weaker loop resemble. Beside them the wider effect gains little, so what it makes idle is
    dropped, and the search goes on.
    """
    evidence = look.evidence
    for at, cause in enumerate(selection.fitted.causes):
        effect = evidence.effects[cause.effect]
        values = dict(zip(effect.parameters, cause.values, strict=True))
        for wider in _holding(effect, cause, candidates):
            start = wider.cause([values.get(p, p.neutral) for p in wider.effect.parameters])
            causes = (*selection.fitted.causes[:at], start, *selection.fitted.causes[at + 1 :])
            option = fit_option(evidence, wider, causes, selection.unseen)
            if option.over.nats <= 0.0:
                continue
            other = in_its_place(selection, at, option)
            other = _dropped(evidence, other, len(other.steps))
            other = _forward(look, other, candidates, signatures, progress)[0]
            over = advantage(other.unseen, selection.unseen, evidence.block_part)
            if over.clear:
                return widened(look, other, candidates, signatures, progress)
    return selection


def _holding(effect: Effect, cause: Cause, candidates: Sequence[Candidate]) -> Iterator[Candidate]:
    """Yield candidates at the same joints that have all numbers of an effect, and more.

    None for a law, which has no number; nor another form of the same cause, which was tried as one.
    """
    numbers = set(effect.parameters)
    for one in candidates:
        other = one.joints == cause.joints and one.effect.family != effect.family
        if other and numbers and numbers < set(one.effect.parameters):
            yield one


def _forward(
    look: Look, selection: Selection, candidates: Sequence[Candidate], signatures: Signatures,
    progress: Callable[[float], None],
) -> tuple[Selection, Signatures]:  # fmt: skip
    """Add causes while one is new; returns the signatures about what was taken."""
    evidence, about_none = look.evidence, signatures
    while len(selection.steps) < look.search.most:
        taken = look.one_more(selection, signatures)
        if taken is None:
            break
        best = taken.chosen
        if not selection.steps:
            selection = replace(selection, p=taken.p, nearest=best)
        elif _seen_before(selection):  # a second look
            selection = replace(selection, p=min(selection.p, 2.0 * taken.p))
        if taken.p >= look.level(selection.fitted):
            break
        share = best.over.nats / max(float(selection.unseen.sum()), 1e-9)
        steps = (*selection.steps, taken)
        selection = Selection(best.fitted, best.unseen, steps, selection.p)
        selection = _dropped(evidence, selection, len(selection.steps) - 1)
        left = evidence.mean_excess(selection.fitted.residual)
        law = not best.added.effect.parameters
        if left > NOTHING_LEFT and (law or share > MADE_AGAIN):
            some = candidates if law else _near(evidence, candidates, about_none, selection)
            signatures = make_signatures(evidence, some, selection.fitted.causes, lambda _: None)
        progress(len(selection.steps) / look.search.most)
    if look.search.pairs and not selection.steps and look.known is None:
        selection = best_pair(look, selection, signatures) or selection
    if look.search.laws and len(selection.steps) + 1 < look.search.most:
        both = law_with_partner(look, selection, candidates)
        if both is not None:
            signatures = make_signatures(evidence, candidates, both.fitted.causes, lambda _: None)
            return _forward(look, both, candidates, signatures, progress)
    return selection, signatures


def _near(
    evidence: Evidence,
    candidates: Sequence[Candidate],
    about_none: Signatures,
    selection: Selection,
) -> list[Candidate]:
    """Candidates that may be the next cause, or one instead of a cause, by the signatures at hand.

    These are of the simulator without the causes, and good enough to tell who cannot be among the best.
    """
    families = families_of(selection.fitted.causes, evidence.effects)
    for residual in (selection.fitted.residual, evidence.base):
        ranked = gains(about_none, residual, evidence.weights(residual))
        order = dict.fromkeys(one.signature.candidate.family for one in ranked)
        families |= set(list(order)[:MAY_BE_NEXT])
    return [one for one in candidates if one.family in families]


def _dropped(evidence: Evidence, selection: Selection, count: int) -> Selection:
    """Drop causes that others have made idle, of the first so many."""
    at = 0
    while len(selection.steps) > 1 and at < count:
        added = selection.steps[at].chosen.added
        least: float = VIBRATES_LEAST if added.vibrates else 0.0
        idle = _idle(added.effect, selection.fitted.causes[at], least)
        if added.vibrates and not idle:  # whatever it gains
            at += 1
            continue
        fewer = left_out(evidence, selection, {at})
        loss = advantage(selection.unseen, fewer.unseen, evidence.block_part)
        if not idle and worth(loss, len(added.effect.parameters), len(fewer.unseen)):
            at += 1
            continue
        selection, count = fewer, count - 1
    return selection


def _idle(effect: Effect, cause: Cause, least_size: float = 0.0) -> bool:
    """Whether a cause was fitted to where it does nothing, or next to nothing; a law never is."""
    nothing = all(
        abs(value - p.neutral) < IDLE * p.spread
        for p, value in zip(effect.parameters, cause.values, strict=True)
    )
    return (
        bool(effect.parameters)
        and not effect.law
        and (nothing or too_small(cause, effect, least_size))
    )


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
