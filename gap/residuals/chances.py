"""Chances that a test gives to healthy runs, and what a chance is worth after them.

A test promises that a healthy machine gets a chance below p in a share p of cases. References, each held
out as if it were a trial, show whether it does: their -ln p would be exponential with mean 1. With few of
them the mean is uncertain, so what is returned is the predictive chance (a Lomax tail: an exponential whose
rate has a gamma posterior), never below the test's own. Without any assumption n references promise no
chance below 1 / (n + 1) (conformal rank; Vovk et al. 2005, Algorithmic Learning in a Random World).
"""

import math
from dataclasses import dataclass

from gap.constants import NULL_WORTH, OPEN_LEVEL

SMALLEST = 1e-300


@dataclass(frozen=True, slots=True)
class HeldOutChances:
    """What a test gave to R references, each held out: chances, one a reference."""

    each: tuple[float, ...]

    @property
    def least(self) -> float:
        """Chance below which nothing is promised without assumptions."""
        return 1.0 / (len(self.each) + 1)

    def calibrated(self, p: float) -> float:
        """Return what a chance is worth."""
        nats = -math.log(max(p, SMALLEST))
        return max(p, float((self._scale / (self._scale + nats)) ** self._shape))

    def needed(self, level: float) -> float:
        """Return the chance that is worth a level."""
        nats = self._scale * (level ** (-1.0 / self._shape) - 1.0)
        return min(level, math.exp(-nats))

    @property
    def _shape(self) -> float:
        return float(NULL_WORTH + len(self.each))

    @property
    def _scale(self) -> float:
        return float(NULL_WORTH) - sum(math.log(max(min(p, 1.0), SMALLEST)) for p in self.each)


def clearer(alone: float, beside: float) -> float:
    """Return the chance of a cause by two tests, however they depend on each other.

    Their harmonic mean (Wilson 2019, doi:10.1073/pnas.1814092116). A cause that by itself is no more than
    healthy runs show is nothing new, whatever it is beside what differs from day to day.

    Args:
        alone: Chance of the cause by itself.
        beside: And beside what differs between healthy runs.
    """
    return alone if alone >= OPEN_LEVEL else harmonic_mean(alone, beside)


def harmonic_mean(*chances: float) -> float:
    """Return the chance by several tests, however they depend on each other (Wilson, as above)."""
    return len(chances) / sum(1.0 / max(one, SMALLEST) for one in chances)


def promised(level: float, references: int) -> float:
    """Return the rate of false alarms that can be promised at a level with so many references."""
    return max(level, 1.0 / (references + 1))
