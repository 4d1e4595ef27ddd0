"""What one example of each effect changes in what a run measured, in units of its noise."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap.interfaces import Cause, Drive, Effect, Observation, Parameter, Scope, Simulator, used
from gap.search.candidates import is_limit, ratio_steps
from model.values.arrays import BoolArray, FloatArray
from record.trial.trial import Trial

LONGEST_S = 15.0  # of a trial that are looked at: a few steps of any gait
DRIVES = (Drive.MEASURED, Drive.COMMAND)
BLIND = 0.1  # less than this in every measured channel: no length of such runs shows it
START_M = (
    0.0  # where a run begins along the world's x; without a measured place, the only one known
)

Spot = tuple[str, str]  # an effect, and the joint that it is asked at; empty for wherever it is
Places = tuple[tuple[str, ...], ...]  # joints of each example


@dataclass(frozen=True, slots=True, eq=False)
class ObservedRun:
    """The middle of a trial, where it is most likely to move, and what was measured there."""

    trial: Trial
    seen: Observation

    @property
    def measured(self) -> BoolArray:
        """Which channels have measured values, (C,)."""
        return np.asarray(used(self.seen).any(axis=0))


def look_at(simulator: Simulator, trial: Trial) -> ObservedRun:
    """Observe the middle of a trial.

    Raises:
        GapError: The trial does not fit the simulator, or is too short.
    """
    spare = max(float(trial.time_s[-1] - trial.time_s[0]) - LONGEST_S, 0.0) / 2
    first, last = trial.time_s[0] + spare, trial.time_s[-1] - spare
    short = trial.rows(np.asarray((trial.time_s >= first) & (trial.time_s <= last)))
    return ObservedRun(short, simulator.observe(short))


def can_be_compared(simulator: Simulator, run: ObservedRun) -> bool:
    """Whether the simulator has an answer to anything that was measured."""
    on = used(run.seen)
    return any(
        bool((on & np.isfinite(simulator.predict(run.trial, (), drive))).any()) for drive in DRIVES
    )


def not_shown(
    simulator: Simulator, runs: Sequence[ObservedRun], asked: Mapping[Spot, tuple[Effect, Places]]
) -> dict[Spot, FloatArray]:
    """Return the spots that no measured channel of any run shows, in their order.

    Each with how much it changes every channel at most, measured or not, (C,): RMS over noise.
    """
    left = {spot: np.zeros(len(simulator.channels)) for spot in asked}
    for run in runs:
        here = _hidden(simulator, run, {spot: asked[spot] for spot in left})
        left = {spot: np.fmax(left[spot], most) for spot, most in here.items()}
    return left


def _hidden(
    simulator: Simulator, run: ObservedRun, asked: Mapping[Spot, tuple[Effect, Places]]
) -> dict[Spot, FloatArray]:
    """The same for one run."""
    seen, taking_part = run.seen, used(run.seen)
    weighs = seen.weight > 0
    anywhere = weighs | ~weighs.any(axis=0)  # some simulators give what was not measured no weight
    hidden = {spot: np.zeros(len(simulator.channels)) for spot in asked}
    for drive in DRIVES:
        if not hidden:
            break
        base = simulator.predict(run.trial, (), drive)
        for spot in list(hidden):
            for cause in _examples(*asked[spot], seen.reach_m):
                change = (simulator.predict(run.trial, (cause,), drive) - base) / seen.noise
                if (_rms(change, taking_part) > BLIND).any():
                    del hidden[spot]
                    break
                hidden[spot] = np.fmax(hidden[spot], _rms(change, anywhere))
    return hidden


def _rms(change: FloatArray, taking_part: BoolArray) -> FloatArray:
    """RMS of each channel over the frames that take part, (C,); 0 where none does."""
    square = np.where(taking_part & np.isfinite(change), change, 0.0) ** 2
    mean: FloatArray = square.sum(axis=0) / np.maximum(taking_part.sum(axis=0), 1)
    return np.sqrt(mean)


def wherever(effect: Effect, joints: Sequence[str]) -> Places:
    """Return the places at which an effect is tried: the whole machine, or one joint after the other."""
    return ((),) if Scope.ALL in effect.scopes else tuple((joint,) for joint in joints)


def _examples(effect: Effect, places: Places, reach_m: tuple[float, float]) -> Iterator[Cause]:
    """An effect by one spread.

    One that lies somewhere is in the middle of the way, and a limit is low enough to be reached.
    """
    values = tuple(_example(p, reach_m) for p in effect.parameters)
    return (Cause(effect.name, joints, values) for joints in places)


def _example(p: Parameter, reach_m: tuple[float, float]) -> float:
    if p.located:
        middle = sum(reach_m) / 2 if all(map(math.isfinite, reach_m)) else START_M
        return min(max(middle, p.lower), p.upper)
    if is_limit(p):
        return ratio_steps(p)[0]
    return p.neutral + p.spread if p.neutral + p.spread <= p.upper else p.neutral - p.spread
