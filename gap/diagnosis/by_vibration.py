"""Causes whose predictions are alike and that vibration tells apart.

What feet that stick and slip do frame by frame is chance: of two effects with the same mean, the one that
follows it a little better is not for that the likelier one. So what was measured without any prediction
decides, and what two predictions differ by counts as it does in probabilities.
"""

from collections.abc import Collection
from dataclasses import replace

from gap.constants import VIBRATION_CLEAR
from gap.diagnosis.probability import behind_of, vibration_nats_of, weight_of
from gap.residuals.evidence import Evidence
from gap.search.candidates import families_of
from gap.search.look import Selection, Step
from gap.search.options import Option, fit_option, nats_beyond


def settled_by_vibration(
    evidence: Evidence, selection: Selection, healthy: Evidence | None
) -> Selection:
    """Return the selection with an alternative in a cause's place where vibration makes it likelier."""
    left = max(0.0, nats_beyond(evidence, selection.unseen, healthy))
    for at, step in enumerate(selection.steps):
        causes = selection.fitted.causes
        taken = families_of((*causes[:at], *causes[at + 1 :]), evidence.effects)
        likelier = [
            one
            for one in step.rivals
            if one.added.family not in taken and _odds(evidence, one, step.chosen, left) > 1.0
        ]
        if likelier:
            rival = max(likelier, key=lambda one: _odds(evidence, one, step.chosen, left))
            start = (*causes[:at], rival.cause, *causes[at + 1 :])
            option = fit_option(evidence, rival.added, start, selection.unseen)
            gained = replace(option.over, nats=step.chosen.over.nats + option.over.nats)
            others = tuple(one for one in step.rivals if one is not rival)
            kept = Step(replace(option, over=gained), (step.chosen, *others))
            steps = (*selection.steps[:at], kept, *selection.steps[at + 1 :])
            selection = Selection(option.fitted, option.unseen, steps, selection.p)
    return selection


def _odds(evidence: Evidence, rival: Option, chosen: Option, left_nats: float) -> float:
    """Odds of an alternative for which vibration speaks; 0 where it does not."""
    nats = vibration_nats_of(rival, chosen)
    if nats >= 0.0:
        return 0.0
    return weight_of(behind_of(rival, chosen, evidence.block_part), left_nats, nats)


def shaken_channels(selection: Selection) -> Collection[str]:
    """Return the names of channels that surely vibrate because of a cause."""
    chosen = [step.chosen.added for step in selection.steps]
    return {
        name
        for one in chosen
        if one.effect.shaking and one.shaken >= VIBRATION_CLEAR
        for name in one.effect.shaking.channels
    }
