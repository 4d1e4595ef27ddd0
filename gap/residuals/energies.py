"""Whether trials have more energy than healthy runs, whatever the cause."""

from collections.abc import Sequence

import numpy as np
from scipy import special

from gap.constants import CHANNELS_APART, LEAST_SCATTER
from gap.residuals.chances import HeldOutChances, leave_each_out
from gap.residuals.evidence import Evidence, mean_energy
from gap.residuals.floor import ENOUGH_REFERENCES
from gap.residuals.healthy import Healthy
from model.values.arrays import FloatArray


def chance_of_energies(
    evidence: Evidence, residual: FloatArray, healthy: Sequence[Healthy]
) -> float:
    """Return the chance of so much energy in a healthy machine, in the mean or in the worst channel.

    Each of two references is predicted by the other alone, so both show one difference, and its energy
    counts once; then trials tell how much energies scatter.

    Args:
        evidence: The trials.
        residual: Theirs, whitened, (F, C), with or without causes.
        healthy: References.
    """
    energy = evidence.per_block(residual**2)
    blocks = [evidence.block_part == i for i in range(len(evidence.parts))]
    trials = np.array(
        [mean_energy(energy[on].sum(axis=0), evidence.count[on].sum(axis=0)) for on in blocks]
    )
    runs = np.array([one.excess for one in healthy])
    trial_logs, run_logs = np.log(trials + 1e-9), np.log(runs + 1e-9)
    if len(runs) < ENOUGH_REFERENCES:
        difference = run_logs.mean(axis=0, keepdims=True)
        return _energy_chance(trial_logs, difference, trial_logs)
    held_out = []
    for held, others in leave_each_out(len(runs)):
        known = run_logs[list(others)]
        held_out.append(_energy_chance(run_logs[[held]], known, known))
    chance = _energy_chance(trial_logs, run_logs, run_logs)
    return HeldOutChances(tuple(held_out)).calibrated(chance)


def _energy_chance(trial_logs: FloatArray, run_logs: FloatArray, alike: FloatArray) -> float:
    """Chance of the energies of M trials, (M, C), by Student's t over N runs, (N, C); logarithms.

    ``alike`` are those of runs that scatter as healthy ones do, (K, C). NaN is what a run did not measure;
    a channel counts that some trial, some run and two of those that are alike did.
    """
    own, others, scattering = (
        np.isfinite(one).sum(axis=0) for one in (trial_logs, run_logs, alike)
    )
    known = (own > 0) & (others > 0) & (scattering > 1)
    if not known.any():
        return 1.0
    own, others, scattering = own[known], others[known], scattering[known]
    centre = np.nanmean(run_logs[:, known], axis=0)
    trial_logs, run_logs, alike = (one[:, known] - centre for one in (trial_logs, run_logs, alike))
    trial_means, means, scattered = _means(trial_logs), _means(run_logs), _means(alike)
    scatter = max(float(scattered.std(ddof=1)), LEAST_SCATTER)
    apart = scatter * np.sqrt(1 / len(means) + 1 / len(trial_means))
    ahead = trial_means.mean() - means.mean()
    p_mean = float(special.stdtr(len(scattered) - 1, -ahead / apart))
    width = scatter_between(alike)
    worst = float(np.max(np.nanmean(trial_logs, axis=0) / np.sqrt(1 / others + 1 / own)))
    free = float(scattering.mean() - 1) * min(len(scattering), float(CHANNELS_APART))
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
