"""Whether trials have more energy than healthy runs, whatever the cause.

Two energies are looked at: all of what is left, and what is another in each cycle
(``gap.residuals.unrepeated``), of which healthy runs hardly differ. Each is compared twice: with runs of
all gaits, and gait by gait, because the same machine may leave a hundred times as much of a force in one
gait as in another.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gap.constants import LEAST_ENERGY
from gap.residuals.chances import HeldOutChances, harmonic_mean
from gap.residuals.energy_tests import (
    EnergyChance,
    RunEnergies,
    among_joints,
    gait_by_gait,
    together,
)
from gap.residuals.evidence import Evidence, mean_energy
from gap.residuals.floor import ENOUGH_REFERENCES
from gap.residuals.healthy import Healthy, whitened_runs
from gap.residuals.same_day import days_of, leave_each_day_out
from gap.residuals.unrepeated import unrepeated
from model.values.arrays import FloatArray

NO_ENERGY = 1e-9  # in the place of 0, whose logarithm is none


def chance_of_energies(
    evidence: Evidence,
    residual: FloatArray,
    healthy: Sequence[Healthy],
    *,
    joints_alike: bool = True,
) -> EnergyChance:
    """Return the chance of so much energy in a healthy machine, in the mean or in the worst channel.

    Args:
        evidence: The trials.
        residual: Theirs, whitened, (F, C), with or without causes.
        healthy: References.
        joints_alike: Whether a joint is also held against the others of its run. What causes leave is more
            at their joints, as no effect has exactly the form of the modelled one.
    """
    kinds = [channel.name for channel in evidence.simulator.channels]
    gaits = tuple(part.gait for part in evidence.parts)
    known = tuple(one.part.gait for one in healthy)
    days, known_days = days_of(evidence.parts), days_of([one.part for one in healthy])
    left = whitened_runs(evidence, residual)
    # a window reads what lasts once: of its energy little is known that its size does not say
    lasting = np.array([channel.lasting for channel in evidence.simulator.channels])
    energies = [
        mean_energy((one.residual**2).sum(axis=0), whitener.count.sum(axis=0))
        for one, whitener in zip(left, evidence.whiteners, strict=True)
    ]
    another = [unrepeated(one.part, one.residual) for one in left]
    # a run that repeats better than it has to does so by chance: of all that is left, little is nothing
    views = [
        (energies, [one.excess for one in healthy], float(LEAST_ENERGY)),
        (another, [one.unrepeated for one in healthy], NO_ENERGY),
    ]
    chances: list[EnergyChance] = []
    for number, (own, others, least) in enumerate(views):
        trials = RunEnergies(gaits, np.log(np.where(lasting, np.nan, own) + least)).by_day(days)
        runs = RunEnergies(known, np.log(np.array(others) + least)).by_day(known_days)
        if (one := _chance_of(kinds, trials, runs, joints_alike)) is not None:
            chances.append(replace(one, another=number == 1))
    surest = min(chances, key=lambda one: one.p, default=EnergyChance(1.0))
    return replace(surest, p=min(1.0, len(chances) * surest.p)) if chances else surest


def _chance_of(
    kinds: Sequence[str], trials: RunEnergies, runs: RunEnergies, joints_alike: bool
) -> EnergyChance | None:
    """Chance of the energies of trials beside those of references, calibrated; None if unknown.

    Each of two references is predicted by the other alone, so both show one difference, and its energy
    counts once; then trials tell how much energies scatter.
    """
    if len(runs.logs) < ENOUGH_REFERENCES:
        return together(kinds, trials.logs, runs.logs.mean(axis=0, keepdims=True), trials.logs)
    tests: list[Callable[[RunEnergies, RunEnergies], EnergyChance | None]] = [
        lambda own, known: together(kinds, own.logs, known.logs, known.logs),
        lambda own, known: gait_by_gait(kinds, own, known),
    ]
    if joints_alike:
        tests.append(lambda own, known: among_joints(kinds, own, known))
    made = [_calibrated(test, trials, runs) for test in tests]
    chances = [one for one in made if one is not None]
    if made[0] is None:
        return None
    surest = min(chances, key=lambda one: one.p)
    return replace(surest, p=min(1.0, harmonic_mean(*(one.p for one in chances))))


def _calibrated(
    test: Callable[[RunEnergies, RunEnergies], EnergyChance | None],
    trials: RunEnergies,
    runs: RunEnergies,
) -> EnergyChance | None:
    """Return what a test's chance is worth after references that are held out, each in turn."""
    chance = test(trials, runs)
    if chance is None:
        return None
    each_out = leave_each_day_out((), len(runs.logs))  # of each day there is one already
    held = [test(runs.some(own), runs.some(rest)) for own, rest in each_out]
    null = HeldOutChances(tuple(one.p for one in held if one is not None))
    return replace(chance, p=null.calibrated(chance.p))
