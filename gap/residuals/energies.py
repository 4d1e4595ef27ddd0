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
    """Chance of the energies of M trials, (M, C), by Student's t over N runs, (N, C)."""
    trial_logs, run_logs = np.log(trials + 1e-9), np.log(runs + 1e-9)
    n, m = len(run_logs), len(trial_logs)
    known = np.isfinite(trial_logs).all(axis=0) & np.isfinite(run_logs).all(axis=0)
    if not known.any() or n < 2:
        return 1.0
    trial_logs, run_logs = trial_logs[:, known], run_logs[:, known]
    mean = run_logs.mean(axis=1)
    scatter = max(float(mean.std(ddof=1)), LEAST_SCATTER)
    t = (trial_logs.mean() - mean.mean()) / (scatter * np.sqrt(1 / n + 1 / m))
    p_mean = float(special.stdtr(n - 1, -t))
    width = scatter_between(run_logs)
    worst = float(np.max(trial_logs.mean(axis=0) - run_logs.mean(axis=0)))
    free = (n - 1) * min(int(known.sum()), CHANNELS_APART)
    p_channel = float(special.stdtr(free, -worst / (width * np.sqrt(1 / n + 1 / m))))
    return min(1.0, 2 * min(p_mean, p_channel * int(known.sum())))


def scatter_between(run_logs: FloatArray) -> float:
    """Scatter of logarithms of energies between N runs, (N, K), about the mean of each of K, pooled."""
    centred = run_logs - run_logs.mean(axis=0)
    free = centred.size - centred.shape[1]
    return max(float(np.sqrt((centred**2).sum() / free)), LEAST_SCATTER)
