"""What a trial could show to a diagnosis: channels that were measured, effects that would stand out."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gap.interfaces import Cause, Channel, Drive, Effect, Scope, Simulator, places_for, used
from model.values.arrays import BoolArray, FloatArray
from record.trial.trial import Trial

LONGEST_S = 15.0  # of a trial that are looked at: a few steps of any gait
VISIBLE = 1.0  # RMS change of a channel over its noise


@dataclass(frozen=True, slots=True)
class Coverage:
    """What is measured, and what could be seen.

    Attributes:
        measured: Channels with measured values.
        missing: Those without.
        visible: Effects that would stand out of the sensors' noise in a measured channel, at one standard
            deviation of what a builder of such machines expects.
        hidden: Those that would not.
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
    taking_part = used(seen)
    base = simulator.predict(short, (), Drive.MEASURED)

    def stands_out(cause: Cause) -> bool:
        change = (simulator.predict(short, (cause,), Drive.MEASURED) - base) / seen.noise
        square = np.where(taking_part & np.isfinite(change), change, 0.0) ** 2
        mean = square.sum(axis=0) / np.maximum(taking_part.sum(axis=0), 1)
        return bool(np.sqrt(mean.max()) > VISIBLE)

    visible = tuple(
        effect.name
        for effect in simulator.effects
        if any(stands_out(cause) for cause in _examples(effect, places_for(effect, simulator)))
    )
    live = [bool(column.any()) for column in taking_part.T]
    pairs = list(zip(simulator.channels, live, strict=True))
    return Coverage(
        measured=tuple(channel for channel, known in pairs if known),
        missing=tuple(channel for channel, known in pairs if not known),
        visible=visible,
        hidden=tuple(e.name for e in simulator.effects if e.name not in visible),
    )


def _middle(time_s: FloatArray) -> BoolArray:
    """Rows of the middle of a trial, where it is most likely to move."""
    spare = max(float(time_s[-1] - time_s[0]) - LONGEST_S, 0.0) / 2
    return np.asarray((time_s >= time_s[0] + spare) & (time_s <= time_s[-1] - spare))


def _examples(effect: Effect, joints: Sequence[str]) -> Iterator[Cause]:
    """An effect by one spread, of the whole machine or of one joint after the other."""
    values = tuple(
        p.neutral + p.spread if p.neutral + p.spread <= p.upper else p.neutral - p.spread
        for p in effect.parameters
    )
    if Scope.ALL in effect.scopes:
        yield Cause(effect.name, (), values)
    else:
        yield from (Cause(effect.name, (joint,), values) for joint in joints)
