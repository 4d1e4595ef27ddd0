"""Sizes of a cause in runs of several gaits: their means, and what they scatter about them.

Where the simulator is wrong in another way in another gait, the size of a cause changes with the gait, in
references as in trials. So a run is compared most with runs of its own gait, as far as gaits differ: the
gait is a random effect, and means and scatter are those of generalised least squares (Searle, Casella and
McCulloch 1992, Variance Components, chapter 6, doi:10.1002/9780470316856).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gap.residuals.same_day import several, together_on_days
from model.values.arrays import FloatArray

# Variance between gaits over that between runs of one gait: which of these is likeliest is precise enough.
SHARES = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
SAME_LIKELIHOOD = 1e-6  # nats
SEEN = 1e-3  # share of energy below which a change does not show


@dataclass(frozen=True, slots=True, eq=False)
class Sizes:
    """Size of a cause in each of N runs.

    Attributes:
        values: (N,).
        gaits: Of each run.
        days: On which each was recorded; none where each has a day of its own.
        energy: One over the variance by noise, (N,); None where it is not known.
    """

    values: FloatArray
    gaits: tuple[str, ...]
    days: tuple[str, ...] = ()
    energy: FloatArray | None = None

    def __len__(self) -> int:
        return len(self.gaits)

    def by_gait(self) -> dict[str, "Sizes"]:
        """Return those of each gait."""
        names = np.array(self.gaits)
        return {
            gait: Sizes(self.values[names == gait], (gait,) * int((names == gait).sum()))
            for gait in dict.fromkeys(self.gaits)
        }

    def taken(self, runs: Sequence[int]) -> "Sizes":
        """Return those of some runs, without those that do not show it (NaN), a day as one run.

        What differs from day to day is alike in all runs of a day, so these say it once.
        """
        if self.days and self.energy is not None:
            return self._by_day(together_on_days(self.days, tuple(runs)), self.energy)
        values = self.values[list(runs)]
        seen = np.isfinite(values)
        if seen.all():
            return Sizes(values, _gaits_of(self.gaits, tuple(runs)))
        kept = tuple(run for run, shown in zip(runs, seen, strict=True) if shown)
        return Sizes(values[seen], _gaits_of(self.gaits, kept))

    def _by_day(self, days: Sequence[Sequence[int]], energy: FloatArray) -> "Sizes":
        weights = np.where(np.isfinite(self.values), energy, 0.0)
        pulls = weights * np.nan_to_num(self.values)
        values, gaits = [], []
        for own in (list(day) for day in days):
            if (known := float(weights[own].sum())) > 0.0:
                values.append(float(pulls[own].sum()) / known)
                gaits.append(several(self.gaits[i] for i in own if weights[i] > 0.0))
        return Sizes(np.array(values), tuple(gaits))


def sizes_of(
    pull: FloatArray, energy: FloatArray, gaits: tuple[str, ...], days: tuple[str, ...] = ()
) -> Sizes:
    """Return the size of a change in each run that shows it, by pull and energy, (R,); NaN in others."""
    seen = energy > SEEN * max(float(energy.max()), 1e-30)
    return Sizes(np.where(seen, pull / np.where(seen, energy, 1.0), np.nan), gaits, days, energy)


@lru_cache(maxsize=1024)
def _gaits_of(gaits: tuple[str, ...], runs: tuple[int, ...]) -> tuple[str, ...]:
    return tuple(gaits[run] for run in runs)


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """How the means of G groups of N runs together, and the scatter about them, follow from sizes.

    Attributes:
        means: Weights of each mean, (G, N).
        covariance: Of the means, in units of the variance of one run, (G, G).
        square: Quadratic form of the scatter, (N, N): ``free`` times the variance of a run is expected.
        free: Degrees of freedom of the scatter.
        logdet: Of the covariance of what is left without the means, for a likelihood.
    """

    means: FloatArray
    covariance: FloatArray
    square: FloatArray
    free: int
    logdet: float


@lru_cache(maxsize=1024)
def design(groups: tuple[tuple[str, ...], ...], gaits_differ: float) -> Design:
    """Return it for groups of runs of these gaits, none of them empty.

    Args:
        groups: Gait of each run, by group; a gait changes the sizes of all groups alike.
        gaits_differ: Variance between gaits over that between runs of one gait.
    """
    names = np.array([gait for group in groups for gait in group])
    of = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
    member = (of[:, None] == np.arange(len(groups))).astype(float)
    covariance = np.eye(len(names)) + gaits_differ * (names[:, None] == names)
    inverse = np.linalg.inv(covariance)
    of_means = np.linalg.inv(member.T @ inverse @ member)
    means = of_means @ member.T @ inverse
    square = inverse - inverse @ member @ means
    logdet = float(np.linalg.slogdet(covariance)[1] - np.linalg.slogdet(of_means)[1])
    return Design(means, of_means, square, len(names) - len(groups), logdet)


def scatter_of(groups: Sequence[Sizes], gaits_differ: float) -> tuple[float, int]:
    """Return the squares of sizes about the means of their groups, summed, and the degrees of freedom."""
    there = [one for one in groups if len(one)]
    if not there:
        return 0.0, 0
    values = np.concatenate([one.values for one in there])
    one = design(tuple(group.gaits for group in there), gaits_differ)
    return max(float(values @ one.square @ values), 0.0), one.free


def scatters_of(each: Sequence[Sequence[Sizes]], gaits_differ: float) -> FloatArray:
    """Return the squares of sizes about the means of their groups, summed, of each of K sets, (K,)."""
    squares = np.zeros(len(each))
    for numbers, gaits, values in _by_gaits(each):
        squares[numbers] = _squares(values, design(gaits, gaits_differ))
    return squares


def scatter_in_gaits(groups: Sequence[Sizes]) -> tuple[float, int]:
    """Return the squares of sizes about the means of groups and gaits, summed, and degrees of freedom."""
    return scatter_of([one for group in groups for one in group.by_gait().values()], 0.0)


def _squares(values: FloatArray, one: Design) -> FloatArray:
    """Squares about the means of each of K sets of N runs of the same gaits, (K, N), summed, (K,)."""
    return np.asarray(np.maximum(np.einsum("kn,nm,km->k", values, one.square, values), 0.0))


def _by_gaits(
    each: Sequence[Sequence[Sizes]],
) -> list[tuple[list[int], tuple[tuple[str, ...], ...], FloatArray]]:
    """Sets with the same gaits by group: numbers, gaits, sizes, (K, N); a group without runs is none."""
    alike: dict[tuple[tuple[str, ...], ...], list[int]] = {}
    for number, groups in enumerate(each):
        if gaits := tuple(one.gaits for one in groups if len(one)):
            alike.setdefault(gaits, []).append(number)
    return [
        (numbers, gaits, np.array([np.concatenate([g.values for g in each[n]]) for n in numbers]))
        for gaits, numbers in alike.items()
    ]


def ahead_of(seen: Sizes, known: Sizes, gaits_differ: float) -> tuple[float, float]:
    """Return by how much sizes are ahead of those that are known, and its variance in units of a run's.

    0 is known where there are none.
    """
    if not len(known):
        alone = design((seen.gaits,), gaits_differ)
        return float(alone.means[0] @ seen.values), 1.0 + float(alone.covariance[0, 0])
    both = design((seen.gaits, known.gaits), gaits_differ)
    values = np.concatenate([seen.values, known.values])
    turn = np.array([1.0, -1.0])
    return float(turn @ both.means @ values), float(turn @ both.covariance @ turn)


def likeliest_share(changes: Sequence[Sequence[Sizes]], weights: FloatArray) -> float:
    """Return the variance between gaits, over that between runs of one gait, that is likeliest.

    By the restricted likelihood of all changes together, each with a variance of its own. Runs of one gait
    do not show it; 0 then.

    Args:
        changes: Sizes of K changes in groups of runs, more runs than groups each.
        weights: Of each, (K,).
    """
    nats = np.zeros(len(SHARES))
    for own, gaits, values in _by_gaits(changes):
        weight = weights[own]
        for number, share in enumerate(SHARES):
            one = design(gaits, share)
            square = _squares(values, one)
            logs = np.log(square, out=np.zeros(len(own)), where=square > 0.0)
            nats[number] -= 0.5 * weight[square > 0.0].sum() * one.logdet
            nats[number] -= 0.5 * one.free * float(weight @ logs)
    return SHARES[int(np.argmax(nats > nats.max() - SAME_LIKELIHOOD))]
