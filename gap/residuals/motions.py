"""Motions that do not repeat within a run, such as a chirp: what references of one show, moment by moment.

What a simulator has wrong of a gait comes back in each cycle. A motion that is made once in a run has no
cycle, but where all references of it were commanded alike, the whole run is one: what they show at a moment
is expected there. A motion that was commanded otherwise each time has no moments to compare.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gap.constants import MOTION_HARMONICS, MOTION_UNLIKE
from gap.residuals.parts import TrialPart
from record.trial.trial import Trial

FEWEST = 2  # references of a motion, to be commanded alike

Motions = Mapping[str, float]


def motions_of(
    references: Sequence[TrialPart], trials: Sequence[Trial], others: Sequence[TrialPart] = ()
) -> Motions:
    """Return the motions that references repeat from run to run, by name, with how long they take [s].

    Args:
        references: Whole runs.
        trials: Those that they are parts of, in the same order.
        others: Parts of runs that are compared with them; none of them goes on for longer.
    """
    named: dict[str, list[int]] = {}
    for number, part in enumerate(references):
        named.setdefault(part.gait, []).append(number)
    seconds: dict[str, float] = {}
    for gait, own in named.items():
        once = not any(np.isfinite(references[i].observation.cycle).any() for i in own)
        if once and len(own) >= FEWEST and _alike([trials[i] for i in own]):
            every = (part for part in (*references, *others) if part.gait == gait)
            seconds[gait] = max(float(part.observation.time_s[-1]) for part in every)
    return seconds


def in_motion(motions: Motions, parts: Sequence[TrialPart]) -> tuple[TrialPart, ...]:
    """Return parts that know how long their motion takes, and how finely it is described."""
    if not motions:
        return tuple(parts)
    return tuple(
        replace(
            part,
            motion_s=motions.get(part.gait, np.nan),
            harmonics=int(MOTION_HARMONICS),
        )
        for part in parts
    )


def _alike(trials: Sequence[Trial]) -> bool:
    """Whether runs were commanded alike at the same time since their start, joint by joint."""
    first, *others = trials
    commands = first.command_rad
    known = np.isfinite(commands).all(axis=0)
    if not known.any():
        return False
    time_s = first.time_s - first.time_s[0]
    usual = commands[:, known].std(axis=0)
    for other in others:
        since_s = other.time_s - other.time_s[0]
        on = time_s <= since_s[-1]
        again = np.stack(
            [np.interp(time_s[on], since_s, one) for one in other.command_rad[:, known].T], axis=1
        )
        apart = np.sqrt(np.mean((again - commands[on][:, known]) ** 2, axis=0))
        if not bool(np.all(apart <= MOTION_UNLIKE * usual)):
            return False
    return True
