"""Which size of a cause would be called new: the test of ``gap.search.novelty``, turned round."""

from collections.abc import Sequence

import numpy as np
from scipy import optimize, special

from gap.constants import JOINT_UNLIKE
from gap.search.gait_by_gait import has_gaits
from gap.search.scatter import HealthyScatter, Usual, healthy_scatter
from gap.search.sizes import Sizes, ahead_of

MOST_SQUARE = 1e12  # of a size, in units of the variance of one run
PRECISE = 1e-6


def clear_size(
    seen: Sizes,
    known: Sizes,
    others: Sequence[Sizes],
    parameters: int,
    usual: Usual,
    level: float,
    share: float,
) -> float:
    """Return the size that would have a chance below a level in a share of all sets of such trials.

    By the test of all gaits together: one of two (``gap.search.novelty``), and the more cautious.

    Args:
        seen: Sizes in trials; only their scatter counts.
        known: Sizes in references.
        others: As ``gap.search.novelty.chance_of`` has them.
        parameters: Of the cause.
        usual: How much sizes of other causes scatter, in units of these sizes.
        level: Chance, for this one candidate.
        share: Of the sets of trials that have a cause of this size.
    """
    if not len(seen) or not len(known):
        return float(np.inf)
    # of a harmonic mean; what the other test adds depends on what a cause does in each gait
    of_one = level / 2.0 if has_gaits(seen, known) else level
    scatter = healthy_scatter([seen, known], others, usual.together)
    if scatter.alike.free <= 0.0:
        return float(np.inf)
    error = np.sqrt(ahead_of(seen, known, usual.together.gaits_differ)[1])
    square = clear_square(scatter, max(parameters, 1), of_one)
    return float(error * (np.sqrt(square) + _margin(scatter, share)))


def clear_square(scatter: HealthyScatter, directions: int, level: float) -> float:
    """Return the square of a size whose chance is a level; the most that is sought if none is so rare."""
    unit = scatter.alike.variance

    def beyond(nats: float) -> float:
        return scatter.chance(unit * float(np.exp(nats)), directions) - level

    low, high = -np.log(MOST_SQUARE), np.log(MOST_SQUARE)
    if beyond(high) >= 0.0:
        return unit * MOST_SQUARE
    if beyond(low) <= 0.0:
        return 0.0
    return unit * float(np.exp(optimize.brentq(beyond, low, high, xtol=PRECISE)))


def _margin(scatter: HealthyScatter, share: float) -> float:
    """How far a size is below its mean at the most, in a share of the sets of runs."""
    both = (scatter.alike, 1.0 - float(JOINT_UNLIKE)), (scatter.alone, float(JOINT_UNLIKE))

    def beyond(size: float) -> float:
        each = (
            weight * float(special.stdtr(one.free, size / np.sqrt(one.variance)))
            for one, weight in both
        )
        return sum(each) - share

    deviation = np.sqrt(max(one.variance for one, _ in both))
    free = min(one.free for one, _ in both)
    # the wider and the less sure of the two is at least as far off as both together
    most = deviation * (abs(float(special.stdtrit(free, share))) + PRECISE)
    return float(optimize.brentq(beyond, -most, most, xtol=PRECISE * deviation))
