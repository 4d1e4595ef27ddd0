"""How a run is commanded over a cycle of its gait: what tells a turn from a straight walk."""

from dataclasses import dataclass

import numpy as np

from gap.interfaces import Observation
from model.values.arrays import ComplexArray, readonly
from record.trial.trial import Trial

PHASES = 16


@dataclass(frozen=True, slots=True, eq=False)
class CommandCycle:
    """Mean commands over a cycle.

    Attributes:
        phasors: Of the commanded angles, at ``PHASES`` phases of the cycle, (PHASES, J); NaN where a run
            had no command at that phase.
    """

    phasors: ComplexArray

    def distance_rad(self, other: "CommandCycle") -> float:
        """RMS difference over the cycle, of the joint that differs most; 0 without a common phase."""
        if self.phasors.shape != other.phasors.shape:
            return 0.0
        squares = np.abs(self.phasors - other.phasors) ** 2
        known = np.isfinite(squares)
        count = known.sum(axis=0)
        mean = np.where(known, squares, 0.0).sum(axis=0) / np.fmax(count, 1)
        return float(np.sqrt(mean.max(initial=0.0)))


def command_cycle_of(trial: Trial, observation: Observation) -> CommandCycle | None:
    """Return how a trial is commanded; None without cycles or commands."""
    known = np.isfinite(trial.command_rad).all(axis=0)
    if not np.isfinite(observation.cycle).all() or not known.any():
        return None
    cycle, time_s = observation.cycle, observation.time_s
    if len(cycle) > 1 and cycle[-1] < cycle[0]:  # walked backwards
        cycle, time_s = cycle[::-1], time_s[::-1]
    number = np.arange(np.ceil(cycle[0] * PHASES), np.floor(cycle[-1] * PHASES) + 1).astype(
        np.int64
    )
    at_s = np.interp(number / PHASES, cycle, time_s)
    angles = np.unwrap(trial.command_rad[:, known], axis=0)
    since_s = trial.time_s - trial.time_s[0]  # as those of an observation
    turned = np.exp(1j * np.stack([np.interp(at_s, since_s, one) for one in angles.T], axis=1))
    phasors = np.full((PHASES, trial.command_rad.shape[1]), np.nan + 0j)
    for k in range(PHASES):
        at = number % PHASES == k
        if at.any():
            phasors[k, known] = turned[at].mean(axis=0)
    return CommandCycle(readonly(phasors))
