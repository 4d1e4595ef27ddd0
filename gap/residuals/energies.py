"""Whether trials have more energy than healthy runs, whatever the cause."""

from collections.abc import Sequence

import numpy as np
from scipy import special

from gap.constants import CHANNELS_APART, LEAST_SCATTER
from gap.residuals.chances import HeldOutChances, leave_each_out
from gap.residuals.evidence import Evidence, mean_energy
from gap.residuals.healthy import Healthy
from model.values.arrays import FloatArray


def chance_of_energies(
    evidence: Evidence, residual: FloatArray, healthy: Sequence[Healthy]
) -> float:
    """Return the chance of so much energy in a healthy machine, in the mean or in the worst channel.

    The residual of the trials is whitened, (F, C), with or without causes.
    """
    energy = evidence.per_block(residual**2)
    blocks = [evidence.block_part == i for i in range(len(evidence.parts))]
    trials = np.array(
        [mean_energy(energy[on].sum(axis=0), evidence.count[on].sum(axis=0)) for on in blocks]
    )
    runs = np.array([one.excess for one in healthy])
    held_out = [
        _energy_chance(runs[[held]], runs[list(others)])
        for held, others in leave_each_out(len(runs))
    ]
    return HeldOutChances(tuple(held_out)).calibrated(_energy_chance(trials, runs))


def _energy_chance(trials: FloatArray, runs: FloatArray) -> float:
    """Chance of the energies of M trials, (M, C), by Student's t over N runs, (N, C).

    NaN is what a run did not measure; a channel counts that some trial and two runs did.
    """
    trial_logs, run_logs = np.log(trials + 1e-9), np.log(runs + 1e-9)
    own, others = np.isfinite(trial_logs).sum(axis=0), np.isfinite(run_logs).sum(axis=0)
    known = (own > 0) & (others > 1)
    if not known.any():
        return 1.0
    own, others = own[known], others[known]
    centre = np.nanmean(run_logs[:, known], axis=0)
    trial_logs, run_logs = trial_logs[:, known] - centre, run_logs[:, known] - centre
    trial_means, means = _means(trial_logs), _means(run_logs)
    scatter = max(float(means.std(ddof=1)), LEAST_SCATTER)
    apart = scatter * np.sqrt(1 / len(means) + 1 / len(trial_means))
    p_mean = float(special.stdtr(len(means) - 1, -(trial_means.mean() - means.mean()) / apart))
    width = scatter_between(run_logs)
    worst = float(np.max(np.nanmean(trial_logs, axis=0) / np.sqrt(1 / others + 1 / own)))
    free = float(others.mean() - 1) * min(len(others), float(CHANNELS_APART))
    p_channel = float(special.stdtr(free, -worst / width))
    return min(1.0, 2 * min(p_mean, p_channel * len(others)))


def _means(logs: FloatArray) -> FloatArray:
    """Mean of each run, of those that measured anything."""
    return np.asarray(np.nanmean(logs[np.isfinite(logs).any(axis=1)], axis=1))


def scatter_between(run_logs: FloatArray) -> float:
    """Scatter of logarithms of energies between N runs, (N, K), about the mean of each of K, pooled.

    NaN is what a run did not measure.
    """
    centred = run_logs - np.nanmean(run_logs, axis=0)
    free = int(np.isfinite(centred).sum()) - centred.shape[1]
    return max(float(np.sqrt(np.nansum(centred**2) / free)), LEAST_SCATTER)
