"""A selection that can change its mind: each named cause against what could stand in its place.

Taking one cause after the other never comes back: what was taken first, before its partner was known,
stays. So after each step every cause is taken out once, and its rivals and the best candidates for what is
then left are fitted in its place. The set that predicts held-out blocks best stays.
"""

from collections.abc import Iterator

from gap.constants import AHEAD_NATS
from gap.interfaces import Cause
from gap.search.candidates import Candidate
from gap.search.fit import fit_causes
from gap.search.look import Look, Selection, Step
from gap.search.options import CAUSE_LEVEL, Option, fit_option
from gap.search.screen import Signatures, gains

MOST_ROUNDS = 2
RIVALS, FRESH = 2, 2  # candidates that are fitted in a cause's place: of its own step, and new ones
NEAR_AS_GOOD = 0.7  # of what its cause gains to first order, that a new candidate must gain


def replaced(look: Look, selection: Selection, signatures: Signatures) -> Selection:
    """Put another candidate in a cause's place where the whole set then predicts better.

    Args:
        look: Decides what is new.
        selection: The causes so far; a single one has just been chosen among its rivals.
        signatures: Of every candidate.
    """
    for _ in range(MOST_ROUNDS):
        before = selection
        for at in range(len(selection.steps) if len(selection.steps) > 1 else 0):
            selection = _better_at(look, selection, signatures, at)
        if selection is before:
            break
    return selection


def _better_at(look: Look, selection: Selection, signatures: Signatures, at: int) -> Selection:
    """Return the selection with the best candidate at one place."""
    step, causes = selection.steps[at], selection.fitted.causes
    best: tuple[Candidate, Option] | None = None
    for added, cause in _others(look, selection, signatures, at):
        start = (*causes[:at], cause, *causes[at + 1 :])
        option = fit_option(look.evidence, added, start, selection.unseen)
        ahead = option.over.nats > max(option.over.error, AHEAD_NATS)
        if ahead and (best is None or option.over.nats > best[1].over.nats):
            best = added, option
    if best is None or look.chance(best[1]) >= CAUSE_LEVEL:
        return selection
    added, option = best
    rivals = (step.chosen, *(one for one in step.rivals if one.added.key != added.key))
    steps = (*selection.steps[:at], Step(option, rivals), *selection.steps[at + 1 :])
    return Selection(option.fitted, option.unseen, steps, selection.p)


def _others(
    look: Look, selection: Selection, signatures: Signatures, at: int
) -> Iterator[tuple[Candidate, Cause]]:
    """Candidates for the place of a cause, with the values to begin from."""
    causes = selection.fitted.causes
    kept = without(causes, at)
    taken = {(one.effect, one.joints) for one in kept}
    own = (causes[at].effect, causes[at].joints)
    tried = {own}
    for rival in selection.steps[at].rivals[:RIVALS]:
        if rival.added.key not in taken:
            tried.add(rival.added.key)
            yield rival.added, rival.cause
    left = fit_causes(look.evidence, kept).residual
    ranked = gains(signatures, left, look.evidence.weights(left))
    own_gain = next((one.nats for one in ranked if one.signature.candidate.key == own), 0.0)
    fresh = [
        one
        for one in ranked
        if one.signature.candidate.key not in taken | tried and one.nats > NEAR_AS_GOOD * own_gain
    ]
    for one in fresh[:FRESH]:
        yield one.signature.candidate, one.signature.candidate.cause(one.values)


def without(causes: tuple[Cause, ...], at: int) -> tuple[Cause, ...]:
    """Return causes without one of them."""
    return (*causes[:at], *causes[at + 1 :])
