"""Tests of whether energies of trials are larger than those of healthy runs, channel by channel."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from gap.constants import CHANNEL_SCATTER, CHANNELS_APART, ENERGY_LEVEL, LEAST_SCATTER
from gap.residuals.moderated import Scatter, scatter_of_all, steadied
from gap.residuals.same_day import several, together_on_days
from model.values.arrays import BoolArray, FloatArray

FEWEST_JOINTS = 3  # of which the median is not that of one that is wrong
Steady = Callable[[Scatter, Scatter], Scatter]


@dataclass(frozen=True, slots=True)
class EnergyChance:
    """How likely a healthy machine has as much energy as trials.

    Attributes:
        p: The chance; 1 where nothing can be compared.
        channel: Number of the channel that is farthest ahead of references; -1 for none.
        another: Whether that is by what is another in each cycle.
    """

    p: float
    channel: int = -1
    another: bool = False

    @property
    def shows_a_gap(self) -> bool:
        """Whether healthy machines hardly ever have as much, whatever the causes."""
        return self.p < ENERGY_LEVEL


@dataclass(frozen=True, slots=True, eq=False)
class RunEnergies:
    """Energies of R runs.

    Attributes:
        gaits: Of each run.
        logs: Logarithms, (R, C); NaN where a run did not measure a channel.
    """

    gaits: tuple[str, ...]
    logs: FloatArray

    def some(self, runs: Sequence[int]) -> "RunEnergies":
        """Return those of some runs."""
        return RunEnergies(tuple(self.gaits[i] for i in runs), self.logs[list(runs)])

    def by_day(self, days: tuple[str, ...]) -> "RunEnergies":
        """Return the mean of each day's runs, as one run; as they are without days."""
        if not days:
            return self
        groups = together_on_days(days, tuple(range(len(self.gaits))))
        logs = np.array([_mean_known(self.logs[list(own)]) for own in groups])
        return RunEnergies(tuple(several(self.gaits[i] for i in own) for own in groups), logs)

    def of(self, channels: BoolArray) -> "RunEnergies":
        """Return those of some channels, a mask, (C,)."""
        return RunEnergies(self.gaits, self.logs[:, channels])


def together(
    kinds: Sequence[str], trial_logs: FloatArray, run_logs: FloatArray, alike: FloatArray
) -> EnergyChance | None:
    """Return the chance of energies of M trials, (M, C), by Student's t over N runs, (N, C); logarithms.

    ``kinds`` says what each channel measures, at whatever joint, and ``alike`` are the energies of runs
    that scatter as healthy ones do, (K, C). NaN is what a run did not measure; a channel counts that some
    trial, some run and two of those that are alike did. None if there is no such channel.
    """
    own, others, scattering = (
        np.isfinite(one).sum(axis=0) for one in (trial_logs, run_logs, alike)
    )
    known = (own > 0) & (others > 0) & (scattering > 1)
    if not known.any():
        return None
    own, others = own[known], others[known]
    centre = np.nanmean(run_logs[:, known], axis=0)
    trial_logs, run_logs, alike = (one[:, known] - centre for one in (trial_logs, run_logs, alike))
    trial_means, means, scattered = _means(trial_logs), _means(run_logs), _means(alike)
    scatter = max(float(scattered.std(ddof=1)), LEAST_SCATTER)
    apart = scatter * np.sqrt(1 / len(means) + 1 / len(trial_means))
    ahead = trial_means.mean() - means.mean()
    p_mean = float(special.stdtr(len(scattered) - 1, -ahead / apart))
    centred = alike - np.nanmean(alike, axis=0)
    scatters = _scatters(
        [kind for kind, on in zip(kinds, known, strict=True) if on], centred, 1, Scatter.beside
    )
    p_worst, worst = _worst(np.nanmean(trial_logs, axis=0), 1 / others + 1 / own, scatters)
    return EnergyChance(min(1.0, 2 * min(p_mean, p_worst)), int(np.flatnonzero(known)[worst]))


def gait_by_gait(
    kinds: Sequence[str], trials: RunEnergies, runs: RunEnergies
) -> EnergyChance | None:
    """Return the chance of the worst channel, each trial compared with the references of its gait.

    Only channels count that every run measured. None if there is none, one gait alone, a gait without a
    reference, or no two references of a gait.
    """
    known = np.isfinite(np.concatenate([trials.logs, runs.logs])).all(axis=0)
    gaits = {gait: [i for i, one in enumerate(runs.gaits) if one == gait] for gait in runs.gaits}
    if len(gaits) < 2 or len(gaits) == len(runs.gaits) or not known.any():
        return None
    if not set(trials.gaits) <= set(gaits):
        return None
    trials, runs = trials.of(known), runs.of(known)
    means = {gait: runs.logs[own].mean(axis=0) for gait, own in gaits.items()}
    centred = np.array([one - means[gait] for one, gait in zip(runs.logs, runs.gaits, strict=True)])
    ahead = np.array(
        [one - means[gait] for one, gait in zip(trials.logs, trials.gaits, strict=True)]
    )
    shares = {gait: trials.gaits.count(gait) / len(trials.gaits) for gait in gaits}
    variance = 1 / len(ahead) + sum(share**2 / len(gaits[gait]) for gait, share in shares.items())
    # few runs of each gait tell little of how alike the kinds scatter, so no kind has most of the say
    scatters = _scatters(
        [kind for kind, on in zip(kinds, known, strict=True) if on], centred, len(gaits), steadied
    )
    p, worst = _worst(ahead.mean(axis=0), np.full(len(scatters), variance), scatters)
    return EnergyChance(min(1.0, p), int(np.flatnonzero(known)[worst]))


def among_joints(
    kinds: Sequence[str], trials: RunEnergies, runs: RunEnergies
) -> EnergyChance | None:
    """Return the chance of the worst channel, each beside the same channel of other joints in its run.

    In another gait or at another speed all joints may leave more; one that is wrong leaves more than the
    others. Only kinds count that every run measured at three joints. None if there is none, or one run.
    """
    known = np.isfinite(np.concatenate([trials.logs, runs.logs])).all(axis=0)
    many = np.array([sum(np.array(kinds)[known] == kind) >= FEWEST_JOINTS for kind in kinds])
    known &= many
    if not known.any() or len(runs.logs) < 2:
        return None
    own_kinds = [kind for kind, on in zip(kinds, known, strict=True) if on]
    beside, others = (_beside_joints(own_kinds, one.of(known).logs) for one in (trials, runs))
    centred = others - others.mean(axis=0)
    scatters = _scatters(own_kinds, centred, 1, steadied)
    variance = np.full(len(own_kinds), 1 / len(beside) + 1 / len(others))
    p, worst = _worst(beside.mean(axis=0) - others.mean(axis=0), variance, scatters)
    return EnergyChance(min(1.0, p), int(np.flatnonzero(known)[worst]))


def _beside_joints(kinds: Sequence[str], logs: FloatArray) -> FloatArray:
    """Logarithms of energies of R runs over the median of all joints with the same kind, (R, C)."""
    beside = logs.copy()
    for kind in set(kinds):
        own = [one == kind for one in kinds]
        beside[:, own] -= np.median(logs[:, own], axis=1, keepdims=True)
    return beside


def _worst(
    ahead: FloatArray, variance: FloatArray, scatters: Sequence[Scatter]
) -> tuple[float, int]:
    """Chance that any of K channels is as far ahead as the one that is farthest, (K,), and that one."""
    width = np.sqrt(variance * np.array([one.variance for one in scatters]))
    each = special.stdtr(np.array([one.free for one in scatters]), -ahead / width)
    worst = int(np.argmin(each))
    return float(each[worst]) * len(each), worst


def _mean_known(logs: FloatArray) -> FloatArray:
    """The mean of R rows, (R, C), of those that are known, (C,); NaN where none is."""
    known = np.isfinite(logs)
    count = known.sum(axis=0)
    total = np.where(known, logs, 0.0).sum(axis=0)
    return np.asarray(np.where(count > 0, total / np.fmax(count, 1), np.nan))


def _means(logs: FloatArray) -> FloatArray:
    """Mean of each run, of those that measured anything."""
    return np.asarray(np.nanmean(logs[np.isfinite(logs).any(axis=1)], axis=1))


def _scatters(
    kinds: Sequence[str], centred: FloatArray, means: int, steady: Steady
) -> list[Scatter]:
    """How much the logarithm of each channel's energy scatters between N runs about their means, (N, C).

    Forces of feet that stick differ between gaits and days by far more than markers do. So scatter is
    pooled over the joints at which the same is measured, and steadied by the other kinds only as far as
    these scatter alike. ``means`` is how many a channel has, and ``steady`` says how much others tell.
    """
    each = {
        kind: _pooled(centred[:, [one == kind for one in kinds]], means)
        for kind in sorted(set(kinds))
    }
    if len(each) > 1:
        variances = np.array([one.variance for one in each.values()])
        frees = np.array([one.free for one in each.values()])
        usual = scatter_of_all(variances, frees, np.ones(len(each)))
        each = {kind: steady(one, usual) for kind, one in each.items()}
    return [each[kind] for kind in kinds]


def _pooled(centred: FloatArray, means: int) -> Scatter:
    """Scatter of logarithms of energies of N runs about their means, (N, K), pooled over K channels.

    NaN is what a run did not measure.
    """
    channels = centred.shape[1]
    free = int(np.isfinite(centred).sum()) - means * channels
    variance = max(float(np.nansum(centred**2)) / free, CHANNEL_SCATTER**2)
    return Scatter(variance, free / channels * min(channels, float(CHANNELS_APART)))
