"""Whether trials are commanded as no reference was: a turn where all references walked straight ahead.

What the simulator gets wrong on such runs no reference shows, so it looks like a cause in the machine.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.residuals.healthy import SAME_CONDITION, apart
from gap.residuals.parts import TrialPart

SAME_RAD = 0.003  # commands that differ by less are the same: two steps of a servo's encoder
BEYOND = 1.25  # times what references differ by from the nearest other one


@dataclass(frozen=True, slots=True)
class NewCommands:
    """How far the commands of a trial are from those of all references of its gait.

    Attributes:
        trial: Index of the trial that is farthest.
        trials: Indices of all that are as no reference was.
        distance_rad: From the nearest reference: root mean square over a cycle, of the joint that differs
            most.
        known_rad: The largest such distance of a reference from the nearest other one that differs at all;
            0 where all are commanded alike.
    """

    trial: int
    trials: tuple[int, ...]
    distance_rad: float
    known_rad: float

    @property
    def words(self) -> str:
        """Say it in a sentence."""
        known = f"are within {self.known_rad:.2g} rad of another one"
        alone = "are commanded alike, or there is but one"
        return (
            f"the commands of {self.runs} are up to {self.distance_rad:.2g} rad (RMS over a cycle) from "
            f"those of the nearest reference; references of its gait {known if self.known_rad else alone}"
        )

    @property
    def runs(self) -> str:
        """Name the trials, numbered from 1."""
        numbers = [str(one + 1) for one in self.trials]
        return f"run {numbers[0]}" if len(numbers) == 1 else f"runs {', '.join(numbers)}"


def new_commands(
    trials: Sequence[TrialPart], references: Sequence[TrialPart]
) -> NewCommands | None:
    """Return the trial that is farthest from all references; None where none is beyond them.

    Trials without cycles or commands, or of a gait that no reference has, are left out.
    """
    each = []
    for one in trials:
        same = [other for other in references if other.gait == one.gait]
        own = _distances(one, same)
        if not own:
            continue
        known = [_nearest_other(other, same) for other in same]
        each.append(NewCommands(one.trial, (one.trial,), min(own), max(known)))
    beyond = [one for one in each if one.distance_rad > BEYOND * one.known_rad + SAME_RAD]
    if not beyond:
        return None
    farthest = max(beyond, key=lambda one: one.distance_rad)
    return replace(farthest, trials=tuple(sorted({one.trial for one in beyond})))


def none_repeats(references: Sequence[TrialPart]) -> bool:
    """Whether no two references were commanded alike, so that they tell nothing of how well a run repeats.

    References without cycles or commands may be alike.
    """
    pairs = itertools.combinations(references, 2)
    return bool(references) and not any(_alike(one, other) for one, other in pairs)


def _alike(one: TrialPart, other: TrialPart) -> bool:
    if apart(one.condition, other.condition) != SAME_CONDITION:
        return False
    return all(far < SAME_RAD for far in _distances(one, [other]))


def _distances(one: TrialPart, others: Sequence[TrialPart]) -> list[float]:
    return [
        one.commands.distance_rad(other.commands)
        for other in others
        if one.commands is not None and other.commands is not None
    ]


def _nearest_other(one: TrialPart, every: Sequence[TrialPart]) -> float:
    apart = [far for far in _distances(one, every) if far > SAME_RAD]
    return float(np.min(apart)) if apart else 0.0
