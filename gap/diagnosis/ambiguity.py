"""Which candidates these runs cannot tell from the ones that were named."""

from dataclasses import dataclass

import numpy as np

from gap.residuals.evidence import Evidence
from gap.search.cross_validation import advantage
from gap.search.fit import Fitted
from gap.search.options import MISFIT_SHARE, Option
from gap.search.selection import Selection, Step
from model.values.arrays import FloatArray

# A likelihood-ratio choice then errs once in a hundred times.
ENOUGH_SEPARATION = 4 * 2.33**2
ERRORS = 2.0
MOST_ALIKE = 2


@dataclass(frozen=True, slots=True)
class Alike:
    """A rival that cannot be ruled out.

    Attributes:
        cause: Number of the cause that was named.
        effect: The rival's effect.
        joints: The rival's joints.
        separation: Energy between what the two predict, in units of noise.
        behind: Nats by which the rival predicts unseen blocks worse.
        error: Standard error of that.
    """

    cause: int
    effect: str
    joints: tuple[str, ...]
    separation: float
    behind: float
    error: float


def alike(evidence: Evidence, selection: Selection, left_nats: float) -> tuple[Alike, ...]:
    """Return every rival that these runs leave open, nearest first.

    Args:
        evidence: What was fitted to.
        selection: The causes.
        left_nats: What they leave beyond what a healthy machine does.
    """
    found: list[Alike] = []
    named = {step.chosen.added.key for step in selection.steps}
    for number, step in enumerate(selection.steps):
        # what was named beside a cause later on does not stand in its place
        others = [rival for rival in step.rivals if rival.added.key not in named]
        own = [_compare(evidence, number, step, rival) for rival in others]
        open_ones = [
            one
            for one in own
            if _looks_the_same(one)
            or _predicts_as_well(one)
            or one.behind < MISFIT_SHARE * left_nats
        ]
        found += sorted(open_ones, key=lambda one: one.behind)[:MOST_ALIKE]
    return tuple(found)


def why_open(one: Alike) -> str:
    """Say why a rival cannot be ruled out."""
    if _looks_the_same(one):
        return f"separation {one.separation:.2g}, {ENOUGH_SEPARATION:.0f} would tell"
    if _predicts_as_well(one):
        return f"it predicts what it has not seen worse by {one.behind:.2g} +- {one.error:.2g} nats only"
    return (
        f"it is {one.behind:.2g} nats behind, less than {MISFIT_SHARE:.0%} of what all causes leave "
        "unexplained"
    )


def _looks_the_same(one: Alike) -> bool:
    return one.separation < ENOUGH_SEPARATION


def _predicts_as_well(one: Alike) -> bool:
    return one.behind < ERRORS * one.error and one.behind < ENOUGH_SEPARATION


def _compare(evidence: Evidence, number: int, step: Step, rival: Option) -> Alike:
    weights = evidence.weights(step.chosen.fitted.residual)
    # not the other way round: a cause of any size imitates a rival that does nothing
    apart = separation(step.chosen.fitted, rival.fitted, weights)
    ahead = advantage(step.chosen.unseen, rival.unseen, evidence.block_part)
    return Alike(
        number, rival.added.effect.name, rival.added.joints, apart, ahead.nats, ahead.error
    )


def separation(of: Fitted, by: Fitted, weights: FloatArray) -> float:
    """Energy that is left between two predictions when one is adjusted to the other.

    Args:
        of: What is to be imitated.
        by: What is adjusted, to first order.
        weights: Weight of each residual, (F, C).
    """
    apart = by.residual - of.residual
    weighted = apart * weights
    left = float((weighted * apart).sum())
    if len(by.away):
        flat = by.slopes.reshape(len(by.away), -1)
        scaled = flat * weights.ravel()
        gram = scaled @ flat.T + np.eye(len(by.away))
        pull = scaled @ apart.ravel()
        left -= float(pull @ np.linalg.solve(gram, pull))
    return max(left, 0.0)
