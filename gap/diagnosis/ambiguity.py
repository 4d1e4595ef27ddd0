"""Which candidates these runs cannot tell from the ones that were named."""

from dataclasses import dataclass

import numpy as np

from gap.residuals.evidence import Evidence
from gap.search.cross_validation import CLEAR_ERRORS, advantage
from gap.search.fit import ENOUGH_SEPARATION, Fitted, energy_left
from gap.search.options import HIDDEN_SHARE, Option
from gap.search.selection import Selection, Step
from model.values.arrays import FloatArray

MOST_OPEN = 2


@dataclass(frozen=True, slots=True)
class OpenRival:
    """A rival that cannot be ruled out.

    Attributes:
        cause: Number of the cause that was named.
        effect: The rival's effect.
        joints: The rival's joints.
        separation: Energy between what the two predict, in units of noise.
        behind: Nats by which the rival predicts unseen blocks worse.
        error: Standard error of that.
        of: Effect and joints of the cause that was named.
    """

    cause: int
    effect: str
    joints: tuple[str, ...]
    separation: float
    behind: float
    error: float
    of: tuple[str, tuple[str, ...]]

    @property
    def looks_the_same(self) -> bool:
        """Whether the two predict the same within noise."""
        return self.separation < ENOUGH_SEPARATION

    @property
    def predicts_as_well(self) -> bool:
        """Whether it predicts unseen blocks as well within the scatter of blocks."""
        return self.behind < CLEAR_ERRORS * self.error and self.behind < ENOUGH_SEPARATION

    @property
    def why(self) -> str:
        """Why it cannot be ruled out."""
        if self.looks_the_same:
            return f"separation {self.separation:.2g}, {ENOUGH_SEPARATION:.0f} would tell"
        if self.predicts_as_well:
            worse = f"{self.behind:.2g} +- {self.error:.2g} nats"
            return f"it predicts what it has not seen worse by {worse} only"
        return (
            f"it is {self.behind:.2g} nats behind, less than {HIDDEN_SHARE:.0%} of what all causes "
            "leave unexplained"
        )


def open_rivals(
    evidence: Evidence, selection: Selection, left_nats: float
) -> tuple[OpenRival, ...]:
    """Return every rival that these runs leave open, nearest first.

    Args:
        evidence: What was fitted to.
        selection: The causes.
        left_nats: What they leave beyond what a healthy machine does.
    """
    found: list[OpenRival] = []
    named = {step.chosen.added.key for step in selection.steps}
    for number, step in enumerate(selection.steps):
        # what was named as another cause later on does not stand in its place
        others = [rival for rival in step.rivals if rival.added.key not in named]
        own = [_compare(evidence, number, step, rival) for rival in others]
        left_open = [
            one
            for one in own
            if one.looks_the_same or one.predicts_as_well or one.behind < HIDDEN_SHARE * left_nats
        ]
        found += sorted(left_open, key=lambda one: one.behind)[:MOST_OPEN]
    return tuple(found)


def _compare(evidence: Evidence, number: int, step: Step, rival: Option) -> OpenRival:
    weights = evidence.weights(step.chosen.fitted.residual)
    # not the other way round: a cause of any size imitates a rival that does nothing
    apart = separation(step.chosen.fitted, rival.fitted, weights)
    ahead = advantage(step.chosen.unseen, rival.unseen, evidence.block_part)
    effect, joints = rival.added.key
    of = step.chosen.added.key
    return OpenRival(number, effect, joints, apart, ahead.nats, ahead.error, of)


def separation(of: Fitted, by: Fitted, weights: FloatArray) -> float:
    """Energy that is left between two predictions when one is adjusted to the other.

    Args:
        of: What is to be imitated.
        by: What is adjusted, to first order.
        weights: Weight of each residual, (F, C).
    """
    root = np.sqrt(weights)
    return energy_left((by.residual - of.residual) * root, by.slopes * root, prior=1.0)
