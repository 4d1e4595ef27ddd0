"""Every candidate fitted to every healthy run, to first order: by itself, or beside what days differ in.

Each reference is laid over the trials as if it were one, and a candidate is fitted to it by its signature.
"""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gap.residuals.evidence import Evidence
from gap.residuals.healthy import WhitenedRun, laid_over
from gap.residuals.parts import TrialPart
from gap.residuals.same_day import days_of
from gap.search.days import PulledRuns
from gap.search.novelty import across_of
from gap.search.screen import Signature, Signatures
from gap.search.sizes import Sizes, sizes_of
from model.values.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class RunFits:
    """A candidate in R healthy runs: pull on its D directions, (R, D), and their energies, (R, D, D)."""

    signature: Signature
    gaits: tuple[str, ...]
    days: tuple[str, ...]
    pull: FloatArray
    gram: FloatArray

    def energy(self, direction: FloatArray) -> FloatArray:
        """Return the energy of a change in each run, one over the variance of its size by noise, (R,)."""
        if len(direction) == 1:
            return np.asarray(self.gram[:, 0, 0] * direction[0] ** 2)
        return np.asarray(np.einsum("d,rde,e->r", direction, self.gram, direction))

    def along(self, direction: FloatArray) -> Sizes:
        """Return the size of a change in each run that shows it; NaN in others."""
        return sizes_of(self.pull @ direction, self.energy(direction), self.gaits, self.days)


# Of a candidate, and of the same change at other joints.
FitsElsewhere = tuple[RunFits, tuple[RunFits, ...]]


def sizes_alike(
    fits: FitsElsewhere, direction: FloatArray, gram: FloatArray, runs: Sequence[int]
) -> list[Sizes]:
    """Return sizes in some runs of the same change at other joints, and of changes across it.

    ``gram`` are the energies, (D, D), by which these are orthogonal to it.
    """
    own, others = fits
    across = across_of(gram, direction) if len(direction) > 1 else ()
    return [
        *(one.along(direction).taken(runs) for one in others),
        *(own.along(one).taken(runs) for one in across),
    ]


@dataclass(frozen=True, slots=True, eq=False)
class LaidRuns:
    """R runs laid over the trials that are fitted to, or these, and the S rows of the signatures.

    Attributes:
        runs: Of all rows.
        linear: Rows of changes about the unchanged simulator, (K,).
        gaits: Of each run.
        residuals: Of the unchanged simulator, whitened, laid over its part, flat.
        days: Of each run; none where each has one of its own.
    """

    runs: PulledRuns
    linear: IntArray
    gaits: tuple[str, ...]
    residuals: tuple[NDArray[np.float32], ...]
    days: tuple[str, ...] = ()

    def changes(self, taken: Sequence[int]) -> PulledRuns:
        """Return some of the runs with the linear changes alone."""
        runs, rows = self.runs.taken(taken), self.linear
        grams = {part: gram[np.ix_(rows, rows)] for part, gram in runs.grams.items()}
        return PulledRuns(runs.pulls[:, rows], runs.parts, grams)

    def first(self, count: int) -> "LaidRuns":
        """Return the first of the runs."""
        runs = self.runs.taken(range(count))
        return LaidRuns(
            runs, self.linear, self.gaits[:count], self.residuals[:count], self.days[:count]
        )

    def with_trials(
        self, evidence: Evidence, signatures: Signatures, residual: FloatArray
    ) -> "LaidRuns":
        """Return them with the trials that are fitted to after them, of which something is left, (F, C)."""
        flat = residual.ravel().astype(np.float32)
        own = tuple(flat[cut] for cut in slices_of(evidence))
        return self._with(evidence, signatures, tuple(range(len(own))), own, evidence.parts)

    def with_others(
        self, evidence: Evidence, signatures: Signatures, others: Sequence[WhitenedRun]
    ) -> "LaidRuns":
        """Return them with other runs after them, each laid over the trial whose condition is nearest."""
        parts = tuple(_part_for(evidence, run) for run in others)
        laid = tuple(
            (laid_over(evidence.parts[part], run) * (evidence.whiteners[part].gain > 0))
            .ravel()
            .astype(np.float32)
            for part, run in zip(parts, others, strict=True)
        )
        return self._with(evidence, signatures, parts, laid, [run.part for run in others])

    def _with(
        self, evidence: Evidence, signatures: Signatures, parts: tuple[int, ...],
        residuals: tuple[NDArray[np.float32], ...], of: Sequence[TrialPart],
    ) -> "LaidRuns":  # fmt: skip
        """Return them with runs after them, each of which lies over a part."""
        cuts = slices_of(evidence)
        pulls = [
            signatures.matrix[:, cuts[part]] @ own
            for part, own in zip(parts, residuals, strict=True)
        ]
        runs = replace(
            self.runs,
            pulls=np.vstack([self.runs.pulls, *np.array(pulls, dtype=np.float64)]),
            parts=(*self.runs.parts, *parts),
        )
        residuals = (*self.residuals, *residuals)
        gaits = (*self.gaits, *(part.gait for part in of))
        return LaidRuns(runs, self.linear, gaits, residuals, (*self.days, *days_of(of)))


def lay(evidence: Evidence, signatures: Signatures, others: Sequence[WhitenedRun]) -> LaidRuns:
    """Lay other runs over the trials that are fitted to, each over the one whose condition is nearest."""
    grams = {}
    for part, cut in enumerate(slices_of(evidence)):
        rows = np.ascontiguousarray(signatures.matrix[:, cut])
        grams[part] = (rows @ rows.T).astype(np.float64)
    linear = sorted({row for one in signatures.each if one.offset < 0 for row in one.rows})
    nothing = PulledRuns(np.zeros((0, len(signatures.matrix))), (), grams)
    empty = LaidRuns(nothing, np.array(linear, dtype=np.int64), (), ())
    return empty.with_others(evidence, signatures, others)


def slices_of(evidence: Evidence) -> list[slice]:
    """Columns of the signatures' matrix that belong to each part."""
    edges = np.concatenate([[0], np.cumsum([part.frames for part in evidence.parts])])
    columns = evidence.base.shape[1]
    return [slice(a * columns, b * columns) for a, b in itertools.pairwise(edges)]


def fits_of(
    laid: LaidRuns, signatures: Signatures, variance: FloatArray | None = None
) -> tuple[FitsElsewhere, ...]:
    """Fit every candidate to every run.

    Args:
        laid: The runs.
        signatures: Of the candidates.
        variance: Of each linear change between runs, (K,), beside which candidates are fitted; a
            candidate's own changes are left out. None fits each by itself.
    """
    runs = laid.runs
    pulls, grams = runs.pulls, runs.grams
    own = np.zeros(pulls.shape[1])
    if variance is not None:
        own[laid.linear] = variance
        pulls, grams = _without(laid, variance)
    parts, of_run = np.unique(runs.parts, return_inverse=True)
    each_gram = np.array([grams[part] for part in parts.tolist()])
    made: dict[str, list[RunFits]] = {}
    for one in signatures.each:
        rows = list(one.rows) if one.offset < 0 else [one.offset]
        if not rows:
            continue
        gram = each_gram[of_run[:, None, None], np.array(rows)[:, None], np.array(rows)]
        pull = pulls[:, rows]
        if own[rows].any():
            # generalised least squares of a change are the same with and without it among the rest
            back = np.eye(len(rows)) - gram * own[rows]
            gram = np.linalg.solve(back, gram)
            gram = np.asarray(0.5 * (gram + np.swapaxes(gram, 1, 2)))
            pull = np.asarray(np.linalg.solve(back, pull[:, :, None])[:, :, 0])
        fit = RunFits(one, laid.gaits, laid.days, pull, gram)
        made.setdefault(one.candidate.effect.name, []).append(fit)
    return tuple(
        (one, tuple(other for other in group if _same_elsewhere(one, other)))
        for group in made.values()
        for one in group
    )


def taken_by_days(
    gram: FloatArray, rows: IntArray, variance: FloatArray, along: FloatArray
) -> FloatArray:
    """Return how much of K changes with these variances between runs a change is taken to be, (K, ...).

    Args:
        gram: Products of all changes with each other in a part, (S, S).
        rows: Of those that differ between runs, (K,).
        variance: Theirs, (K,).
        along: Their products with the change, (K, ...).
    """
    return np.asarray(np.linalg.solve(gram[np.ix_(rows, rows)] + np.diag(1.0 / variance), along))


def _without(laid: LaidRuns, variance: FloatArray) -> tuple[FloatArray, Mapping[int, FloatArray]]:
    """Pulls and grams of all rows with the linear changes taken out, as far as days have them."""
    runs, rows = laid.runs, laid.linear
    pulls, grams = runs.pulls.copy(), {}
    for part in set(runs.parts):
        gram = runs.grams[part]
        taken = taken_by_days(gram, rows, variance, gram[rows]).T
        grams[part] = gram - taken @ gram[rows]
        for run in (r for r, own in enumerate(runs.parts) if own == part):
            pulls[run] -= taken @ runs.pulls[run, rows]
    return pulls, grams


def _same_elsewhere(one: RunFits, other: RunFits) -> bool:
    """Whether another fit is of the same change at another joint."""
    a, b = one.signature, other.signature
    same = a.start == b.start and a.live == b.live and (a.offset < 0) == (b.offset < 0)
    return (
        same
        and bool(a.candidate.joints)
        and a.candidate.joints != b.candidate.joints
        and bool(b.candidate.joints)
    )


def _part_for(evidence: Evidence, run: WhitenedRun) -> int:
    """The part of the trials whose gait and frequency are nearest to a run's."""
    near = run.part.condition
    return min(
        range(len(evidence.parts)),
        key=lambda i: (
            evidence.parts[i].gait != near.gait,
            abs(evidence.parts[i].condition.log_ratio(near)),
        ),
    )
