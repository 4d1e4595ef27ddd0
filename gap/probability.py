"""Probabilities of causes, and of none of them.

The constants are to be fitted once, on a development campaign, and then left alone. The defaults were set
by hand: a rival two nats behind is 0.37 times as likely, and causes that close 95 % of the gap with a
residual near its expectation leave 2 % for none of them.
"""

import math
from dataclasses import dataclass

from gap.cross_validation import advantage
from gap.selection import Selection


@dataclass(frozen=True, slots=True)
class Calibration:
    """Constants.

    Attributes:
        temperature: Nats that count as one.
        error_share: Temperature for each nat of standard error between two candidates.
        none: Log odds of none of them when everything is closed down to expectation.
        none_energy: Added for each e-fold of energy over expectation that is left.
        none_open: Added for the whole gap being left open.
    """

    temperature: float = 2.0
    error_share: float = 0.5
    none: float = -4.5
    none_energy: float = 0.3
    none_open: float = 9.0


@dataclass(frozen=True, slots=True)
class Chance:
    """Probability of one candidate for a cause."""

    effect: str
    joints: tuple[str, ...]
    probability: float


def none_of_them(closed: float, excess: float, calibration: Calibration) -> float:
    """Return the probability that the cause is none of the catalogue.

    Args:
        closed: Share of the explainable gap that the causes close, 0 to 1.
        excess: Energy over expectation that is left.
        calibration: Constants.
    """
    logit = calibration.none + calibration.none_open * (1.0 - closed)
    logit += calibration.none_energy * math.log(max(excess, 1.0))
    return 1.0 / (1.0 + math.exp(-logit))


def chances(
    selection: Selection, none: float, calibration: Calibration
) -> tuple[tuple[Chance, ...], ...]:
    """Return, for each cause, the probability of the named one and of each rival."""
    out = []
    for step in selection.steps:
        weights = [1.0]
        options = [step.chosen, *step.rivals]
        for rival in step.rivals:
            behind = advantage(step.chosen.unseen, rival.unseen)
            scale = calibration.temperature + calibration.error_share * behind.error
            weights.append(math.exp(-max(min(behind.nats / scale, 700.0), -20.0)))
        total = sum(weights)
        out.append(
            tuple(
                Chance(o.added.effect.name, o.added.joints, (1.0 - none) * w / total)
                for o, w in zip(options, weights, strict=True)
            )
        )
    return tuple(out)
