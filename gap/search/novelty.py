"""Whether a cause's size in the trials is beyond how that size differs between healthy runs.

Friction, springs and loads of a machine differ a little from day to day, alike through all of a run;
blocks of a run cannot show that, only runs can. So the fitted cause is fitted again, by its amplitude
alone, to each run: 1 in the trials if it is right, about 0 in references, each predicted by the others.
The two are compared by Student's t over runs. Its scatter is pooled over the joints at which the effect
could act, and steadied by what the noise lets expect (Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3:3).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from gap.interfaces import Cause, places_for
from gap.residuals.evidence import Evidence
from gap.search.fit import Fitted
from model.values.arrays import FloatArray

STEADY = 4.0  # degrees of freedom that the scatter from noise alone is worth


def chance_healthy(evidence: Evidence, healthy: Evidence, fitted: Fitted, added: Cause) -> float:
    """Return the one-sided chance of so large a cause in a healthy machine, for this one candidate.

    References are whitened by what others predict; the fit has all causes, ``added`` among them.
    """
    seen = sizes_in_trials(evidence, fitted, added)
    if not len(seen):
        return 1.0  # it changes nothing where something is compared
    simulator = evidence.simulator
    effect = next(one for one in simulator.effects if one.name == added.effect)
    single = len(added.joints) == 1
    places = [(place,) for place in places_for(effect, simulator)] if single else [added.joints]
    order = [added.joints, *(place for place in places if place != added.joints)]
    sizes = sizes_in_references(healthy, [replace(added, joints=place) for place in order])
    known, noise = sizes[0]
    square, free = scatter([seen, *(values for values, _ in sizes)])
    steady = float(np.mean(noise)) if len(noise) else 0.0
    variance = (square + STEADY * steady) / (free + STEADY)
    n, m = max(len(known), 1), len(seen)
    mean = float(known.mean()) if len(known) else 0.0
    error = np.sqrt(variance * (1 / n + 1 / m))
    t = (float(seen.mean()) - mean) / max(error, 1e-12)
    return float(stats.t.sf(t, free + STEADY))


def scatter(groups: Sequence[FloatArray]) -> tuple[float, int]:
    """Return the squares of values about the mean of their group, summed, and the degrees of freedom."""
    there = [one for one in groups if len(one)]
    square = sum(float(((one - one.mean()) ** 2).sum()) for one in there)
    return square, sum(len(one) - 1 for one in there)


def sizes_in_trials(evidence: Evidence, fitted: Fitted, added: Cause) -> FloatArray:
    """Size of one of the fitted causes in each run, (R,), 1 where it is as fitted to all of them."""
    rest = tuple(one for one in fitted.causes if one is not added)
    without = evidence.residuals([rest])[0]
    return amplitudes(
        evidence, without, without - fitted.residual, evidence.weights(fitted.residual)
    )[0]


def sizes_in_references(
    healthy: Evidence, causes: Sequence[Cause]
) -> list[tuple[FloatArray, FloatArray]]:
    """Return for each cause by itself its size in each reference, (R,), and the variance by noise, (R,)."""
    base, weights = healthy.base, healthy.weights(healthy.base)
    changed = healthy.residuals([(one,) for one in causes])
    return [amplitudes(healthy, base, base - one, weights) for one in changed]


def amplitudes(
    evidence: Evidence, residual: FloatArray, change: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Fit a change to each run by its size alone: sizes (R,), and their variances by noise (R,).

    Runs in which the change cannot be seen are left out.
    """
    weighted = change * weights
    along = evidence.per_block(weighted * residual).sum(axis=1)
    power = evidence.per_block(weighted * change).sum(axis=1)
    runs = np.arange(evidence.block_part.max() + 1)
    pull = np.array([along[evidence.block_part == run].sum() for run in runs])
    size = np.array([power[evidence.block_part == run].sum() for run in runs])
    seen = size > 1e-3 * max(float(size.max()), 1e-30)
    return pull[seen] / size[seen], 1.0 / size[seen]
