"""Joints that hunt: a position loop around a play swings between its flanks, and never comes to rest.

It happens where nothing loads the shaft, several times a second. When each swing begins is chance, so no
simulator follows it frame by frame. How large it is says that there is play, and more than references have;
where it lasts, the joint's own readings say nothing else. It is faster than the frames of many simulators,
so it is sought in the readings as they were recorded.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy import special

from gap.constants import HUNTS_BY, STEADY_SCATTER
from gap.interfaces import Channel
from gap.residuals.parts import TrialPart
from gap.residuals.vibration import STEADY_FREE
from model.values.arrays import BoolArray, FloatArray, readonly
from record.trial.trial import Trial

SLOWEST_HZ = 3.0  # motions of gaits are slower
ABOVE = 1.5  # times that: blows and pauses of all lengths leave most just above
LEAST_RATE_HZ = 20.0  # of readings that show it
FEWEST_SWINGS = 10  # half periods on end, which a blow or a change of load does not bring
FEW_SWINGS = 4  # from which a joint that is known to hunt does so
EVEN = (0.5, 2.0)  # of the middle half period: readings cut some short
LEAST_NOISE = 6.0  # standard deviations of a reading that a swing has
NOISE_RAD = 0.0005  # of shafts whose noise is not given: a third of a count of 4096
# Of the time. A blow rings for less; what goes on under load, where a shaft lies against a flank, is noise.
LEAST_SHARE, MOST_SHARE = 0.15, 0.8
AROUND_S = 0.25  # before and after, while it comes and goes
ORDER = 4


@dataclass(frozen=True, slots=True)
class Hunting:
    """A joint that hunts in trials as in no reference.

    Attributes:
        frequency_hz: How often it swings.
        amplitude_rad: Distance of a swing from the middle.
        usual_rad: The same of references; 0 where they do not hunt.
        share: Of the time of the trials.
        chance: Of so much more than references in a healthy machine.
    """

    joint: str
    frequency_hz: float
    amplitude_rad: float
    usual_rad: float
    share: float
    chance: float

    @property
    def words(self) -> str:
        """Say it in a sentence."""
        usual = f"references by {self.usual_rad:.2g} rad" if self.usual_rad else "no reference does"
        return (
            f"{self.joint} hunts {self.frequency_hz:.2g} times a second by {self.amplitude_rad:.2g} rad "
            f"in {self.share:.0%} of the time, {usual}"
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Swings:
    """Swings of one joint in one run, and the spans of time in which they last, (S, 2)."""

    half_s: FloatArray
    height: FloatArray
    spans_s: FloatArray

    @property
    def amplitude(self) -> float:
        return float(np.median(self.height)) if len(self.height) else 0.0


_REST = _Swings(np.zeros(0), np.zeros(0), np.zeros((0, 2)))


def hunting_of(trials: Sequence[Trial], references: Sequence[Trial]) -> tuple[Hunting, ...]:
    """Return the joints that hunt in most trials, more than in any reference.

    None without two references: how a healthy machine hunts is not known then.
    """
    if len(references) < 2 or not trials:
        return ()
    out = []
    for at, joint in enumerate(trials[0].header.joints):
        own = [_swings(trial, at) for trial in trials]
        if not any(len(one.height) for one in own):
            continue
        usual = max(_swings(trial, at).amplitude for trial in references)
        least = max(usual, LEAST_NOISE * max(map(_noise_of, (*trials, *references))))
        hunts = [one for one in own if one.amplitude > HUNTS_BY * usual]
        if 2 * len(hunts) <= len(own):
            continue
        half_s = float(np.median(np.concatenate([one.half_s for one in hunts])))
        height = float(np.median(np.concatenate([one.height for one in hunts])))
        time_s = sum(float(trial.time_s[-1] - trial.time_s[0]) for trial in trials)
        share = sum(float(np.diff(one.spans_s).sum()) for one in hunts) / time_s
        if not LEAST_SHARE < share < MOST_SHARE:
            continue
        out.append(Hunting(joint, 0.5 / half_s, height, usual, share, _chance(height / least)))
    return tuple(out)


def _chance(ratio: float) -> float:
    """Chance of a swing so much larger than any that was seen, or could have been, in references."""
    return float(special.stdtr(STEADY_FREE, -max(np.log(ratio), 0.0) / STEADY_SCATTER))


def _noise_of(trial: Trial) -> float:
    noise = trial.header.noise.shaft_rad
    return noise if noise > 0.0 else NOISE_RAD


def without_hunting(
    channels: Sequence[Channel],
    hidden: str,
    trials: Sequence[Trial],
    parts: Sequence[TrialPart],
    hunting: Sequence[Hunting],
) -> tuple[TrialPart, ...]:
    """Return parts in which what hunts does not count meanwhile.

    That is the channel ``hidden`` of the same joint, and where its foot is.
    """
    out = []
    for part in parts:
        trial, weight = trials[part.trial], part.observation.weight.copy()
        time_s = part.observation.time_s
        for one in hunting:
            spans_s = _swings(trial, trial.header.joints.index(one.joint)).spans_s
            frames = np.zeros(len(time_s), dtype=bool)
            for begin_s, end_s in spans_s:
                frames |= (time_s >= begin_s) & (time_s <= end_s)
            for i, channel in enumerate(channels):
                if channel.joint == one.joint and (
                    channel.name == hidden or channel.stage == "kinematics"
                ):
                    weight[frames, i] = 0.0
        out.append(replace(part, observation=replace(part.observation, weight=readonly(weight))))
    return tuple(out)


def _swings(trial: Trial, joint: int) -> _Swings:
    """Long even runs of swings about the running mean, each higher than noise."""
    time_s = trial.time_s - trial.time_s[0]
    known = np.isfinite(trial.shaft_rad[:, joint])
    rate_hz = 1.0 / float(np.median(np.diff(time_s[known]))) if known.sum() > 1 else 0.0
    if rate_hz < LEAST_RATE_HZ or known.sum() < rate_hz:
        return _REST
    even_s = np.arange(time_s[known][0], time_s[known][-1], 1.0 / rate_hz)
    angle = np.interp(even_s, time_s[known], trial.shaft_rad[known, joint])
    fast = _fast(angle, round(rate_hz, 3))
    cross = np.flatnonzero((fast[:-1] < 0.0) != (fast[1:] < 0.0))
    if len(cross) <= FEWEST_SWINGS:
        return _REST
    at_s = even_s[cross] - fast[cross] / (fast[cross + 1] - fast[cross]) / rate_hz
    half_s, height = np.diff(at_s), np.maximum.reduceat(np.abs(fast), cross + 1)[:-1]
    high = height > LEAST_NOISE * _noise_of(trial)
    even = _in_even_runs(high & (half_s < 0.5 / (ABOVE * SLOWEST_HZ)), half_s)
    if not even.any():
        return _REST
    short = half_s < EVEN[1] * float(np.median(half_s[even]))
    spans_s = [
        (at_s[first] - AROUND_S, at_s[last] + AROUND_S)
        for first, last in _runs(high & short)
        if last - first >= FEW_SWINGS
    ]
    return _Swings(half_s[even], height[even], np.array(spans_s).reshape(-1, 2))


def _runs(on: BoolArray) -> list[tuple[int, int]]:
    """First of each run, and the one behind its last."""
    edges = np.flatnonzero(np.diff(on.astype(np.int8), prepend=0, append=0))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _in_even_runs(high: BoolArray, half_s: FloatArray) -> BoolArray:
    """Which swings are in long runs of high ones that are about as long."""
    even = np.zeros(len(high), dtype=bool)
    for first, last in _runs(high):
        middle = float(np.median(half_s[first:last]))
        alike = (half_s > EVEN[0] * middle) & (half_s < EVEN[1] * middle)
        alike[:first], alike[last:] = False, False
        for begin, end in _runs(alike):
            if end - begin >= FEWEST_SWINGS:
                even[begin:end] = True
    return even


def _fast(values: FloatArray, rate_hz: float) -> FloatArray:
    from scipy.signal import sosfiltfilt  # a third of a second: as late as it is needed

    return np.asarray(sosfiltfilt(_high_pass(rate_hz), values))


@cache
def _high_pass(rate_hz: float) -> FloatArray:
    from scipy.signal import butter

    return np.asarray(butter(ORDER, SLOWEST_HZ, "high", fs=rate_hz, output="sos"))
