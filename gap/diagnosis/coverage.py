"""What a trial could show to a diagnosis: channels that were measured, effects that would stand out."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gap.interfaces import (
    Cause,
    Channel,
    Drive,
    Effect,
    Observation,
    Parameter,
    Scope,
    Simulator,
    places_for,
    used,
)
from gap.search.candidates import is_limit, ratio_steps
from model.values.arrays import BoolArray, FloatArray
from record.trial.trial import Trial

LONGEST_S = 15.0  # of a trial that are looked at: a few steps of any gait
STRONG = 1.0  # RMS change of a channel over its noise
DRIVES = (Drive.MEASURED, Drive.COMMAND)
BLIND = 0.1  # less than this in every measured channel: no length of such runs shows it


@dataclass(frozen=True, slots=True)
class Coverage:
    """What is measured, and what could be seen.

    Attributes:
        measured: Channels with measured values.
        missing: Those without.
        visible: Effects that would show in a measured channel, in the mean of a run if not at any one time,
            at one standard deviation of what a builder of such machines expects, somewhere along the way or
            at a limit that is reached, whether their stage is fed what was measured or what is predicted.
        hidden: Those that would not, in no length of such runs.
    """

    measured: tuple[Channel, ...]
    missing: tuple[Channel, ...]
    visible: tuple[str, ...]
    hidden: tuple[str, ...]


def coverage_of(simulator: Simulator, trial: Trial) -> Coverage:
    """Predict every effect of the catalogue alone, and compare with the noise of what was measured.

    Raises:
        GapError: The trial does not fit the simulator, or is too short.
    """
    short = trial.rows(_middle(trial.time_s))
    seen = simulator.observe(short)
    hidden = _hidden(simulator, short, seen, simulator.effects)
    live = [bool(column.any()) for column in used(seen).T]
    pairs = list(zip(simulator.channels, live, strict=True))
    return Coverage(
        measured=tuple(channel for channel, known in pairs if known),
        missing=tuple(channel for channel, known in pairs if not known),
        visible=tuple(e.name for e in simulator.effects if e.name not in hidden),
        hidden=tuple(e.name for e in simulator.effects if e.name in hidden),
    )


def unwatched_stages(channels: Sequence[Channel], measured: BoolArray) -> tuple[str, ...]:
    """Return the stages none of whose channels was measured, in the order of the channels.

    Args:
        channels: Of the simulator, C of them.
        measured: Which of them were measured, (C,).
    """
    watched = {channel.stage for channel, known in zip(channels, measured, strict=True) if known}
    return tuple(dict.fromkeys(one.stage for one in channels if one.stage not in watched))


@dataclass(frozen=True, slots=True)
class BlindSpot:
    """An effect that the measured channels cannot show.

    Attributes:
        effect: Its name.
        channels: Names of channels that were not measured and would show it; none where these runs do not
            excite it.
    """

    effect: str
    channels: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BlindSpots:
    """What runs cannot show, whatever is in them.

    Attributes:
        missing: Names of channels that no run has at any joint.
        effects: Effects that none of the measured channels shows, in the order of the catalogue.
    """

    missing: tuple[str, ...]
    effects: tuple[BlindSpot, ...]


def blind_spots(simulator: Simulator, trials: Sequence[Trial]) -> BlindSpots:
    """Say before any judgement what runs cannot show, from what each effect does to each channel.

    An effect is hidden when, by one standard deviation of what a builder of such machines expects, no
    measured channel of any run changes by more than a tenth of its noise, whether its stage is fed what was
    measured or what is predicted.

    Raises:
        GapError: A trial does not fit the simulator, or is too short.
    """
    names = [channel.name for channel in simulator.channels]
    measured: set[str] = set()
    would: dict[str, set[str]] = {effect.name: set() for effect in simulator.effects}
    for trial in trials:
        short = trial.rows(_middle(trial.time_s))
        seen = simulator.observe(short)
        live = np.asarray(used(seen).any(axis=0))
        measured |= {name for name, known in zip(names, live, strict=True) if known}
        open_ones = [effect for effect in simulator.effects if effect.name in would]
        here = _hidden(simulator, short, seen, open_ones)
        would = {name: would[name] | strong for name, strong in here.items()}
    missing = tuple(dict.fromkeys(name for name in names if name not in measured))
    return BlindSpots(
        missing,
        tuple(
            BlindSpot(effect.name, tuple(name for name in missing if name in would[effect.name]))
            for effect in simulator.effects
            if effect.name in would
        ),
    )


def _hidden(
    simulator: Simulator, trial: Trial, seen: Observation, effects: Sequence[Effect]
) -> dict[str, set[str]]:
    """Effects that no measured channel of a trial shows; of each, the names of channels that it changes."""
    names = [channel.name for channel in simulator.channels]
    taking_part = used(seen)
    hidden: dict[str, set[str]] = {effect.name: set() for effect in effects}
    for drive in DRIVES:
        if not hidden:
            break
        base = simulator.predict(trial, (), drive)
        for effect in [one for one in effects if one.name in hidden]:
            for cause in _examples(effect, places_for(effect, simulator), seen.reach_m):
                change = (simulator.predict(trial, (cause,), drive) - base) / seen.noise
                if (_rms(change, taking_part) > BLIND).any():
                    del hidden[effect.name]
                    break
                strong = _rms(change, seen.weight > 0) > STRONG
                hidden[effect.name] |= {n for n, one in zip(names, strong, strict=True) if one}
    return hidden


def _rms(change: FloatArray, taking_part: BoolArray) -> FloatArray:
    """RMS of each channel over the frames that take part, (C,); 0 where none does."""
    square = np.where(taking_part & np.isfinite(change), change, 0.0) ** 2
    mean: FloatArray = square.sum(axis=0) / np.maximum(taking_part.sum(axis=0), 1)
    return np.sqrt(mean)


def _middle(time_s: FloatArray) -> BoolArray:
    """Rows of the middle of a trial, where it is most likely to move."""
    spare = max(float(time_s[-1] - time_s[0]) - LONGEST_S, 0.0) / 2
    return np.asarray((time_s >= time_s[0] + spare) & (time_s <= time_s[-1] - spare))


def _examples(
    effect: Effect, joints: Sequence[str], reach_m: tuple[float, float]
) -> Iterator[Cause]:
    """An effect by one spread, of the whole machine or of one joint after the other.

    One that lies somewhere is in the middle of the way, and a limit is low enough to be reached.
    """
    values = tuple(_example(p, reach_m) for p in effect.parameters)
    if Scope.ALL in effect.scopes:
        yield Cause(effect.name, (), values)
    else:
        yield from (Cause(effect.name, (joint,), values) for joint in joints)


def _example(p: Parameter, reach_m: tuple[float, float]) -> float:
    if p.located and all(map(math.isfinite, reach_m)):
        return min(max(sum(reach_m) / 2, p.lower), p.upper)
    if is_limit(p):
        return ratio_steps(p)[0]
    return p.neutral + p.spread if p.neutral + p.spread <= p.upper else p.neutral - p.spread
