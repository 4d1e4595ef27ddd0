"""Probabilities of causes, and of none of them.

The constants are to be fitted once, on a development campaign, and then left alone. The defaults were set
by hand: a rival two nats behind is 0.37 times as likely, and causes that close 95 % of the gap with a
residual near its expectation leave 2 % for none of them.
"""

import math
from dataclasses import dataclass

from gap.search.cross_validation import advantage
from gap.search.selection import Selection
from model.values.arrays import IntArray

SURELY_ODD = 0.01  # chance below which what is left counts as open in full


@dataclass(frozen=True, slots=True)
class Calibration:
    """Constants.

    Attributes:
        temperature: Nats that count as one.
        error_share: Temperature for each nat of standard error between two candidates.
        misfit_share: Temperature for each nat that the causes leave beyond a healthy machine: what the
            simulator has wrong of them may hide as much of a rival.
        none: Log odds of none of them when everything is closed down to expectation.
        none_energy: Added for each e-fold of energy over expectation that is left.
        none_open: Added for the whole gap being left open, with references.
        none_open_alone: The same without: what is left is then no sign that what was found is wrong.
        none_worst: Added for each e-fold of the worst channel's energy over expectation, with references.
        none_worst_alone: The same without references, where the expectation is noise alone.
        none_many: Added for each cause above two, with references: what is new needs no patchwork.
    """

    temperature: float = 2.0
    error_share: float = 0.5
    misfit_share: float = 0.02
    none: float = -5.5
    none_energy: float = 0.3
    none_open: float = 9.0
    none_open_alone: float = 6.0
    none_worst: float = 0.25
    none_worst_alone: float = 0.1
    none_many: float = 1.0


@dataclass(frozen=True, slots=True)
class Chance:
    """Probability of one candidate for a cause.

    Attributes:
        effect: Its name.
        joints: Where.
        probability: That it is this one.
        behind: Nats by which it predicts unseen blocks worse than the named one.
        error: Standard error of that.
    """

    effect: str
    joints: tuple[str, ...]
    probability: float
    behind: float
    error: float


@dataclass(frozen=True, slots=True)
class Left:
    """What is left when the causes are added, in the trials that were fitted to, by cross-validation.

    Attributes:
        closed: Share of the explainable gap that the causes close, 0 to 1.
        excess: Energy over expectation.
        worst: The same of the worst channel.
        causes: How many causes there are.
        referenced: Whether the expectation comes from references.
        p: Chance of so much left in a healthy machine; 0 where there is none to compare with.
    """

    closed: float
    excess: float
    worst: float
    causes: int
    referenced: bool
    p: float = 0.0


def none_of_them(left: Left, calibration: Calibration) -> float:
    """Return the probability that the cause is none of the catalogue."""
    worst, wide = calibration.none_worst_alone, calibration.none_open_alone
    if left.referenced:
        worst, wide = calibration.none_worst, calibration.none_open
    # what a healthy machine leaves as well is no sign that something is missing
    odd = min(1.0, -math.log(max(left.p, 1e-9)) / -math.log(SURELY_ODD))
    logit = calibration.none + odd * wide * (1.0 - left.closed)
    logit += odd * calibration.none_energy * math.log(max(left.excess, 1.0))
    logit += odd * worst * math.log(max(left.worst, 1.0))
    if left.referenced:
        logit += calibration.none_many * max(0, left.causes - 2)
    return 1.0 / (1.0 + math.exp(-logit))


def chances(
    selection: Selection, strata: IntArray, none: float, left_nats: float, calibration: Calibration
) -> tuple[tuple[Chance, ...], ...]:
    """Return, for each cause, the probability of the named one and of each rival."""
    out = []
    for step in selection.steps:
        weights = [1.0]
        options = [step.chosen, *step.rivals]
        behinds = [advantage(step.chosen.unseen, one.unseen, strata) for one in options]
        for behind in behinds[1:]:
            scale = calibration.temperature + calibration.error_share * behind.error
            scale += calibration.misfit_share * left_nats
            weights.append(math.exp(-max(min(behind.nats / scale, 700.0), 0.0)))
        total = sum(weights)
        out.append(
            tuple(
                Chance(
                    o.added.effect.name, o.added.joints, (1.0 - none) * w / total, b.nats, b.error
                )
                for o, w, b in zip(options, weights, behinds, strict=True)
            )
        )
    return tuple(out)
