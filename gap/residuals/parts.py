"""Which frames are fitted to, which judge, and the blocks that count as independent.

Trials are held out whole where a gait has two or more; where each trial is the only one of its gait, the
last third of each judges, behind a gap.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.constants import HARMONICS, HELD_OUT_SHARE, LAST_BLOCK, SHORTEST_BLOCK_S
from gap.interfaces import Observation, Simulator
from gap.residuals.command_cycle import CommandCycle, command_cycle_of
from gap.residuals.hold_out import HoldOut
from model.errors import GapError
from model.values.arrays import FloatArray, IntArray
from record.trial.trial import Trial

MOST_FOLDS = 6
FEWEST_FRAMES = 8
DAY = "day"  # the condition of a run that says which others were recorded with it


@dataclass(frozen=True, slots=True)
class RunCondition:
    """A gait at a frequency, or a motion that a run makes once."""

    gait: str
    frequency_hz: float
    once: bool = False

    def log_ratio(self, other: "RunCondition") -> float:
        """Natural logarithm of the ratio of the frequencies; 0 where one is not known."""
        ratio = self.frequency_hz / other.frequency_hz if other.frequency_hz > 0 else 1.0
        return float(np.log(ratio)) if np.isfinite(ratio) and ratio > 0 else 0.0


@dataclass(frozen=True, slots=True, eq=False)
class TrialPart:
    """Frames of one trial.

    Attributes:
        trial: Index of the trial.
        first: First frame.
        last: Frame behind the last.
        frequency_hz: Its cycles a second; NaN if not known.
        observation: What was measured there.
        commands: How the whole trial was commanded; None without cycles.
        day: On which it was recorded; empty for a day of its own.
        motion_s: How long a motion takes that all references repeat and a run makes once; NaN for others.
        harmonics: By which what repeats is described, at the most.
    """

    trial: int
    first: int
    last: int
    gait: str
    frequency_hz: float
    observation: Observation
    commands: CommandCycle | None = None
    day: str = ""
    motion_s: float = math.nan
    harmonics: int = int(HARMONICS)

    def cut(self, whole: FloatArray) -> FloatArray:
        """Return this part of something of the whole trial, (F, ...)."""
        return whole[self.first : self.last]

    @property
    def condition(self) -> RunCondition:
        """Its gait and frequency."""
        return RunCondition(self.gait, self.frequency_hz, self.once)

    @property
    def once(self) -> bool:
        """Whether it is of a motion that a run makes once."""
        return math.isfinite(self.motion_s)

    @property
    def cycle(self) -> FloatArray:
        """Cycles of what repeats from run to run, (F,): of its gait, or of a motion that it makes once."""
        return self.observation.time_s / self.motion_s if self.once else self.observation.cycle

    @property
    def frames(self) -> int:
        """Number of frames."""
        return self.last - self.first


def whole_parts(
    simulator: Simulator, trials: Sequence[Trial], first: int = 0
) -> tuple[TrialPart, ...]:
    """Return whole trials as parts; the first one has the index ``first`` among all trials of the study."""
    observed = [(trial, simulator.observe(trial)) for trial in trials]
    return tuple(part_of(i, t, o, 0, len(o.time_s)) for i, (t, o) in enumerate(observed, first))


def part_of(index: int, trial: Trial, observation: Observation, first: int, last: int) -> TrialPart:
    """Return frames of a trial."""
    o, rows = observation, slice(first, last)
    cut = Observation(
        o.time_s[rows], o.cycle[rows], o.values[rows], o.noise[rows], o.weight[rows], o.reach_m
    )
    frequency = trial.header.frequency_hz
    if not np.isfinite(frequency) and np.isfinite(o.cycle).all() and len(o.time_s) > 1:
        frequency = float(abs(o.cycle[-1] - o.cycle[0]) / (o.time_s[-1] - o.time_s[0]))
    commands = command_cycle_of(trial, observation)
    day = trial.header.condition(DAY)
    named = "" if day is None else str(day)
    return TrialPart(index, first, last, trial.header.gait, frequency, cut, commands, named)


def split(
    simulator: Simulator, trials: Sequence[Trial], hold_out: HoldOut | None = None
) -> tuple[tuple[TrialPart, ...], tuple[TrialPart, ...]]:
    """Return the parts to fit to, and those that are held out to judge.

    Args:
        simulator: Puts trials on its channels.
        trials: Measured runs.
        hold_out: What judges; None holds out evenly.

    Raises:
        GapError: There are too few frames, or nothing is left to fit to.
    """
    # a gait that is not known is a gait like any other
    wholes = [part for part in whole_parts(simulator, trials) if part.frames >= FEWEST_FRAMES]
    if not wholes:
        raise GapError("the trials have too few usable samples; record longer ones")
    if hold_out is not None:
        hold_out.check([part.trial for part in wholes])
    alone = len({part.gait for part in wholes}) == len(wholes)
    if alone if hold_out is None else hold_out.last_third:
        pairs = [_split_one(trials[part.trial], part) for part in wholes]
        return tuple(fit for fit, _ in pairs), tuple(judge for _, judge in pairs)
    held = _held_out(wholes)
    if hold_out is not None:
        held = {i for i, part in enumerate(wholes) if part.trial in hold_out.trials}
    return (
        tuple(part for i, part in enumerate(wholes) if i not in held),
        tuple(part for i, part in enumerate(wholes) if i in held),
    )


def _held_out(parts: list[TrialPart]) -> set[int]:
    """Evenly spaced trials of the gaits that have most of them; every gait keeps one to fit to."""
    wanted = max(1, round(HELD_OUT_SHARE * len(parts)))
    gaits: dict[str, list[int]] = {}
    for i, part in enumerate(parts):
        gaits.setdefault(part.gait, []).append(i)
    held: set[int] = set()
    order = sorted(gaits.values(), key=lambda of: (-len(of), of))
    while len(held) < wanted:
        free = [of for of in order if len([i for i in of if i not in held]) > 1]
        if not free:
            break  # every gait keeps one to fit to
        of = max(free, key=lambda group: len([i for i in group if i not in held]))
        left = [i for i in of if i not in held]
        count = sum(i in held for i in of)
        held.add(left[-1] if len(of) <= 4 else left[(2 + 3 * count) % len(left)])
    return held


def _split_one(trial: Trial, whole: TrialPart) -> tuple[TrialPart, TrialPart]:
    o = whole.observation
    blocks = block_starts(o)
    if len(blocks) >= 6:
        cut, after = blocks[(2 * len(blocks)) // 3 - 1], blocks[(2 * len(blocks)) // 3]
    else:
        cut, after = int(0.6 * whole.frames), int(0.67 * whole.frames)
    fitted = part_of(whole.trial, trial, o, 0, int(cut))
    judge = part_of(whole.trial, trial, o, int(after), whole.frames)
    return fitted, judge


def block_starts(observation: Observation) -> IntArray:
    """Return the first frame of each block: a cycle, or a second where there are no cycles."""
    time_s, cycle = observation.time_s, observation.cycle
    if np.isfinite(cycle).all() and abs(cycle[-1] - cycle[0]) >= 2:
        count = np.floor(np.abs(cycle - cycle[0]))
        at = np.flatnonzero(np.diff(count, prepend=-1) > 0)
    else:
        at = np.flatnonzero(np.diff(np.floor(time_s - time_s[0]), prepend=-1) > 0)
    starts = [0]
    for frame in at[1:]:
        if time_s[frame] - time_s[starts[-1]] >= SHORTEST_BLOCK_S * (1 - 1e-9):
            starts.append(int(frame))
    if len(starts) > 1 and time_s[-1] - time_s[starts[-1]] < LAST_BLOCK * (
        time_s[starts[-1]] - time_s[starts[-2]]
    ):
        starts.pop()
    return np.array(starts, dtype=np.int64)


def folds_of(parts: Sequence[TrialPart], starts: Sequence[IntArray]) -> IntArray:
    """Return the fold of each block of all parts: whole trials, or thirds where there are few."""
    folds = []
    for number, at in enumerate(starts):
        if len(parts) >= 3:
            folds.append(np.full(len(at), number % MOST_FOLDS))
        else:
            thirds = np.minimum(np.arange(len(at)) * 3 // max(len(at), 1), 2)
            folds.append(thirds + 3 * number)
    return np.concatenate(folds).astype(np.int64)
