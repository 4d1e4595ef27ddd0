"""Causes whose predictions are alike and that vibration tells apart.

What feet that stick and slip do frame by frame is chance: of two effects with the same mean, the one that
follows it a little better is not for that the likelier one. So what was measured without any prediction
decides, and what two predictions differ by counts as it does in probabilities.
"""

from collections.abc import Collection
from dataclasses import replace

from gap.diagnosis.alternatives.probability import behind_of, blur_of, vibration_nats_of, weight_of
from gap.residuals.evidence import Evidence
from gap.search.candidates import families_of
from gap.search.options import Option, nats_beyond
from gap.search.replacement import fitted_for, in_its_place, without
from gap.search.steps import Selection


def settled_by_vibration(
    evidence: Evidence, selection: Selection, healthy: Evidence | None
) -> Selection:
    """Return the selection with an alternative in a cause's place where vibration makes it likelier."""
    left = max(0.0, nats_beyond(evidence, selection.unseen, healthy))
    for at, step in enumerate(selection.steps):
        taken = families_of(without(selection.fitted.causes, at), evidence.effects)
        likely = [
            (_odds(evidence, rival, step.chosen, left), rival)
            for rival in step.rivals
            if rival.added.family not in taken
        ]
        odds, rival = max(likely, key=lambda pair: pair[0], default=(0.0, step.chosen))
        if odds <= 1.0:
            continue
        option = fitted_for(evidence, selection, at, rival)
        gained = replace(option.over, nats=step.chosen.over.nats + option.over.nats)
        selection = in_its_place(selection, at, replace(option, over=gained))
    return selection


def _odds(evidence: Evidence, rival: Option, chosen: Option, left_nats: float) -> float:
    """Odds of an alternative for which vibration speaks; 0 where it does not."""
    nats = vibration_nats_of(rival, chosen)
    if nats >= 0.0:
        return 0.0
    behind = behind_of(rival, chosen, evidence.block_part)
    return weight_of(behind, blur_of(behind, left_nats, chosen.over.nats), nats)


def shaken_channels(selection: Selection) -> Collection[str]:
    """Return the names of channels that surely vibrate because of a cause."""
    chosen = [step.chosen.added for step in selection.steps]
    return {
        name
        for one in chosen
        if one.effect.shaking and one.vibrates
        for name in one.effect.shaking.channels
    }
