"""The search on healthy runs: what it names there, to first order, is what a gap is compared with.

Each reference in turn is laid over the trials as if it were one. Every candidate is fitted to it by its
signature, and the other references judge it as they judge a cause in the trials
(``gap.search.novelty``). The best candidate's chance, one a reference, shows what a chance from the same
search is worth; the scatter of the fits is what a cause must stand out from to be named.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap.constants import OPEN_LEVEL, SHOWN
from gap.residuals.chances import HeldOutChances, clearer
from gap.residuals.evidence import Evidence
from gap.residuals.floor import ENOUGH_REFERENCES
from gap.residuals.healthy import Healthy, WhitenedRun, farthest, nearest
from gap.residuals.same_day import EachDayOut, leave_each_day_out
from gap.search.candidates import Family, shares_of
from gap.search.clear_size import clear_size
from gap.search.days import day_variances, likeliest_day_share
from gap.search.novelty import chance_of
from gap.search.run_fits import FitsElsewhere, LaidRuns, RunFits, fits_of, lay, sizes_alike
from gap.search.scatter import Usual, UsualScatter, usual_scatter
from gap.search.screen import Signature, Signatures
from gap.search.sizes import Sizes, likeliest_share, scatter_in_gaits, scatters_of
from model.values.arrays import FloatArray

FEWEST_FREE = 2  # degrees of freedom of a change's scatter, from which it counts


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One way to compare candidates with healthy runs: each by itself, or beside what days differ in.

    Attributes:
        fits: Of every candidate in every run.
        usual: How much candidates scatter between runs.
    """

    fits: tuple[FitsElsewhere, ...]
    usual: UsualScatter


@dataclass(frozen=True, eq=False)
class HealthySearch:
    """What the search finds in healthy runs.

    Attributes:
        shares: Of a level, by cause (all its forms as one): they sum to 1.
        chances: Of the best in each reference that is matched, among all candidates.
        alone: Candidates each by itself.
        beside: And beside what days differ in.
        days: Variance of each linear change between references, (K,).
        signatures: Of the candidates.
        references: Which of the runs are references; the trials come after them.
        with_trials: References laid over the trials that are fitted to, and these.
    """

    shares: Mapping[Family, float]
    chances: HeldOutChances
    alone: View
    beside: View
    days: FloatArray
    signatures: Signatures
    references: range
    with_trials: LaidRuns

    @property
    def trials(self) -> range:
        """Which of the runs are trials."""
        return range(len(self.references), len(self.with_trials.gaits))

    def among_all(self, chance: float, family: Family) -> float:
        """Return what the chance of one cause is worth, as the best of all that were tried.

        One that showed nothing when they were gets the smallest share.
        """
        share = self.shares.get(family, min(self.shares.values(), default=1.0))
        return self.chances.calibrated(min(1.0, chance / share))

    def left_in_trials(
        self, evidence: Evidence, residual: FloatArray, held: Sequence[WhitenedRun]
    ) -> LaidRuns:
        """Return the references, and the trials with what causes leave of them, (F, C)."""
        laid = self.with_trials.first(len(self.references))
        laid = laid.with_trials(evidence, self.signatures, residual)
        return laid.with_others(evidence, self.signatures, held)

    def visible_sizes(self, level: float, laid: LaidRuns) -> Iterator[tuple[Signature, int, float]]:
        """Return each signature with a place in it and how many spreads of its parameter would be named.

        Of an effect that is differenced away from neutral it is how many times the change that it makes
        where it begins.

        Args:
            level: Chance at which a cause is named.
            laid: The references, after them the trials, those that are held out last.
        """
        by_one_of_two = 0.5 * self.chances.needed(level)
        views = zip(
            fits_of(laid, self.signatures), fits_of(laid, self.signatures, self.days), strict=True
        )
        every = range(len(self.references), len(laid.gaits))
        for alone, beside in views:
            signature = alone[0].signature
            if (signature.offset >= 0) is not signature.candidate.effect.away:
                continue
            needed = by_one_of_two * self.shares[signature.candidate.family]
            for place, direction in enumerate(np.eye(alone[0].pull.shape[1])):
                by_itself, hinted = (
                    self._visible(alone, self.alone.usual, direction, chance, every)
                    for chance in (needed, float(OPEN_LEVEL))
                )
                beside_days = self._visible(
                    beside, self.beside.usual, direction, needed, self.trials
                )
                yield signature, place, min(by_itself, max(beside_days, hinted))

    def _visible(
        self, fits: FitsElsewhere, usual: UsualScatter, direction: FloatArray, needed: float,
        trials: range,
    ) -> float:  # fmt: skip
        """How many spreads of a parameter have a chance in healthy machines, as a rule."""
        own = fits[0]
        sizes, effect = own.along(direction), own.signature.candidate.effect
        seen, known = sizes.taken(trials), sizes.taken(self.references)
        gram = own.gram[list(trials)].sum(axis=0)
        alike = sizes_alike(fits, direction, gram, self.references)
        scatter, level = in_sizes(usual, own, direction), needed / own.signature.candidate.forms
        parameters = len(effect.parameters)
        return clear_size(seen, known, alike, parameters, scatter, level, float(SHOWN))


def search_healthy(
    evidence: Evidence, signatures: Signatures, references: Sequence[Healthy]
) -> HealthySearch:
    """Run the search on healthy runs.

    Args:
        evidence: The trials that are fitted to.
        signatures: Of every candidate in these.
        references: Each in units of what the others predict.
    """
    laid = lay(evidence, signatures, references)
    with_trials = laid.with_trials(evidence, signatures, evidence.base)
    every = range(len(references))
    trials = range(len(references), len(with_trials.gaits))
    each_day = leave_each_day_out(laid.days, len(references))
    # two runs hardly tell how much causes scatter and not at all how much gaits differ; trials scatter, too
    also = (trials,) if len(each_day) < ENOUGH_REFERENCES else ()
    alone, share = fits_of(with_trials, signatures), likeliest_day_share(laid.changes(every))
    changes = _sizes_of(alone)
    chances = []
    matched = _matched(evidence, references, each_day)
    shares = shares_of([own.signature.candidate.family for own, _ in alone])
    for own_day, others in each_day:
        if not matched.issuperset(own_day):
            continue
        usual = _usual(changes, (others, *also))
        beside, _ = _beside(with_trials if also else laid, signatures, others, share, also)
        both = zip(alone, beside.fits, strict=True)
        each = [
            clearer(
                chance_of_fits(fits, own_day, others, usual),
                chance_of_fits(fits_beside, own_day, others, beside.usual),
            )
            for fits, fits_beside in both
        ]
        of_all = (
            p / shares[own.signature.candidate.family]
            for p, (own, _) in zip(each, alone, strict=True)
        )
        chances.append(min(1.0, min(of_all, default=1.0)))
    beside, days = _beside(with_trials, signatures, every, share, also)
    return HealthySearch(
        shares,
        HeldOutChances(tuple(chances)),
        View(alone, _usual(changes, (every, *also))),
        beside,
        days,
        signatures,
        every,
        with_trials,
    )


def _matched(evidence: Evidence, references: Sequence[Healthy], each_day: EachDayOut) -> set[int]:
    """References that are as near to the others, in gait and frequency, as trials are to references.

    One that is farther shows what a condition that is new looks like, and not what a chance is worth.
    """
    known = [run.part.condition for run in references]
    most = farthest([part.condition for part in evidence.parts], known)
    return {
        held
        for own_day, others in each_day
        for held in own_day
        if others and nearest(known[held], [known[i] for i in others]) <= most
    }


def _beside(
    laid: LaidRuns,
    signatures: Signatures,
    healthy: Sequence[int],
    share: float,
    also: Sequence[Sequence[int]],
) -> tuple[View, FloatArray]:
    """Candidates beside what healthy runs differ in, and the variance of each change, (K,).

    ``also`` are groups of other runs that tell how much candidates scatter.
    """
    days = day_variances(laid.changes(healthy), share)
    fits = fits_of(laid, signatures, days)
    return View(fits, _usual(_sizes_of(fits), (healthy, *also))), days


@dataclass(frozen=True, slots=True, eq=False)
class _Sizes:
    """Sizes of one change in R runs, NaN where it does not show, and its energies, (R,).

    ``weight`` is one over the number of changes that its cause has in all its forms.
    """

    at_a_joint: bool
    weight: float
    size: Sizes
    energy: FloatArray

    def mean_energy(self, runs: Sequence[int]) -> float:
        """Of those of some runs that show it."""
        energy = self.energy[list(runs)]
        return float(energy[np.isfinite(self.size.values[list(runs)])].mean())


def _sizes_of(fits: Sequence[FitsElsewhere]) -> list[_Sizes]:
    forms = Counter(own.signature.candidate.family for own, _ in fits)
    return [
        _Sizes(
            bool(own.signature.candidate.joints),
            1.0 / (len(own.signature.rows) * forms[own.signature.candidate.family]),
            own.along(direction),
            own.energy(direction),
        )
        for own, _ in fits
        if own.signature.offset < 0
        for direction in np.eye(len(own.signature.rows))
    ]


def _usual(changes: Sequence[_Sizes], groups: Sequence[Sequence[int]]) -> UsualScatter:
    """How much causes scatter between runs of a group; those of the machine, and those at a joint."""
    return UsualScatter(*(_usual_of_kind(changes, groups, kind) for kind in (False, True)))


def _usual_of_kind(
    changes: Sequence[_Sizes], groups: Sequence[Sequence[int]], at_a_joint: bool
) -> Usual:
    runs = [run for group in groups for run in group]
    kind = [
        (one, [one.size.taken(group) for group in groups])
        for one in changes
        if one.at_a_joint == at_a_joint
    ]
    shown = [(one, sizes) for one, sizes in kind if _free(sizes) >= FEWEST_FREE]
    weights = np.array([one.weight for one, _ in shown])
    differ = likeliest_share([sizes for _, sizes in shown], weights)
    energies = np.array([one.mean_energy(runs) for one, _ in shown])
    frees = np.array([_free(sizes) for _, sizes in shown], dtype=float)
    variances = scatters_of([sizes for _, sizes in shown], differ) / frees * energies
    together = usual_scatter(variances, frees, weights, differ)
    in_gaits = [scatter_in_gaits(sizes) for _, sizes in shown]
    with_scatter = np.array([free > 0 for _, free in in_gaits], dtype=bool)
    squares, frees = np.array(in_gaits).reshape(-1, 2)[with_scatter].T
    one_gait = usual_scatter(squares / frees * energies[with_scatter], frees, weights[with_scatter])
    return Usual(together, one_gait)


def _free(groups: Sequence[Sizes]) -> int:
    """Degrees of freedom of the scatter about the means of groups of runs."""
    return sum(len(one) - 1 for one in groups if len(one))


def in_sizes(usual: UsualScatter, own: RunFits, direction: FloatArray) -> Usual:
    """Return the usual scatter in units of the size of one change."""
    energy = max(float(own.energy(direction).mean()), 1e-30)
    return usual.of(bool(own.signature.candidate.joints)).times(1.0 / energy)


def chance_of_fits(
    fits: FitsElsewhere, held: Sequence[int], others: Sequence[int], usual: UsualScatter
) -> float:
    """Return the chance of what some runs show of a candidate, by other runs that are healthy."""
    own, _ = fits
    gram = own.gram[list(held)].sum(axis=0)
    size = len(gram)
    ridge = 1e-9 * max(float(np.trace(gram)), 1e-30)
    direction = np.linalg.solve(gram + ridge * np.eye(size), own.pull[list(held)].sum(axis=0))
    sizes = own.along(direction)
    seen = sizes.taken(held)
    if not len(seen):
        return 1.0
    known = sizes.taken(others)
    alike = sizes_alike(fits, direction, gram, others)
    parameters = len(own.signature.candidate.effect.parameters)
    expected = in_sizes(usual, own, direction)
    one = chance_of(seen, known, alike, parameters, expected)
    return min(1.0, own.signature.candidate.forms * one)
