"""A selection that can change its mind: each named cause against what could stand in its place.

Taking one cause after the other never comes back: what was taken first, before its partner was known,
stays. So at the end every cause is taken out once, and the candidates that explain what is then left as
well to first order are fitted in its place. The set that predicts held-out blocks best stays.
"""

from collections.abc import Collection, Iterator
from dataclasses import replace

from gap.constants import HOPELESS, NEAR_AS_GOOD
from gap.interfaces import Cause
from gap.residuals.at_once import each_of
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate, families_of, too_small
from gap.search.cross_validation import unseen_score
from gap.search.fit import fit_causes
from gap.search.look import Look
from gap.search.options import CAUSE_LEVEL, Option, fit_option
from gap.search.screen import Signatures, gains
from gap.search.steps import Selection

IN_PLACE = 2  # candidates that are fitted in a cause's place
FEW_ROUNDS = 3  # of a fit, that show whether it is worth all of them


def replaced(look: Look, selection: Selection, signatures: Signatures) -> Selection:
    """Put another candidate in a cause's place where the whole set then predicts better.

    Args:
        look: Decides what is new.
        selection: The causes so far; a single one has just been chosen among its alternatives.
        signatures: Of every candidate.
    """
    for at in range(len(selection.steps) if len(selection.steps) > 1 else 0):
        if not selection.steps[at].chosen.added.vibrates:  # vibration named it, not the fit
            selection = _better_at(look, selection, signatures, at)
    return selection


def _better_at(look: Look, selection: Selection, signatures: Signatures, at: int) -> Selection:
    """Return the selection with the best candidate at one place."""
    causes = selection.fitted.causes
    best: Option | None = None

    def fitted(other: tuple[Candidate, Cause]) -> Option:
        added, cause = other
        start = (*causes[:at], cause, *causes[at + 1 :])
        first = fit_option(look.evidence, added, start, selection.unseen, 1, selection.fitted)
        if -first.over.nats > HOPELESS * max(selection.steps[at].chosen.over.nats, 0.0):
            return first
        return fit_option(
            look.evidence,
            added,
            first.fitted.causes,
            selection.unseen,
            FEW_ROUNDS - 1,
            first.fitted,
        )

    others = list(_others(look, selection, signatures, at))
    options = each_of(others, fitted, look.evidence.predictor.at_once)
    for option in options:
        named = not too_small(option.cause, option.added.effect)
        if option.over.clear and named and (best is None or option.over.nats > best.over.nats):
            best = option
    if best is None or (p := look.chance(best)) >= CAUSE_LEVEL:
        return selection
    return in_its_place(selection, at, best, p)


def fitted_for(evidence: Evidence, selection: Selection, at: int, rival: Option) -> Option:
    """Fit an alternative together with all causes but the one whose place it takes."""
    causes = selection.fitted.causes
    start = (*causes[:at], rival.cause, *causes[at + 1 :])
    return fit_option(evidence, rival.added, start, selection.unseen)


def in_its_place(
    selection: Selection, at: int, option: Option, p: float | None = None
) -> Selection:
    """Return the selection with an option in a cause's place, which becomes an alternative to it.

    ``p`` is the option's chance in a healthy machine; None keeps that of the cause.
    """
    step = selection.steps[at]
    rivals = (step.chosen, *step.rivals)
    rivals = tuple(one for one in rivals if one.added.family != option.added.family)
    own = replace(step, chosen=option, rivals=rivals, p=step.p if p is None else p)
    steps = (*selection.steps[:at], own, *selection.steps[at + 1 :])
    return Selection(option.fitted, option.unseen, steps, selection.p)


def _others(
    look: Look, selection: Selection, signatures: Signatures, at: int
) -> Iterator[tuple[Candidate, Cause]]:
    """Candidates for the place of a cause, with the values to begin from."""
    causes, step = selection.fitted.causes, selection.steps[at]
    kept = without(causes, at)
    own = (causes[at].effect, causes[at].joints)
    others = families_of(kept, look.evidence.effects)
    left = fit_causes(look.evidence, kept, FEW_ROUNDS, near=selection.fitted).residual
    ranked = gains(signatures, left, look.evidence.weights(left))
    own_gain = next((one.nats for one in ranked if one.signature.candidate.key == own), 0.0)
    known = {rival.added.key: rival.cause for rival in step.rivals}
    listed = [
        one.signature.candidate.cause(one.values) if key not in known else known[key]
        for one in ranked
        if (key := one.signature.candidate.key) != own
        and one.signature.candidate.family not in others
        and one.nats > NEAR_AS_GOOD * own_gain
        and one.signature.candidate.family not in step.wider
        and not (look.known is not None and _wider(one.signature.candidate, causes[at]))
    ]
    by_key = {one.signature.candidate.key: one.signature.candidate for one in ranked}
    for cause in listed[:IN_PLACE]:
        yield by_key[cause.effect, cause.joints], cause


def left_out(evidence: Evidence, selection: Selection, numbers: Collection[int]) -> Selection:
    """Return the selection without the causes of some numbers, the others fitted again."""
    kept = [at for at in range(len(selection.steps)) if at not in numbers]
    causes = tuple(selection.fitted.causes[at] for at in kept)
    fitted = fit_causes(evidence, causes, near=selection.fitted)
    steps = tuple(selection.steps[at] for at in kept)
    return Selection(fitted, unseen_score(evidence, fitted), steps, selection.p)


def without(causes: tuple[Cause, ...], at: int) -> tuple[Cause, ...]:
    """Return causes without one of them."""
    return (*causes[:at], *causes[at + 1 :])


def _wider(one: Candidate, cause: Cause) -> bool:
    """Whether a candidate is at every joint, among them the one at which a cause surely is."""
    return bool(set(one.effect.each) & set(cause.joints))
