"""Causes against held-out runs: one that makes them worse is not named."""

from gap.diagnosis.gap_evidence import GapEvidence
from gap.diagnosis.how_far import HowFar, how_far
from gap.search.cross_validation import unseen_score
from gap.search.fit import fit_causes
from gap.search.look import Selection
from gap.search.replacement import without


def drop_worse(
    comparison: GapEvidence, selection: Selection, seed: int
) -> tuple[Selection, HowFar]:
    """Drop the causes without which held-out runs are clearly predicted better, the worst first.

    Returns the causes that are left, fitted again, and how far the gap shrinks with them. Where one was
    dropped, held-out runs have had a say in which causes are named, not in their sizes.
    """
    far = how_far(comparison.held, selection.fitted.causes, seed)
    while any(far.worse):
        at = min((i for i, worse in enumerate(far.worse) if worse), key=lambda i: far.last[i])
        fitted = fit_causes(comparison.evidence, without(selection.fitted.causes, at))
        steps = (*selection.steps[:at], *selection.steps[at + 1 :])
        unseen = unseen_score(comparison.evidence, fitted)
        selection = Selection(fitted, unseen, steps, selection.p)
        far = how_far(comparison.held, selection.fitted.causes, seed)
    return selection, far
