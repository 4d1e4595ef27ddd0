"""Which run discriminates best between the remaining candidates.

Each pair of candidates is played through each run that a machine could make; what is left of their
difference after one is adjusted to the other is what the run would show.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gap.experiments.imitation import UNSEEN, Imitation, noise_of
from gap.interfaces import Cause, Proposal, Simulator, place_words
from gap.residuals.floor import Floor
from gap.residuals.predictions import Predictor
from gap.search.fit import ENOUGH_SEPARATION, energy_left, free_values, slopes_of

MOST_RUNS = 20  # more of one run is not worth proposing


@dataclass(frozen=True, slots=True)
class NextRun:
    """How well a run separates candidates.

    Attributes:
        pair: The two candidates that it separates least.
        separation: Energy between them, in units of noise.
        runs: How many runs make the choice sure to one in a hundred.
        minutes: Of all of them.
        command: Command line that makes one; empty if there is none.
    """

    name: str
    pair: tuple[str, str]
    separation: float
    runs: int
    minutes: float
    limits: str
    command: str = ""


def next_runs(
    proposals: Sequence[Proposal],
    simulator: Simulator,
    rivals: Sequence[tuple[Cause, ...]],
    floor: Floor,
    progress: Callable[[float], None] = lambda share: None,
) -> tuple[NextRun, ...]:
    """Rank proposals: the one that separates its least separated pair most for a minute's work first.

    One that would have to be made more than ``MOST_RUNS`` times is left out.

    Args:
        proposals: Runs that could be made.
        simulator: The simulator.
        rivals: Alternative sets of causes to discriminate between.
        floor: Its noise, of the runs that judge.
        progress: Gets the share that is done.
    """
    judged = []
    for number, one in enumerate(proposals):
        judged.append(_judge(one, simulator, rivals, floor))
        progress((number + 1) / len(proposals))
    useful = [one for one in judged if one is not None]
    return tuple(sorted(useful, key=lambda one: one.minutes / (one.runs * one.separation)))


def _judge(
    one: Proposal, simulator: Simulator, rivals: Sequence[tuple[Cause, ...]], floor: Floor
) -> NextRun | None:
    least, pair = np.inf, ("", "")
    # ends and contact switches weigh as little as they will when the run is diagnosed
    noise = noise_of(simulator, [one.trial], floor)
    blind = np.array([channel.name in one.unseen for channel in simulator.channels])
    noise = [np.where(blind, UNSEEN, own) for own in noise]
    predictor = Predictor(simulator, [one.trial], standing=one.known)
    for a, b in itertools.combinations(rivals, 2):
        apart = min(
            _apart(Imitation(predictor, noise, goal), other) for goal, other in ((a, b), (b, a))
        )
        if apart < least:
            least, pair = apart, _names(a, b)
    if not np.isfinite(least) or least <= 0.0:
        return None
    runs = int(np.ceil(ENOUGH_SEPARATION / least))
    if runs > MOST_RUNS:
        return None
    return NextRun(one.name, pair, float(least), runs, runs * one.minutes, one.limits, one.command)


def _names(a: tuple[Cause, ...], b: tuple[Cause, ...]) -> tuple[str, str]:
    """Name what two sets of causes differ in."""
    own = [place_words(one.effect, one.joints) for one in a if one not in b]
    other = [place_words(one.effect, one.joints) for one in b if one not in a]
    return (" and ".join(own) or "nothing", " and ".join(other) or "nothing")


def _apart(misfit: Imitation, causes: tuple[Cause, ...]) -> float:
    """Energy between the goal and causes that are adjusted to it."""
    residual = misfit.residuals([causes])[0]
    free = free_values(causes, misfit.effects)
    return energy_left(residual, slopes_of(misfit, causes, free, residual))
