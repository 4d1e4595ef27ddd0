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
class RivalCause:
    """A candidate that was fitted and not taken.

    Attributes:
        cause: Number of the cause it was a rival of.
        probability: That it is this one instead.
        behind: Nats by which it predicts unseen blocks worse.
        of: Effect and joints of the cause it was a rival of.
    """

    cause: int
    effect: str
    joints: tuple[str, ...]
    probability: float
    behind: float
    behind_error: float
    of: tuple[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Fit:
    """What the causes explain in the trials that were fitted to, by cross-validation.

    Attributes:
        closed: Share of the explainable gap that they close, 0 to 1.
        excess_before: Energy over expectation without them.
        excess_after: The same with them.
        worst_after: The same of the worst channel.
        p_after: Chance of so much left in a healthy machine; 0 where there is none to compare with.
        nats_after: Score that is left beyond that of a healthy machine.
    """

    closed: float
    excess_before: float
    excess_after: float
    worst_after: float
    p_after: float
    nats_after: float


def none_of_them(
    fit: Fit, causes: int, referenced: bool, calibration: Calibration = Calibration()
) -> float:
    """Return the probability that the cause is none of the catalogue.

    Args:
        fit: What the causes explain.
        causes: How many there are.
        referenced: Whether the expectation comes from references.
        calibration: Constants.
    """
    worst, wide = calibration.none_worst_alone, calibration.none_open_alone
    if referenced:
        worst, wide = calibration.none_worst, calibration.none_open
    # what a healthy machine leaves as well is no sign that something is missing
    odd = min(1.0, -math.log(max(fit.p_after, 1e-9)) / -math.log(SURELY_ODD))
    logit = calibration.none + odd * wide * (1.0 - fit.closed)
    logit += odd * calibration.none_energy * math.log(max(fit.excess_after, 1.0))
    logit += odd * worst * math.log(max(fit.worst_after, 1.0))
    if referenced:
        logit += calibration.none_many * max(0, causes - 2)
    return 1.0 / (1.0 + math.exp(-logit))


def chances(
    selection: Selection,
    strata: IntArray,
    none: float,
    left_nats: float,
    calibration: Calibration = Calibration(),
) -> tuple[tuple[float, tuple[RivalCause, ...]], ...]:
    """Return the probability of each cause, and its rivals with theirs.

    Args:
        selection: The causes.
        strata: Trial of each block, (B,).
        none: Probability that it is none of the catalogue.
        left_nats: Score that is left beyond that of a healthy machine.
        calibration: Constants.
    """
    out = []
    for i, step in enumerate(selection.steps):
        behinds = [advantage(step.chosen.unseen, one.unseen, strata) for one in step.rivals]
        weights = []
        for behind in behinds:
            scale = calibration.temperature + calibration.error_share * behind.error
            scale += calibration.misfit_share * left_nats
            weights.append(math.exp(-max(min(behind.nats / scale, 700.0), 0.0)))
        share = (1.0 - none) / (1.0 + sum(weights))
        of = step.chosen.added.key
        rivals = tuple(
            RivalCause(i, *one.added.key, share * weight, behind.nats, behind.error, of)
            for one, weight, behind in zip(step.rivals, weights, behinds, strict=True)
        )
        out.append((share, rivals))
    return tuple(out)
