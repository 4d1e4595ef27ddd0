"""Whether channels vibrate more than a healthy machine's, faster than a simulator's frames can follow.

Feet that stick and slip in turn, many times a second, push in the mean as feet with another friction do. A
quasi-static simulator predicts that mean alone; only what shakes about it tells the two apart. So the power
of the fastest part of the measured channels, as it is and not compared with a prediction, is held against
that of references of the same gait and frequency. Forces that are larger as a whole vibrate more as well,
and what shakes the whole machine shakes its loads, or its shafts: that much does not count.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import special

from gap.constants import (
    CALM_LEAD,
    STEADY_SCATTER,
    VIBRATES_BY,
    VIBRATES_FASTER,
    VIBRATES_FREE,
    VIBRATES_SCATTER,
    VIBRATES_UNLIKE,
)
from gap.interfaces import Channel
from gap.residuals.evidence import Evidence
from gap.residuals.healthy import SAME_CONDITION, apart
from gap.residuals.parts import TrialPart
from model.effects.causes import Shaking
from model.values.arrays import FloatArray

ORDER = 4
FEWEST_FRAMES = 60


@dataclass(frozen=True, slots=True)
class ChannelVibration:
    """How much more channels vibrate than in references.

    Attributes:
        channels: Names of the channels.
        excess: Natural logarithm of the power over that of references, beyond what larger forces bring.
        nats: Log likelihood of it with an effect that vibrates, minus that without one.
        chance: Of so much without one.
    """

    channels: tuple[str, ...]
    excess: float
    nats: float
    chance: float

    @property
    def words(self) -> str:
        """Say it in a sentence."""
        channels, ratio = " and ".join(self.channels), math.exp(0.5 * self.excess)
        vibrate = "vibrate" if len(self.channels) > 1 else "vibrates"
        return f"{channels} {vibrate} {ratio:.2g} times as strongly as in references like these"


@dataclass(frozen=True, slots=True)
class _Level:
    """Mean logarithms of the power of the fast part of some channels, and of all of it; NaN for none."""

    fast: float
    whole: float

    @property
    def known(self) -> bool:
        return math.isfinite(self.fast)


@dataclass(frozen=True, slots=True)
class _Run:
    """Levels of the channels that would vibrate, and of each group of those that would not."""

    part: TrialPart
    own: _Level
    calm: tuple[_Level, ...]


def vibration_of(
    shaking: Shaking,
    channels: Sequence[Channel],
    trials: Sequence[TrialPart],
    references: Sequence[TrialPart],
) -> ChannelVibration | None:
    """Return how much more the channels of an effect vibrate than in references.

    None without two references, and where no such channel was measured.
    """
    own = _runs(shaking, channels, trials)
    known = _runs(shaking, channels, references)
    if not own or len(known) < 2:
        return None
    near = [_near(one, known) for one in own]
    excess = float(np.mean([_excess(one, like) for one, (_, like) in zip(own, near, strict=True)]))
    scatter = math.hypot(STEADY_SCATTER, _scatter(known, max(far for far, _ in near)))
    # more than is usual is no sign against it
    less = min(excess - VIBRATES_BY, 0.0)
    nats = _log_normal(less, math.hypot(VIBRATES_SCATTER, scatter)) - _log_t(excess, scatter)
    chance = float(special.stdtr(float(VIBRATES_FREE), -excess / scatter))
    return ChannelVibration(shaking.channels, excess, nats, chance)


def _log_normal(value: float, scatter: float) -> float:
    return -0.5 * (value / scatter) ** 2 - math.log(scatter) - 0.5 * math.log(2.0 * math.pi)


def _log_t(value: float, scatter: float) -> float:
    """Log density of Student's t with the degrees of freedom of the scatter."""
    more = 0.5 * (VIBRATES_FREE + 1.0)
    size = math.lgamma(more) - math.lgamma(0.5 * VIBRATES_FREE)
    tail = more * math.log1p((value / scatter) ** 2 / VIBRATES_FREE)
    return size - 0.5 * math.log(VIBRATES_FREE * math.pi) - math.log(scatter) - tail


def _runs(
    shaking: Shaking, channels: Sequence[Channel], parts: Sequence[TrialPart]
) -> tuple[_Run, ...]:
    """Runs in which the channels of an effect were measured."""
    own = _named(channels, shaking.channels)
    calm = [_named(channels, names) for names in shaking.calm]
    each = (
        _Run(part, _level(part, own), tuple(_level(part, one) for one in calm)) for part in parts
    )
    return tuple(one for one in each if one.own.known)


def _named(channels: Sequence[Channel], names: Collection[str]) -> list[int]:
    return [i for i, channel in enumerate(channels) if channel.name in names]


def _level(part: TrialPart, on: Sequence[int]) -> _Level:
    powers = []
    for i in on:
        values = part.observation.values[:, i]
        known = np.isfinite(values)
        counts = known & (part.observation.weight[:, i] >= 1.0)
        if counts.sum() < FEWEST_FRAMES:
            continue
        whole = np.interp(np.arange(len(values)), np.flatnonzero(known), values[known])
        fast = fast_part(whole, float(VIBRATES_FASTER))
        power = np.mean(fast[counts] ** 2), np.mean(values[counts] ** 2)
        if min(power) > 0.0:  # a channel that never moves says nothing
            powers.append(np.log(power))
    return _Level(*np.mean(powers, axis=0)) if powers else _Level(math.nan, math.nan)


def fast_part(values: FloatArray, share: float) -> FloatArray:
    """Return the part of evenly sampled values, (F,), that is faster than a share of their rate."""
    from scipy.signal import sosfiltfilt  # a third of a second: as late as it is needed

    return np.asarray(sosfiltfilt(_high_pass(share), values))


@cache
def _high_pass(share: float) -> FloatArray:
    """Second-order sections of the filter that leaves the fast part."""
    from scipy.signal import butter

    return np.asarray(butter(ORDER, share, "high", fs=1.0, output="sos"))


def _excess(one: _Run, known: Sequence[_Run]) -> float:
    """How much more its channels vibrate than in some other runs."""
    fast = one.own.fast - float(np.mean([other.own.fast for other in known]))
    whole = one.own.whole - float(np.mean([other.own.whole for other in known]))
    excess = fast - max(0.0, whole)
    for at, level in enumerate(one.calm):
        calm = level.fast - float(np.mean([other.calm[at].fast for other in known]))
        # with a lead of less than half over what should be calm, less and less of it counts
        excess = min(excess, CALM_LEAD * (fast - calm)) if math.isfinite(calm) else excess
    return excess


def _near(one: _Run, known: Sequence[_Run]) -> tuple[int, list[_Run]]:
    """References of its gait and frequency, or the nearest that there are, and how far they are."""
    far = [apart(one.part.condition, other.part.condition) for other in known]
    least = min(far)
    return least, [other for other, own in zip(known, far, strict=True) if own == least]


def _scatter(known: Sequence[_Run], far: int) -> float:
    """How much references vibrate beyond others, as far from them as the trials are."""
    others = [_near(one, [*known[:at], *known[at + 1 :]]) for at, one in enumerate(known)]
    squares = [
        _excess(one, like) ** 2
        for one, (distance, like) in zip(known, others, strict=True)
        if distance == far
    ]
    if squares:
        return float(np.sqrt(np.mean(squares)))
    return 0.0 if far == SAME_CONDITION else VIBRATES_UNLIKE


def settled(evidence: Evidence, residual: FloatArray, names: Collection[str]) -> FloatArray:
    """Return whitened residuals, (F, C), with what vibrates scaled down to its expectation.

    Feet that stick and slip push against each other by chance, slowly as well as fast: where that is
    known to happen, no simulator is held to these channels frame by frame.
    """
    channels, out = evidence.predictor.simulator.channels, residual.copy()
    excess = evidence.excess(residual)
    for i in _named(channels, names):
        if excess[i] > 1.0:
            out[:, i] /= math.sqrt(excess[i])
    return out
