"""What differs in a healthy machine from day to day, as causes: beside these, a new cause is clearer.

Loads, friction and springs of a machine are a little different in every run, and each of them also looks
like something else: where the load lies changes which feet slide, as a drag would. So the size of a cause
that is fitted by itself scatters between runs by all that is like it. Here every change of every candidate
may be in a run, with a variance that the references show, and the size of a cause is that of generalised
least squares beside them: a mixed model (Searle, Casella and McCulloch 1992, Variance Components, chapter
7, doi:10.1002/9780470316856). The variances are found by expectation and maximisation (Tipping 2001, Sparse
Bayesian Learning), drawn towards one share of the parameters' spreads.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from gap.constants import DAY_MEAN, DAY_WORTH
from model.values.arrays import FloatArray

# Share of its spread by which a parameter differs from day to day: which is likeliest is precise enough.
SHARES = (0.01, 0.03, 0.06, 0.1, 0.2)
ROUNDS = 8


@dataclass(frozen=True, slots=True, eq=False)
class PulledRuns:
    """R runs, and K changes of the prediction to first order, each of one spread.

    Attributes:
        pulls: Products of the changes with what is measured, (R, K).
        parts: Of the trials, over which each run is laid.
        grams: Products of the changes with each other in a part, (K, K) each.
    """

    pulls: FloatArray
    parts: tuple[int, ...]
    grams: Mapping[int, FloatArray]

    def taken(self, runs: Sequence[int]) -> "PulledRuns":
        """Return some of them."""
        return PulledRuns(self.pulls[list(runs)], tuple(self.parts[i] for i in runs), self.grams)

    @property
    def each(self) -> list[tuple[int, FloatArray]]:
        """Part of each run and its pulls, (K,)."""
        return list(zip(self.parts, self.pulls, strict=True))


def likeliest_day_share(runs: PulledRuns) -> float:
    """Return by which share of its spread any parameter differs between runs, if all do alike."""
    nats = []
    for share in SHARES:
        mean, inverse, logdet = _mean(runs, np.full(runs.pulls.shape[1], share**2))
        total = -0.5 * float(mean @ mean) / DAY_MEAN**2
        for part, pull in runs.each:
            left = pull - runs.grams[part] @ mean
            total += 0.5 * share**2 * float(left @ inverse[part] @ left)
            total -= 0.5 * logdet[part]
        nats.append(total)
    return SHARES[int(np.argmax(nats))]


def day_variances(runs: PulledRuns, share: float) -> FloatArray:
    """Return the variance of each change between runs, about a mean that all of them have, (K,).

    Args:
        runs: Healthy runs.
        share: Of its spread, by which any parameter differs where runs do not show it.
    """
    count = len(runs.parts)
    variance = np.full(runs.pulls.shape[1], share**2)
    for _ in range(ROUNDS):
        mean, inverse, _ = _mean(runs, variance)
        square = np.zeros(len(variance))
        for part, pull in runs.each:
            size = variance * (inverse[part] @ (pull - runs.grams[part] @ mean))
            unsure = variance * np.diagonal(inverse[part])
            # the mean took one run's worth of freedom
            square += size**2 * count / max(count - 1, 1) + unsure
        variance = (DAY_WORTH * share**2 + square) / (DAY_WORTH + count)
    return variance


def _mean(
    runs: PulledRuns, variance: FloatArray
) -> tuple[FloatArray, dict[int, FloatArray], dict[int, float]]:
    """Size of each change that is common to runs, (K,); of each part (1 + gram variance)^-1, and ln det.

    The logarithm is that of the determinant of the matrix that is inverted.
    """
    one, deviation = np.eye(len(variance)), np.sqrt(variance)
    inverse, logdet = {}, {}
    for part in set(runs.parts):
        # symmetric with the deviations on both sides, so that Cholesky's factor inverts it
        inverse[part], logdet[part] = _inverse(
            one + deviation[:, None] * runs.grams[part] * deviation
        )
        inverse[part] = inverse[part] * (deviation / deviation[:, None])
    weight, pull = one / DAY_MEAN**2, np.zeros(len(variance))
    for part, own in runs.each:
        pull = pull + inverse[part] @ own
    for part, by in inverse.items():
        weight = weight + runs.parts.count(part) * (by @ runs.grams[part])
    return np.asarray(np.linalg.solve(weight, pull)), inverse, logdet


def _inverse(positive: FloatArray) -> tuple[FloatArray, float]:
    """Inverse of a positive definite matrix, and the logarithm of its determinant.

    Products in single precision may leave it a little indefinite; then it is inverted as any matrix is.
    """
    factor, failed = lapack.dpotrf(positive, lower=1)
    if failed:
        return np.asarray(np.linalg.inv(positive)), float(np.linalg.slogdet(positive)[1])
    half, _ = lapack.dpotri(factor, lower=1)
    lower = np.tril(half)
    logdet = 2.0 * float(np.log(np.diagonal(factor)).sum())
    return lower + np.tril(half, -1).T, logdet
