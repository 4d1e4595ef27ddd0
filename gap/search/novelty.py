"""Whether a cause's size in the trials is beyond how that size differs between healthy runs.

Friction, springs and loads of a machine differ a little from day to day, alike through all of a run;
blocks of a run cannot tell that, only runs can. So the fitted cause is fitted again, by its amplitude
alone, to each run: 1 in the trials if it is right, about 0 in references, each foretold by the others. The
two are compared by Student's t over runs. Its scatter is pooled over the joints at which the effect could
act, and steadied by what the noise lets expect (Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3:3).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from model.values.arrays import FloatArray

STEADY = 4.0  # degrees of freedom that the scatter from noise alone is worth


@dataclass(frozen=True, slots=True)
class Novelty:
    """How much a cause stands out among healthy runs.

    Attributes:
        trials: Mean amplitude in the trials.
        healthy: Mean amplitude in references.
        scatter: Standard deviation from run to run.
        p: One-sided chance of so much in a healthy machine, for this one candidate.
    """

    trials: float
    healthy: float
    scatter: float
    p: float


def novelty(
    evidence: Evidence,
    healthy: Evidence,
    causes: tuple[Cause, ...],
    residual: FloatArray,
    added: Cause,
    joints: Sequence[str],
) -> Novelty:
    """Compare trials with references.

    Args:
        evidence: The trials.
        healthy: The references, each whitened by what others let expect.
        causes: All causes as fitted, ``added`` among them.
        residual: Residual of the trials with all of them, (F, C).
        added: The cause in question.
        joints: All joints of the machine.
    """
    seen = sizes_in_trials(evidence, causes, residual, added)
    if not len(seen):
        return Novelty(0.0, 0.0, 0.0, 1.0)  # it changes nothing where something is compared
    places = [(joint,) for joint in joints] if len(added.joints) == 1 else [added.joints]
    order = [added.joints, *(place for place in places if place != added.joints)]
    changed = healthy.residuals([(Cause(added.effect, place, added.values),) for place in order])
    base = healthy.base
    weights = healthy.weights(base)
    found = [amplitudes(healthy, base, base - one, weights) for one in changed]
    known, noise = found[0]
    rows = [values for values, _ in found if len(values) > 1]
    square = sum(float(((v - v.mean()) ** 2).sum()) for v in rows)
    free = float(sum(len(v) - 1 for v in rows))
    square += float(((seen - seen.mean()) ** 2).sum())
    free += len(seen) - 1
    steady = float(np.mean(noise)) if len(noise) else 0.0
    variance = (square + STEADY * steady) / (free + STEADY)
    n, m = max(len(known), 1), len(seen)
    mean = float(known.mean()) if len(known) else 0.0
    error = np.sqrt(variance * (1 / n + 1 / m))
    t = (float(seen.mean()) - mean) / max(error, 1e-12)
    return Novelty(
        float(seen.mean()), mean, float(np.sqrt(variance)), float(stats.t.sf(t, free + STEADY))
    )


def sizes_in_trials(
    evidence: Evidence, causes: tuple[Cause, ...], residual: FloatArray, added: Cause
) -> FloatArray:
    """Size of one of the causes in each run, (R,), 1 where it is as fitted to all of them.

    Args:
        evidence: The trials.
        causes: All causes as fitted, ``added`` among them.
        residual: Residual with all of them, (F, C).
        added: The cause in question.
    """
    rest = tuple(one for one in causes if one is not added)
    without = evidence.residuals([rest])[0]
    return amplitudes(evidence, without, without - residual, evidence.weights(residual))[0]


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
