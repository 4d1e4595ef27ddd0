"""Which causes, and how many: forward, judged on held-out blocks, with drops and swaps."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.interfaces import Cause, Effect
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate
from gap.search.cross_validation import advantage, unseen_score
from gap.search.fit import ROUNDS, Fitted, fit_causes
from gap.search.novelty import chance_healthy
from gap.search.options import (
    HIDDEN_SHARE,
    NEAR,
    SHORTLIST,
    Option,
    fit_option,
    nats_beyond,
    on_bound,
    share_of,
    shortlist,
    usual_score,
    worth,
)
from gap.search.screen import Gain, Signatures, gains, make_signatures
from model.values.arrays import FloatArray

MOST_CAUSES = 5
# Without references: of the score of the channels in which it acts, what a cause must close.
LEAST_SHARE = 0.02
# With references: of the score beyond a healthy machine's, in the channels in which it acts, what one more
# cause must close. Less is the shape of a cause that is there already, filled in with that of another.
REST_SHARE = 0.24
# Share of the blocks, those that are explained worst, that a verdict does not depend on.
TRIMMED = 0.03
# Chance that a healthy machine shows any of the candidates so large. Far below what is wanted of a
# diagnosis, because scatter pooled over unlike legs has heavier tails than Student's.
CAUSE_LEVEL = 0.001
# Of a first and of a second list: share of the best's first-order gain and nats that candidates must have.
LISTS = ((NEAR, 0.5), (0.0, 10.0))
IDLE = 1e-6  # of a parameter's spread
# Energy over expectation, little more than that of healthy runs, below which old signatures are kept.
NOTHING_LEFT = 1.2
ANEW = 0.3  # share of the score that a law must have closed for all signatures to be made anew


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One cause that was taken, and the others that were fitted in its place, best first."""

    chosen: Option
    rivals: tuple[Option, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """The causes.

    Attributes:
        fitted: All of them together.
        unseen: Score of each block without its fold, (B,).
        steps: One a cause, in the order of ``fitted.causes``.
        p: Chance that a healthy machine shows any candidate as large as the best of the first step; 1 if
            there was none.
    """

    fitted: Fitted
    unseen: FloatArray
    steps: tuple[Step, ...]
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
    progress: Callable[[float], None],
    healthy: Evidence | None = None,
    search: Search = Search(),
) -> Selection:
    """Find the causes.

    Args:
        evidence: What to fit to.
        candidates: All candidates.
        signatures: Theirs, about the simulator as it stands.
        progress: Gets the share that is done.
        healthy: References; what helps them as much is nothing new.
        search: How far to look.
    """
    look = Look(evidence, len(candidates), healthy, search)
    fitted = fit_causes(evidence, ())
    selection = Selection(fitted, unseen_score(evidence, fitted), ())
    while len(selection.steps) < search.most:
        taken = look.one_more(selection, signatures)
        if taken is None:
            break
        best, p, others = taken
        if not selection.steps:
            selection = replace(selection, p=p)
        if p >= CAUSE_LEVEL:
            break
        share = best.over.nats / max(float(selection.unseen.sum()), 1e-9)
        selection = Selection(
            best.fitted, best.unseen, (*selection.steps, Step(best, others)), selection.p
        )
        selection = _dropped(evidence, selection, len(selection.steps) - 1)
        left = evidence.mean_excess(selection.fitted.residual)
        if left > NOTHING_LEFT and (not best.added.effect.parameters or share > ANEW):
            signatures = make_signatures(
                evidence, candidates, selection.fitted.causes, lambda _: None
            )
        progress(len(selection.steps) / search.most)
    swapped = look.swapped(selection)
    return selection if swapped is selection else _dropped(evidence, swapped, len(swapped.steps))


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """Looks for causes that are new; ``count`` is how many candidates there are, healthy None without."""

    evidence: Evidence
    count: int
    healthy: Evidence | None
    search: Search

    def chance(self, option: Option) -> float:
        """Return its chance in a healthy machine, among all candidates; 0 without references."""
        if self.healthy is None:
            return 0.0
        one = chance_healthy(self.evidence, self.healthy, option.fitted, option.cause)
        return min(1.0, self.count * one)

    def one_more(
        self, selection: Selection, signatures: Signatures
    ) -> tuple[Option, float, tuple[Option, ...]] | None:
        """Return the best next cause, its chance in a healthy machine (1: not to be taken), its rivals.

        With references, what differs most between days may be all of the first list; so there is a second.
        """
        taken = {(cause.effect, cause.joints) for cause in selection.fitted.causes}
        residual = selection.fitted.residual
        ranked = gains(signatures, residual, self.evidence.weights(residual))
        ranked = [gain for gain in ranked if gain.signature.candidate.key not in taken]
        options: list[Option] = []
        usual: list[Option] = []
        least_p = 1.0
        for near, least in LISTS if self.healthy is not None else LISTS[:1]:
            listed = shortlist(ranked, self.search.shortlist, near, least)
            ranked = [gain for gain in ranked if gain not in listed]
            fresh = sorted((self._fitted(selection, gain) for gain in listed), key=_rank)
            options += fresh
            for one in fresh:
                if not worth(one.over, len(one.added.effect.parameters), len(one.unseen)):
                    continue
                p = self.chance(one)
                if p < CAUSE_LEVEL and self._closes_enough(one, selection):
                    one, p = self.off_bound(one, p, options)
                    rivals = [other for other in options if other is not one and other not in usual]
                    return one, p, tuple(sorted(rivals, key=_rank))
                if self.healthy is None:
                    return one, 1.0, ()
                usual.append(one)  # healthy runs show it as well: no rival of what is new
                least_p = min(least_p, max(p, CAUSE_LEVEL))
        return (min(options, key=_rank), least_p, ()) if options else None

    def _fitted(self, selection: Selection, gain: Gain) -> Option:
        added = gain.signature.candidate
        start = (*selection.fitted.causes, added.cause(gain.values))
        return fit_option(self.evidence, added, start, selection.unseen, self.search.rounds)

    def _closes_enough(self, one: Option, selection: Selection) -> bool:
        if self.healthy is None:
            least = self.search.least_gain * float(selection.unseen.sum())
            share = share_of(self.evidence, one, selection.fitted, 0.0)
            return one.over.nats >= least and share >= self.search.least_share
        if not selection.steps:
            return True
        usual = usual_score(self.evidence, self.healthy)
        return share_of(self.evidence, one, selection.fitted, usual) >= REST_SHARE

    def off_bound(self, best: Option, p: float, options: Sequence[Option]) -> tuple[Option, float]:
        """Prefer to one fitted to its bound another that is no farther behind than the misfit hides."""
        if self.healthy is None or not on_bound(best):
            return best, p
        left = nats_beyond(self.evidence, best.unseen, self.healthy)
        for other in sorted(options, key=lambda o: -o.over.nats):
            near = best.over.nats - other.over.nats < HIDDEN_SHARE * left
            if other is best or not near or on_bound(other):
                continue
            other_p = self.chance(other)
            if other_p < CAUSE_LEVEL:
                return other, other_p
        return best, p

    def swapped(self, selection: Selection) -> Selection:
        """Put a rival in a cause's place where the whole set then predicts better."""
        for at in range(len(selection.steps) if len(selection.steps) > 1 else 0):
            step, causes = selection.steps[at], selection.fitted.causes
            others = {(c.effect, c.joints) for c in _without(causes, at)}
            for rival in step.rivals[:2]:
                if rival.added.key in others:
                    continue
                start = (*causes[:at], rival.cause, *causes[at + 1 :])
                option = fit_option(self.evidence, rival.added, start, selection.unseen)
                ahead = option.over.nats > max(option.over.error, 2.0)
                if ahead and self.chance(option) < CAUSE_LEVEL:
                    rivals = (step.chosen, *(r for r in step.rivals if r is not rival))
                    steps = (
                        *selection.steps[:at],
                        Step(option, rivals),
                        *selection.steps[at + 1 :],
                    )
                    selection = Selection(option.fitted, option.unseen, steps, selection.p)
                    break
        return selection


def _rank(option: Option) -> tuple[float, object]:
    """Order of options: a parameter more must be worth a nat, or a patch below all feet is a level."""
    return len(option.added.effect.parameters) - option.over.nats, option.added.key


def _without(causes: tuple[Cause, ...], at: int) -> tuple[Cause, ...]:
    return (*causes[:at], *causes[at + 1 :])


def _dropped(evidence: Evidence, selection: Selection, count: int) -> Selection:
    """Drop causes that others have made idle, of the first so many."""
    at = 0
    while len(selection.steps) > 1 and at < count:
        fitted = fit_causes(evidence, _without(selection.fitted.causes, at))
        unseen = unseen_score(evidence, fitted)
        loss = advantage(selection.unseen, unseen, evidence.block_part)
        effect = selection.steps[at].chosen.added.effect
        idle = _idle(effect, selection.fitted.causes[at])
        if not idle and worth(loss, len(effect.parameters), len(unseen)):
            at += 1
            continue
        steps = (*selection.steps[:at], *selection.steps[at + 1 :])
        selection, count = Selection(fitted, unseen, steps, selection.p), count - 1
    return selection


def _idle(effect: Effect, cause: Cause) -> bool:
    """Whether a cause was fitted to where it does nothing; a law never is."""
    return bool(effect.parameters) and all(
        abs(value - p.neutral) < IDLE * p.spread
        for p, value in zip(effect.parameters, cause.values, strict=True)
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
