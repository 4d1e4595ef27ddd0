"""Joints that hunt: a position loop around a play swings between its flanks, and never comes to rest.

It happens where nothing loads the shaft, several times a second. When each swing begins is chance, so no
simulator follows it frame by frame. How large it is says that there is play, and more than references have;
where it lasts, the joint's own readings say nothing else. It is faster than the frames of many simulators,
so it is sought in the readings as they were recorded.
"""

import math
from collections.abc import Sequence, Set
from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from gap.constants import (
    FALSE_ALARMS,
    HUNTS_ALWAYS,
    HUNTS_AROUND_S,
    HUNTS_AT_REST,
    HUNTS_BY,
    HUNTS_EVEN,
    HUNTS_FASTER,
    HUNTS_FEW_SWINGS,
    HUNTS_KEEPS,
    HUNTS_NOISE,
    HUNTS_SCATTER,
    HUNTS_SELDOM,
    HUNTS_SLOWEST_HZ,
    HUNTS_SWINGS,
    VIBRATES_FREE,
)
from gap.interfaces import Channel
from gap.residuals.floor import ENOUGH_REFERENCES
from gap.residuals.parts import TrialPart
from gap.residuals.vibration import fast_part
from model.values.arrays import BoolArray, FloatArray, readonly
from record.trial.trial import Trial

LEAST_RATE_HZ = 20.0  # of readings that show it
NOISE_RAD = 0.0005  # of shafts whose noise is not given: a third of a count of 4096


@dataclass(frozen=True, slots=True)
class Hunting:
    """A joint that hunts in trials as in no reference.

    Attributes:
        frequency_hz: How often it swings.
        amplitude_rad: Distance of a swing from the middle.
        usual_rad: The same of references; 0 where they do not hunt.
        share: Of the time of the trials.
        chance: Of so much more than references at any joint of a healthy machine.
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
    """Even swings of one joint in one run, and the spans of time in which it hunts, (S, 2)."""

    half_s: FloatArray
    height: FloatArray
    spans_s: FloatArray
    run_s: float

    @property
    def amplitude(self) -> float:
        return float(np.median(self.height)) if len(self.height) else 0.0

    @property
    def lasts_s(self) -> float:
        return float(np.diff(self.spans_s).sum())


def hunting_of(trials: Sequence[Trial], references: Sequence[Trial]) -> tuple[Hunting, ...]:
    """Return the joints that hunt in most trials, more than in any reference.

    None without three references whose readings would show it: how a healthy machine hunts is not known
    then. A joint counts if the chance of so much at any joint of a healthy machine is below 5 %.
    """
    joints = trials[0].header.joints if trials else ()
    each = (_hunts(joint, at, len(joints), trials, references) for at, joint in enumerate(joints))
    return tuple(one for one in each if one is not None)


def _hunts(
    joint: str, at: int, joints: int, trials: Sequence[Trial], references: Sequence[Trial]
) -> Hunting | None:
    own = [one for trial in trials if (one := _swings(trial, at)) is not None]
    if not any(len(one.height) for one in own):
        return None
    known = [one for trial in references if (one := _swings(trial, at)) is not None]
    if len(known) < ENOUGH_REFERENCES:
        return None
    usual = max(one.amplitude for one in known)
    # what is smaller would not have been seen
    least = max(usual, HUNTS_NOISE * max(map(_noise_of, (*trials, *references))))
    hunts = [one for one in own if one.amplitude > HUNTS_BY * least]
    if 2 * len(hunts) <= len(own):
        return None
    half_s = float(np.median(np.concatenate([one.half_s for one in hunts])))
    height = float(np.median(np.concatenate([one.height for one in hunts])))
    share = sum(one.lasts_s for one in hunts) / sum(one.run_s for one in own)
    chance = min(1.0, joints * _chance(height / least))
    if chance >= FALSE_ALARMS or not HUNTS_SELDOM < share < HUNTS_ALWAYS:
        return None
    return Hunting(joint, 0.5 / half_s, height, usual, share, chance)


def _chance(ratio: float) -> float:
    """Chance of a swing so much larger than any that was seen, or could have been, in references."""
    return float(special.stdtr(float(VIBRATES_FREE), -math.log(max(ratio, 1.0)) / HUNTS_SCATTER))


def _noise_of(trial: Trial) -> float:
    noise = trial.header.noise.shaft_rad
    return noise if noise > 0.0 else NOISE_RAD


def without_hunting(
    channels: Sequence[Channel],
    hidden: Set[str],
    trials: Sequence[Trial],
    parts: Sequence[TrialPart],
    hunting: Sequence[Hunting],
) -> tuple[TrialPart, ...]:
    """Return parts in which what hunts does not count meanwhile.

    That is the channels ``hidden`` of the same joint, and where the foot of its leg is.
    """
    out = []
    for part in parts:
        trial, weight = trials[part.trial], part.observation.weight.copy()
        time_s = part.observation.time_s
        for one in hunting:
            seen = _swings(trial, trial.header.joints.index(one.joint))
            frames = np.zeros(len(time_s), dtype=bool)
            for begin_s, end_s in seen.spans_s if seen else ():
                frames |= _around(time_s, begin_s, end_s)
            legs = {leg for leg in trial.header.legs if f"{one.joint}_".startswith(f"{leg}_")}
            for i, channel in enumerate(channels):
                reads = channel.joint == one.joint and channel.name in hidden
                foot = channel.joint in {one.joint, *legs} and channel.stage == "kinematics"
                if reads or foot:
                    weight[frames, i] = 0.0
        out.append(replace(part, observation=replace(part.observation, weight=readonly(weight))))
    return tuple(out)


def _around(time_s: FloatArray, begin_s: float, end_s: float) -> BoolArray:
    return (time_s >= begin_s - HUNTS_AROUND_S) & (time_s <= end_s + HUNTS_AROUND_S)


def _swings(trial: Trial, joint: int) -> _Swings | None:
    """Swings about the running mean; None where the readings would not show them."""
    time_s = trial.time_s - trial.time_s[0]
    known = np.isfinite(trial.shaft_rad[:, joint])
    rate_hz = 1.0 / float(np.median(np.diff(time_s[known]))) if known.sum() > 1 else 0.0
    run_s = float(time_s[known][-1] - time_s[known][0]) if known.any() else 0.0
    if rate_hz < LEAST_RATE_HZ or run_s < 1.0:
        return None
    nothing = _Swings(np.zeros(0), np.zeros(0), np.zeros((0, 2)), run_s)
    even_s = np.arange(time_s[known][0], time_s[known][-1], 1.0 / rate_hz)
    angle = np.interp(even_s, time_s[known], trial.shaft_rad[known, joint])
    fast = fast_part(angle, HUNTS_SLOWEST_HZ / round(rate_hz, 3))
    cross = np.flatnonzero((fast[:-1] < 0.0) != (fast[1:] < 0.0))
    if len(cross) <= HUNTS_SWINGS:
        return nothing
    at_s = even_s[cross] - fast[cross] / (fast[cross + 1] - fast[cross]) / rate_hz
    half_s, height = np.diff(at_s), np.maximum.reduceat(np.abs(fast), cross + 1)[:-1]
    high = height > HUNTS_NOISE * _noise_of(trial)
    even = _in_even_runs(high & (half_s < 0.5 / (HUNTS_FASTER * HUNTS_SLOWEST_HZ)), half_s, height)
    if not even.any():
        return nothing
    short = half_s < HUNTS_EVEN * float(np.median(half_s[even]))
    spans_s = [(at_s[a], at_s[b]) for a, b in _runs(high & short) if b - a >= HUNTS_FEW_SWINGS]
    hunts = np.zeros(len(even_s), dtype=bool)
    for begin_s, end_s in spans_s:
        hunts |= _around(even_s, begin_s, end_s)
    rest = np.abs(fast[~hunts])
    if len(rest) and np.median(rest) > HUNTS_AT_REST * np.median(height[even]):
        return nothing
    return replace(
        nothing,
        half_s=half_s[even],
        height=height[even],
        spans_s=np.array(spans_s).reshape(-1, 2),
    )


def _runs(on: BoolArray) -> list[tuple[int, int]]:
    """First of each run, and the one behind its last."""
    edges = np.flatnonzero(np.diff(on.astype(np.int8), prepend=0, append=0))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _in_even_runs(high: BoolArray, half_s: FloatArray, height: FloatArray) -> BoolArray:
    """Which swings are in long runs of high ones that are about as long, and do not ring down."""
    even = np.zeros(len(high), dtype=bool)
    for first, last in _runs(high):
        middle = float(np.median(half_s[first:last]))
        alike = (half_s > middle / HUNTS_EVEN) & (half_s < HUNTS_EVEN * middle)
        alike[:first], alike[last:] = False, False
        for begin, end in _runs(alike):
            third = (end - begin) // 3
            if end - begin < HUNTS_SWINGS:
                continue
            before, after = height[begin : begin + third], height[end - third : end]
            if np.median(after) > HUNTS_KEEPS * np.median(before):
                even[begin:end] = True
    return even
