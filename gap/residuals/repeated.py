"""What remains again in every cycle at each joint, beside what does so in healthy runs.

A cause that only resembles the true one leaves most at its own joint, at the same phases of every cycle. A
mean over the cycles shows that below noise in which energies drown it.
"""

from collections.abc import Collection, Sequence

import numpy as np

from gap.residuals.energies import scatter_between
from gap.residuals.evidence import Evidence, mean_energy
from gap.residuals.healthy import Healthy
from gap.residuals.parts import TrialPart
from model.values.arrays import FloatArray, IntArray

PHASE_BINS = 8
FEWEST_RUNS = 3
MOST_LEAD = 4.0  # standard errors; more says no more


def phase_bins(part: TrialPart) -> IntArray:
    """Phase bin of each frame of a part, (F,); 0 throughout where there are no cycles."""
    cycle = part.observation.cycle
    known = np.isfinite(cycle).all()
    phase = np.mod(cycle, 1.0) if known else np.zeros(part.frames)
    return np.minimum((phase * PHASE_BINS).astype(np.int64), PHASE_BINS - 1)


def lead_of_joints(
    evidence: Evidence, residual: FloatArray, healthy: Sequence[Healthy], named: Collection[str]
) -> float:
    """Return by how many standard errors more is left at one of some joints than at any other.

    Args:
        evidence: The trials.
        residual: What causes leave, whitened, (F, C).
        healthy: References in units of what the others predict; fewer than three say nothing.
        named: Joints at which the causes are.

    Returns:
        Standard errors, 0 to ``MOST_LEAD``: how far what repeats at the joint is above what it is in
        healthy runs, minus the same of the joint where that is most of all others.
    """
    every = sorted({one.joint for one in evidence.simulator.channels if one.joint})
    on = np.array([joint in named for joint in every])
    if len(healthy) < FEWEST_RUNS or not on.any() or on.all():
        return 0.0
    dependence, ends = (
        evidence.floor.dependence,
        np.cumsum([part.frames for part in evidence.parts]),
    )
    columns = [
        np.array([one.joint == joint for one in evidence.simulator.channels]) for joint in every
    ]

    def logs(part: TrialPart, left: FloatArray, count: FloatArray) -> list[float]:
        means = _means(part, left, count) / np.sqrt(dependence)
        return [float(np.log(_mean_square(means[:, own]) + 1e-12)) for own in columns]

    trials = np.array([
        logs(part, residual[end - part.frames : end], evidence.frame_count[end - part.frames : end])
        for part, end in zip(evidence.parts, ends, strict=True)
    ])  # fmt: skip
    runs = np.array([logs(one.part, one.residual, one.whitener.count) for one in healthy])
    known = np.isfinite(trials).all(axis=0) & np.isfinite(runs).all(axis=0)
    if not (known & on).any() or not (known & ~on).any():
        return 0.0
    trials, runs, on = trials[:, known], runs[:, known], on[known]
    error = scatter_between(runs) * np.sqrt(1.0 / len(runs) + 1.0 / len(trials))
    above = (trials.mean(axis=0) - runs.mean(axis=0)) / error
    return float(np.clip(above[on].max() - max(above[~on].max(), 0.0), 0.0, MOST_LEAD))


def _means(part: TrialPart, left: FloatArray, count: FloatArray) -> FloatArray:
    """Mean of each phase bin and channel, (bins, C); NaN where nothing was compared."""
    bins = phase_bins(part)
    every = [bins == one for one in range(PHASE_BINS)]
    return np.array([mean_energy(left[on].sum(axis=0), count[on].sum(axis=0)) for on in every])


def _mean_square(means: FloatArray) -> float:
    known = means[np.isfinite(means)]
    return float((known**2).mean()) if len(known) else np.nan
