"""How much the size of a cause differs between runs, steadied by what is like it.

A few references show a scatter badly. So the scatter of a cause at one joint is pooled with that at the
joints at which the effect could act as well, as far as these scatter alike
(``gap.residuals.moderated``). A cause without other joints is steadied in the same way by all other
causes, in units of noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from gap.constants import JOINT_UNLIKE, JOINTS_DIFFER, JOINTS_DIFFER_WORTH
from gap.residuals.moderated import (
    UNKNOWN,
    Scatter,
    bias_of_log,
    prior,
    scatter_of_all,
    steadied,
    trigamma,
    trigamma_inverse,
)
from gap.search.sizes import Sizes, scatter_of, scatters_of
from model.values.arrays import FloatArray

FEWEST_SIZES = 2  # of a joint's references, from which they have a scatter
FEWEST_CAUSES = 8  # from which their variances have a distribution
LEAST_VARIANCE = 1e-6  # of noise's


@dataclass(frozen=True, slots=True)
class Usual:
    """How much causes scatter between healthy runs.

    Attributes:
        together: Between runs of all gaits, which may differ.
        in_gaits: Between runs of one gait.
    """

    together: Scatter = UNKNOWN
    in_gaits: Scatter = UNKNOWN

    def times(self, factor: float) -> "Usual":
        """Return it in other units."""
        return Usual(self.together.times(factor), self.in_gaits.times(factor))


NOTHING_USUAL = Usual()


@dataclass(frozen=True, slots=True)
class UsualScatter:
    """Scatter of causes between healthy runs, in units of what noise alone would make.

    Attributes:
        whole: Of causes of the whole machine.
        joint: Of causes at one joint.
    """

    whole: Usual = NOTHING_USUAL
    joint: Usual = NOTHING_USUAL

    def of(self, at_a_joint: bool) -> Usual:
        """Return that of causes of a kind."""
        return self.joint if at_a_joint else self.whole


def pooled(own: Sequence[Sizes], others: Sequence[Sizes], usual: Scatter = UNKNOWN) -> Scatter:
    """Return the scatter about the mean of each own group, steadied by that at the other joints.

    The more the joints' variances differ among each other, the less the others' are worth. Where there are
    no other joints, ``usual`` steadies it: how much other causes scatter. Gaits differ as in ``usual``.
    """
    square, free = scatter_of(own, usual.gaits_differ)
    alone = Scatter(square / free, free) if free else Scatter(np.inf, 0)
    there = [one for one in others if len(one) >= FEWEST_SIZES]
    if not there:
        return steadied(alone, usual)
    known = own[-1]
    groups = [*there, known] if len(known) >= FEWEST_SIZES else there
    variances = variances_of(groups, usual.gaits_differ)
    logs = np.log(np.maximum(variances, 1e-12 * max(float(variances.mean()), 1e-300)))
    frees = np.array([len(one) - 1.0 for one in groups])
    prior_free = 2.0 * trigamma_inverse(_differ(logs, frees))
    # the joint's own runs have half a say at least: it may be the one that is unlike the others
    prior_free = min(prior_free, max(float(free), 1.0))
    return steadied(
        alone, prior(float(np.mean((logs - bias_of_log(frees))[: len(there)])), prior_free)
    )


@dataclass(frozen=True, slots=True)
class HealthyScatter:
    """What a cause scatters by from run to run in healthy machines.

    Attributes:
        alike: Its joint is like the others.
        alone: Its joint may be like no other.
    """

    alike: Scatter
    alone: Scatter

    def chance(self, square: float, directions: int) -> float:
        """Return the chance of so large a square of a size in so many directions, in units of one run's."""

        def tail(one: Scatter) -> float:
            if one.free <= 0.0:
                return 1.0
            f = square / max(one.variance, 1e-24) / directions
            return float(special.fdtrc(directions, one.free, f))

        return float((1.0 - JOINT_UNLIKE) * tail(self.alike) + JOINT_UNLIKE * tail(self.alone))


def healthy_scatter(
    own: Sequence[Sizes], others: Sequence[Sizes], usual: Scatter
) -> HealthyScatter:
    """Return how a cause scatters by its sizes in groups of runs; arguments as of ``pooled``."""
    alike = pooled(own, others, usual)
    return HealthyScatter(alike, pooled(own, (), usual) if others else alike)


def usual_scatter(
    variances: FloatArray, frees: FloatArray, weights: FloatArray, gaits_differ: float = 0.0
) -> Scatter:
    """Return how much a cause scatters if nothing is known but how much others do.

    Args:
        variances: Of K causes between runs, in units of what noise alone would make, (K,).
        frees: Degrees of freedom of each, (K,).
        weights: Of each; forms of one cause share one weight, (K,).
        gaits_differ: With which these are variances between runs of one gait.
    """
    if len(variances) < FEWEST_CAUSES:
        return UNKNOWN
    known = scatter_of_all(np.maximum(variances, LEAST_VARIANCE), frees, weights)
    return replace(known, gaits_differ=gaits_differ)


def _differ(logs: FloatArray, frees: FloatArray) -> float:
    """By how much the logarithms of joints' true variances differ, as a variance.

    Estimated from few joints, so it is drawn towards what joints of machines differ by.
    """
    joints = len(logs) - 1
    beyond = float(logs.var(ddof=1) - np.mean(trigamma(frees / 2))) if joints > 0 else 0.0
    worth = float(JOINTS_DIFFER_WORTH)
    return (joints * max(beyond, 0.0) + worth * JOINTS_DIFFER) / (joints + worth)


def variances_of(each: Sequence[Sizes], gaits_differ: float) -> FloatArray:
    """Return the variance between runs of one gait of each of K groups of two or more, (K,)."""
    frees = np.array([len(one) - 1.0 for one in each])
    return np.asarray(scatters_of([[one] for one in each], gaits_differ) / frees)


def scatter(groups: Sequence[FloatArray]) -> tuple[float, int]:
    """Return the squares of values about the mean of their group, summed, and the degrees of freedom."""
    there = [one for one in groups if len(one)]
    square = sum(float(((one - one.mean()) ** 2).sum()) for one in there)
    return square, sum(len(one) - 1 for one in there)
