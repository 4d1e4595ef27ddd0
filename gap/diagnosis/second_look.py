"""Without references, a second look for causes that are small beside what the simulator has wrong.

The first causes are then mostly laws that the simulator lacks, and one cause in one leg is small beside
them: it explains next to nothing of the whole. It may still be most of what is left in the channels in
which it acts. So it is named if its joint is unlike the others, or if an effect of the whole machine gains
as much of the score as a baseline model error must, if it explains its part of what is left there, and if
held-out runs are clearly predicted better with it, each stage fed with what was measured.
"""

from collections.abc import Sequence

from gap.constants import FALSE_ALARMS, LAW_GAIN, REST_SHARE
from gap.diagnosis.gap_evidence import GapEvidence
from gap.diagnosis.held_stage import helps_its_stage
from gap.search.candidates import Candidate, families_of
from gap.search.look import Selection, Step
from gap.search.options import Option, fit_option, share_of, worth
from gap.search.screen import Signatures, gains, make_signatures
from gap.search.unlike import unlike_joints

MOST_MORE = 3  # causes
FITTED = 3  # candidates at each step


def second_look(comparison: GapEvidence, selection: Selection) -> Selection:
    """Return the selection with the causes that stand out beside those that are named.

    Args:
        comparison: Trials against the simulator; with references there is no second look.
        selection: The causes so far.
    """
    if comparison.study.references:
        return selection
    evidence = comparison.evidence
    signatures = make_signatures(
        evidence, comparison.candidates, selection.fitted.causes, lambda _: None
    )
    for _ in range(MOST_MORE):
        step = _one_joint(comparison, selection, signatures) or _whole_machine(
            comparison, selection, signatures
        )
        if step is None:
            break
        option = step.chosen
        steps = (*selection.steps, step)
        selection = Selection(option.fitted, option.unseen, steps, selection.p)
    return selection


def _one_joint(
    comparison: GapEvidence, selection: Selection, signatures: Signatures
) -> Step | None:
    """Return the cause at a joint that is unlike the others, if there is one."""
    evidence, residual = comparison.evidence, selection.fitted.residual
    taken = families_of(selection.fitted.causes, evidence.effects)
    found = unlike_joints(signatures, residual, evidence.weights(residual), taken)
    starts = [(one.candidate, one.values) for one in found[:FITTED] if one.chance < FALSE_ALARMS]
    options = [_fitted(comparison, selection, one, values) for one, values in starts]
    return _best(comparison, selection, options, 0.0)


def _whole_machine(
    comparison: GapEvidence, selection: Selection, signatures: Signatures
) -> Step | None:
    """Return the cause on the whole machine that gains as much as a baseline model error, if any does."""
    evidence, residual = comparison.evidence, selection.fitted.residual
    taken = families_of(selection.fitted.causes, evidence.effects)
    least = LAW_GAIN * float(selection.unseen.sum())
    ranked = [
        gain
        for gain in gains(signatures, residual, evidence.weights(residual))
        if not gain.signature.candidate.joints
        and gain.signature.candidate.family not in taken
        and gain.nats >= least
    ]
    options = [
        _fitted(comparison, selection, gain.signature.candidate, gain.values)
        for gain in ranked[:FITTED]
    ]
    return _best(comparison, selection, options, least)


def _fitted(
    comparison: GapEvidence, selection: Selection, added: Candidate, values: Sequence[float]
) -> Option:
    start = (*selection.fitted.causes, added.cause(values))
    return fit_option(comparison.evidence, added, start, selection.unseen)


def _best(
    comparison: GapEvidence, selection: Selection, options: Sequence[Option], least: float
) -> Step | None:
    """Return the best that stands out, with the others as its alternatives."""
    evidence = comparison.evidence
    ranked = sorted(options, key=lambda one: -one.over.nats)
    for option in ranked:
        clear = worth(option.over, len(option.added.effect.parameters), len(option.unseen))
        share = share_of(evidence, option, selection.fitted, 0.0)
        if not clear or option.over.nats < least or share < REST_SHARE:
            continue
        if helps_its_stage(comparison, option.fitted.causes, len(selection.steps)):
            return Step(option, tuple(one for one in ranked if one is not option))
    return None
