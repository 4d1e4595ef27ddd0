"""A law that is worth little alone, with the cause that makes it worth much.

A law of friction has no size, and other numbers have adjusted to its absence: dry friction on legs that do
not give is little better than wet friction, or worse, and legs that give are little better under wet
friction. Both together explain a fifth of what healthy runs show. So a law is put in on trial, whatever it
does alone, and stays if it and what comes next are each worth it with the other, and both together. A law
that hardly changes the prediction cannot gain so much with any other, and is not tried.
"""

from collections.abc import Sequence

from gap.search.candidates import Candidate, families_of
from gap.search.cross_validation import advantage
from gap.search.look import Look
from gap.search.options import Option, fit_option, worth
from gap.search.replacement import without
from gap.search.screen import make_signatures
from gap.search.steps import Selection, Step


def law_with_partner(
    look: Look, selection: Selection, candidates: Sequence[Candidate]
) -> Selection | None:
    """Return the selection with a law and the cause that belongs to it; None where no two are worth it.

    Args:
        look: Says what is fitted to, and when a cause is worth it.
        selection: The causes so far.
        candidates: All of them.
    """
    taken = families_of(selection.fitted.causes, look.evidence.effects)
    for law in candidates:
        if law.effect.parameters or law.family in taken:
            continue
        start = (*selection.fitted.causes, law.cause(()))
        option = fit_option(look.evidence, law, start, selection.unseen, look.search.rounds)
        # a partner that leaves much less by itself would have been taken before
        change = option.fitted.residual - selection.fitted.residual
        if look.evidence.most_gained(change) < look.least_nats(selection.unseen):
            continue
        both = _with_partner(look, selection, option, candidates)
        if both is not None:
            return both
    return None


def _with_partner(
    look: Look, selection: Selection, law: Option, candidates: Sequence[Candidate]
) -> Selection | None:
    """Return the selection with the law and the best other cause, if each is worth it."""
    evidence = look.evidence
    on_trial = Selection(law.fitted, law.unseen, (*selection.steps, Step(law, ())), selection.p)
    signatures = make_signatures(evidence, candidates, law.fitted.causes, lambda _: None)
    added = look.one_more(on_trial, signatures)
    if added is None or added.p >= look.level(law.fitted):
        return None
    partner = added.chosen
    at = len(selection.steps)
    alone = fit_option(
        evidence, partner.added, without(partner.fitted.causes, at), selection.unseen,
        look.search.rounds,
    )  # fmt: skip
    lost = advantage(partner.unseen, alone.unseen, evidence.block_part)
    if lost.nats < look.least_nats(alone.unseen) or not worth(lost, 0, len(alone.unseen)):
        return None
    both = advantage(partner.unseen, selection.unseen, evidence.block_part)
    if not worth(both, len(partner.added.effect.parameters), len(alone.unseen)):
        return None
    steps = (*on_trial.steps, added)
    return Selection(partner.fitted, partner.unseen, steps, selection.p)
