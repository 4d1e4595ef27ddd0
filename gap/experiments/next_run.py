"""Which run would tell the remaining candidates apart.

A machine's side makes ``Proposal``s: trials with commands and nothing measured. Each pair of candidates is
played through each of them; what is left of their difference after one is adjusted to the other is what a
run would show.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gap.interfaces import Cause, Drive, Simulator, place_words
from gap.residuals.floor import Floor
from gap.search.candidates import FINE_STEP, step_of
from model.values.arrays import FloatArray
from record.trial.trial import Trial

ENOUGH_SEPARATION = 4 * 2.33**2
MOST_RUNS = 20  # nobody makes more of one run to tell two causes apart


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A run that could be made.

    Attributes:
        name: What to do, in words.
        trial: Its commands; nothing measured.
        minutes: How long it takes.
        limits: What to mind, in words; empty if nothing.
        known: What is done to the machine on purpose, such as a weight put on it.
        command: Command line that makes it; empty if there is none.
    """

    name: str
    trial: Trial
    minutes: float
    limits: str
    known: tuple[Cause, ...] = ()
    command: str = ""


class Proposer(Protocol):
    """Makes proposals for a machine."""

    def proposals(self) -> Sequence[Proposal]:
        """Return runs that this machine could make."""
        ...


@dataclass(frozen=True, slots=True)
class NextRun:
    """How well a run would tell.

    Attributes:
        name: What to do.
        pair: The two candidates that it tells least well.
        separation: Energy between them, in units of noise.
        runs: How many runs make the choice sure to one in a hundred.
        minutes: Of all of them.
        limits: What to mind.
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
        rivals: Sets of causes between which to tell.
        floor: Its noise under ``Drive.COMMAND``.
        progress: Told the share that is done.
    """
    found = []
    for number, one in enumerate(proposals):
        found.append(_judge(one, simulator, rivals, floor))
        progress((number + 1) / len(proposals))
    told = [one for one in found if one is not None]
    return tuple(sorted(told, key=lambda one: one.minutes / (one.runs * one.separation)))


def _judge(
    one: Proposal, simulator: Simulator, rivals: Sequence[tuple[Cause, ...]], floor: Floor
) -> NextRun | None:
    # ends and contact switches weigh as little as they will when the run is diagnosed
    weight = np.sqrt(simulator.observe(one.trial).weight)
    noise = np.fmax(floor.sigma * np.sqrt(floor.dependence), 1e-12) / np.fmax(weight, 1e-12)
    least, pair = np.inf, ("", "")
    for a, b in itertools.combinations(rivals, 2):
        apart = min(_apart(simulator, one, a, b, noise), _apart(simulator, one, b, a, noise))
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


def _apart(
    simulator: Simulator,
    proposal: Proposal,
    of: tuple[Cause, ...],
    by: tuple[Cause, ...],
    noise: FloatArray,
) -> float:
    def told(causes: tuple[Cause, ...]) -> FloatArray:
        everything = (*causes, *proposal.known)
        predicted = simulator.predict(proposal.trial, everything, Drive.COMMAND)
        predicted = predicted / noise
        return np.nan_to_num(predicted).ravel()

    effects = {effect.name: effect for effect in simulator.effects}
    there, goal = told(by), told(of)
    slopes = []
    for i, cause in enumerate(by):
        for k, p in enumerate(effects[cause.effect].parameters):
            step = step_of(p, cause.values[k], FINE_STEP)
            values = tuple(v + (step if j == k else 0.0) for j, v in enumerate(cause.values))
            moved = (*by[:i], Cause(cause.effect, cause.joints, values), *by[i + 1 :])
            slopes.append((told(moved) - there) * (p.spread / step))
    left = goal - there
    if slopes:
        rows = np.array(slopes)
        left = left - rows.T @ np.linalg.lstsq(rows.T, left, rcond=None)[0]
    return float(left @ left)
