"""The search on healthy runs: what it names there, to first order, is what a gap is compared with.

Each reference in turn is laid over the trials as if it were one. Every candidate is fitted to it by its
signature, and the other references judge it as they judge a cause in the trials
(``gap.search.novelty``). The best candidate's chance, one a reference, shows what a chance from the same
search is worth; the scatter of the fits is what a cause must stand out from to be named.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from gap.constants import SHOWN
from gap.residuals.chances import HeldOutChances, leave_each_out
from gap.residuals.evidence import Evidence
from gap.residuals.healthy import Healthy, laid_over
from gap.search.novelty import SEEN, across_of, chance_of
from gap.search.scatter import Scatter, UsualScatter, pooled, usual_scatter, variance_of
from gap.search.screen import Signature, Signatures
from gap.search.sizes import Sizes, ahead_of, likeliest_share
from model.values.arrays import FloatArray

FEWEST_SEEN = 3  # runs that show a change, from which its scatter counts


@dataclass(frozen=True, slots=True, eq=False)
class _Fits:
    """A candidate in R healthy runs: pull on its D directions, (R, D), and their energies, (R, D, D)."""

    signature: Signature
    gaits: tuple[str, ...]
    pull: FloatArray
    gram: FloatArray

    def energy(self, direction: FloatArray) -> FloatArray:
        """Return the energy of a change in each run, one over the variance of its size by noise, (R,)."""
        return np.asarray(np.einsum("d,rde,e->r", direction, self.gram, direction))

    def along(self, direction: FloatArray) -> Sizes:
        """Return the size of a change in each run that shows it; NaN in others."""
        energy = self.energy(direction)
        seen = energy > SEEN * max(float(energy.max()), 1e-30)
        size = self.pull @ direction / np.where(seen, energy, 1.0)
        return Sizes(np.where(seen, size, np.nan), self.gaits)


@dataclass(frozen=True, eq=False)
class HealthySearch:
    """What the search finds in healthy runs.

    Attributes:
        candidates: How many were tried, all forms of a cause as one.
        chances: Of the best in each reference, among all candidates.
        usual: How much candidates scatter between references.
    """

    candidates: int
    chances: HeldOutChances
    usual: UsualScatter
    _fits: tuple[tuple[_Fits, tuple[_Fits, ...]], ...]

    def among_all(self, chance: float) -> float:
        """Return what the chance of one candidate is worth, as the best of all that were tried."""
        return self.chances.calibrated(min(1.0, self.candidates * chance))

    def visible_sizes(
        self, level: float, trials: Sequence[str]
    ) -> Iterator[tuple[Signature, int, float]]:
        """Return each signature with a place in it and how many spreads of its parameter would be named.

        Args:
            level: Chance at which a cause is named.
            trials: Gaits of the trials that there are to fit to.
        """
        needed = self.chances.needed(level) / self.candidates
        seen = Sizes(np.zeros(len(trials)), tuple(trials))
        for own, others in self._fits:
            if own.signature.offset >= 0:
                continue
            for place, direction in enumerate(np.eye(len(own.signature.rows))):
                runs = range(len(own.gaits))
                known = own.along(direction).taken(runs)
                elsewhere = [other.along(direction).taken(runs) for other in others]
                usual = _in_sizes(self.usual, own, direction)
                one = pooled([known], elsewhere, usual)
                if not len(known) or one.free <= 0:
                    yield own.signature, place, np.inf
                    continue
                own_level = needed / own.signature.candidate.forms
                beyond = float(np.sqrt(special.fdtri(1, one.free, 1.0 - own_level)))
                error = np.sqrt(one.variance * ahead_of(seen, known, usual.gaits_differ)[1])
                yield (
                    own.signature,
                    place,
                    error * (beyond + float(special.stdtrit(one.free, float(SHOWN)))),
                )


def search_healthy(
    evidence: Evidence, signatures: Signatures, runs: Sequence[Healthy]
) -> HealthySearch:
    """Run the search on healthy runs.

    Args:
        evidence: The trials that are fitted to.
        signatures: Of every candidate in these.
        runs: References, each in units of what the others predict.
    """
    fits = _fits_of(evidence, signatures, runs)
    count = len({one.signature.candidate.family for one, _ in fits})
    changes, chances = _sizes_of(fits), []
    for held, others in leave_each_out(len(runs)):
        usual = _usual(changes, list(others))
        best = min((_chance(own, rest, held, others, usual) for own, rest in fits), default=1.0)
        chances.append(min(1.0, count * best))
    usual = _usual(changes, list(range(len(runs))))
    return HealthySearch(max(count, 1), HeldOutChances(tuple(chances)), usual, fits)


@dataclass(frozen=True, slots=True, eq=False)
class _Sizes:
    """Sizes of one change in R healthy runs, NaN where it does not show, and its energies, (R,).

    ``weight`` is one over the number of changes that its cause has in all its forms.
    """

    at_a_joint: bool
    weight: float
    size: Sizes
    energy: FloatArray

    def mean_energy(self, runs: Sequence[int]) -> float:
        """Of those of some runs that show it."""
        energy = self.energy[runs]
        return float(energy[np.isfinite(self.size.values[runs])].mean())


def _sizes_of(fits: Sequence[tuple[_Fits, tuple[_Fits, ...]]]) -> list[_Sizes]:
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


def _usual(changes: Sequence[_Sizes], runs: Sequence[int]) -> UsualScatter:
    """How much causes scatter between some of the runs; those of the machine, and those at a joint."""
    return UsualScatter(*(_usual_of_kind(changes, runs, kind) for kind in (False, True)))


def _usual_of_kind(changes: Sequence[_Sizes], runs: Sequence[int], at_a_joint: bool) -> Scatter:
    kind = [(one, one.size.taken(runs)) for one in changes if one.at_a_joint == at_a_joint]
    shown = [(one, sizes) for one, sizes in kind if len(sizes) >= FEWEST_SEEN]
    weights = np.array([one.weight for one, _ in shown])
    differ = likeliest_share([sizes for _, sizes in shown], weights)
    variances = [variance_of(sizes, differ) * one.mean_energy(runs) for one, sizes in shown]
    frees = np.array([len(sizes) - 1.0 for _, sizes in shown])
    return usual_scatter(np.array(variances), frees, weights, differ)


def _in_sizes(usual: UsualScatter, own: _Fits, direction: FloatArray) -> Scatter:
    """The usual scatter in units of the size of one change."""
    energy = max(float(own.energy(direction).mean()), 1e-30)
    return usual.of(bool(own.signature.candidate.joints)).times(1.0 / energy)


def _chance(
    own: _Fits, rest: Sequence[_Fits], held: int, others: Sequence[int], usual: UsualScatter
) -> float:
    """Chance of what one reference shows of a candidate, by the other references."""
    gram = own.gram[held]
    size = len(gram)
    ridge = 1e-9 * max(float(np.trace(gram)), 1e-30)
    direction = np.linalg.solve(gram + ridge * np.eye(size), own.pull[held])
    sizes = own.along(direction)
    seen = sizes.taken([held])
    if not len(seen):
        return 1.0
    known = sizes.taken(others)
    elsewhere = [one.along(direction).taken(others) for one in rest]
    if size > 1:
        across = across_of(own.gram[held], direction)
        elsewhere += [own.along(other).taken(others) for other in across]
    parameters = len(own.signature.candidate.effect.parameters)
    expected = _in_sizes(usual, own, direction)
    one = chance_of(seen, known, elsewhere, parameters, expected)
    return min(1.0, own.signature.candidate.forms * one)


def _fits_of(
    evidence: Evidence, signatures: Signatures, runs: Sequence[Healthy]
) -> tuple[tuple[_Fits, tuple[_Fits, ...]], ...]:
    """Fit every candidate to every run, each beside the same effect at its other joints."""
    parts = [_part_for(evidence, run) for run in runs]
    edges = np.concatenate([[0], np.cumsum([part.frames for part in evidence.parts])])
    columns = evidence.base.shape[1]
    slices = [slice(edges[p] * columns, edges[p + 1] * columns) for p in range(len(evidence.parts))]
    pulls = np.empty((len(signatures.matrix), len(runs)))
    for r, (part, run) in enumerate(zip(parts, runs, strict=True)):
        laid = laid_over(evidence.parts[part], run) * (evidence.whiteners[part].gain > 0)
        pulls[:, r] = signatures.matrix[:, slices[part]] @ laid.ravel().astype(np.float32)
    gaits = tuple(run.part.gait for run in runs)
    made: dict[str, list[_Fits]] = {}
    for one in signatures.each:
        rows = list(one.rows) if one.offset < 0 else [one.offset]
        if not rows:
            continue
        grams = {}
        for part in set(parts):
            cut = signatures.matrix[rows, slices[part]].astype(np.float64)
            grams[part] = cut @ cut.T
        fit = _Fits(one, gaits, pulls[rows].T, np.array([grams[part] for part in parts]))
        made.setdefault(one.candidate.effect.name, []).append(fit)
    return tuple(
        (one, tuple(other for other in group if _same_elsewhere(one, other)))
        for group in made.values()
        for one in group
    )


def _same_elsewhere(one: _Fits, other: _Fits) -> bool:
    """Whether another fit is of the same change at another joint."""
    a, b = one.signature, other.signature
    same = a.start == b.start and a.live == b.live and (a.offset < 0) == (b.offset < 0)
    return (
        same
        and bool(a.candidate.joints)
        and a.candidate.joints != b.candidate.joints
        and bool(b.candidate.joints)
    )


def _part_for(evidence: Evidence, run: Healthy) -> int:
    """The part of the trials whose gait and frequency are nearest to a run's."""
    near = run.part.condition
    return min(
        range(len(evidence.parts)),
        key=lambda i: (
            evidence.parts[i].gait != near.gait,
            abs(evidence.parts[i].condition.log_ratio(near)),
        ),
    )
