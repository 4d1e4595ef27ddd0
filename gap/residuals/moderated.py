"""Variances that few runs show, steadied by those of what is like them.

Their true values are one draw each of a scaled inverse chi-squared distribution, whose width is estimated
from how much they differ (Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3:3, section 6.2).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from model.values.arrays import FloatArray

MOST_FREE = 1e6  # degrees of freedom that count as a variance that is known
TRIGAMMA_PRECISE = 1e-9
MOST_STEPS = 50  # five to ten are needed


@dataclass(frozen=True, slots=True)
class Scatter:
    """Variance of one run, and the degrees of freedom that it is known with.

    Attributes:
        gaits_differ: Variance between gaits over that between runs of one gait.
    """

    variance: float
    free: float
    gaits_differ: float = 0.0

    def times(self, factor: float) -> "Scatter":
        """Return it in other units."""
        return replace(self, variance=self.variance * factor)

    def beside(self, usual: "Scatter") -> "Scatter":
        """Return it with what is usual as known before, as much as that is worth."""
        whole = self.free + usual.free
        square = self.free * self.variance if self.free else 0.0
        return Scatter((square + usual.free * usual.variance) / whole, whole)


UNKNOWN = Scatter(0.0, 0.0)


def steadied(own: Scatter, by: Scatter) -> Scatter:
    """Return a scatter with another's say in it, which is at most as much as its own."""
    free = min(by.free, max(own.free, 1.0))
    return own.beside(replace(by, free=free)) if free > 0.0 else own


def scatter_of_all(variances: FloatArray, frees: FloatArray, weights: FloatArray) -> Scatter:
    """Return what is known of one more variance, if it is drawn like K others.

    Args:
        variances: Estimated, (K,), K at least 2.
        frees: Degrees of freedom of each, (K,).
        weights: Of each, (K,).
    """
    share = weights / weights.sum()
    logs = np.log(variances) - bias_of_log(frees)
    centre = float(share @ logs)
    spread = float(share @ (logs - centre) ** 2) / max(1.0 - float(share @ share), 1e-9)
    differ = spread - float(share @ trigamma(frees / 2))
    return prior(centre, 2.0 * trigamma_inverse(max(differ, 0.0)))


def prior(centre: float, free: float) -> Scatter:
    """Return a scatter whose logarithm, free of the bias of few runs, is expected at ``centre``."""
    return Scatter(float(np.exp(centre + bias_of_log(free))), free)


def bias_of_log(free: FloatArray | float) -> FloatArray:
    """Return the expectation of the logarithm of an estimated variance, minus that of the true one."""
    half = np.asarray(free) / 2.0
    return np.asarray(special.digamma(half) - np.log(half))


def trigamma_inverse(value: float) -> float:
    """Return where the trigamma function has a value, by Newton's steps on its inverse.

    Smyth 2004, as above, appendix.
    """
    low, high = 1e-3, MOST_FREE
    if value >= trigamma(low):
        return low
    if value <= trigamma(high):
        return high
    at = 0.5 + 1.0 / value
    for _ in range(MOST_STEPS):
        here = float(trigamma(at))
        step = here * (1.0 - here / value) / (-2.0 * float(special.zeta(3.0, at)))
        at += step
        if abs(step) <= TRIGAMMA_PRECISE * at:
            break
    return at


def trigamma(value: FloatArray | float) -> FloatArray:
    """Return the second derivative of the logarithm of the gamma function; a Hurwitz zeta function."""
    return np.asarray(special.zeta(2.0, value))
