"""What probabilities of a diagnosis are made of, as rows for ``gap.check.calibration``.

"None of these" is logistic in what the causes leave, with the constants of ``gap.constants``.
The probability of a named cause is judged as it was given: as a logistic curve of its own log odds.
"""

import math
from collections.abc import Sequence

import numpy as np

from gap import constants
from gap.check.calibration import CaseRows, ConstantPrior
from gap.check.cases import (
    CONTROL,
    OUTSIDE,
    REMOVED,
    CheckedCase,
    gap_declared,
    probabilities_given,
)
from gap.diagnosis.alternatives.probability import Fit, none_features

SURE = 1e-3  # no nearer to 0 or 1 than this
LOOSE = 0.5  # share of a constant by which a fit may move it, one standard deviation


def none_prior() -> ConstantPrior:
    """Return the constants of "none of these" with references as they stand."""
    names = (
        "NONE", "NONE_OPEN", "NONE_ENERGY", "NONE_WORST", "NONE_MANY", "NONE_ACTING", "NONE_LEFT",
        "NONE_UNWATCHED",
    )  # fmt: skip
    values = np.array([float(getattr(constants, name)) for name in names])
    return ConstantPrior(names, values, LOOSE * np.abs(values), np.array([0.0, *[1.0] * 7]))


def none_rows(cases: Sequence[CheckedCase]) -> CaseRows:
    """Return a row a case with a gap and references: what its causes leave, and whether it is outside."""
    features, outcomes = [], []
    for case in cases:
        left = case.answer.remainder
        if (
            left is None
            or case.kind == CONTROL
            or not (case.answer.referenced and gap_declared(case))
        ):
            continue
        rest = (math.nan, left.acting, left.there, left.unwatched, left.rough)
        fit = Fit(left.closed, left.excess, left.worst, left.p, *rest)
        features.append(none_features(fit, len(case.answer.named)))
        outcomes.append(case.kind in {OUTSIDE, REMOVED})
    return CaseRows(np.array(features).reshape(-1, 8), np.array(outcomes, dtype=bool))


def cause_prior() -> ConstantPrior:
    """Return the curve that leaves a given probability as it is."""
    names = ("offset", "slope")
    return ConstantPrior(names, np.array([0.0, 1.0]), np.array([1.0, 0.5]), np.array([0.0, 1.0]))


def cause_rows(cases: Sequence[CheckedCase]) -> CaseRows:
    """Return a row a named cause: log odds of its probability, and whether it is one that was there."""
    given = probabilities_given(cases)
    odds = [min(max(chance, SURE), 1.0 - SURE) for chance, _ in given]
    features = [(1.0, math.log(one / (1.0 - one))) for one in odds]
    return CaseRows(
        np.array(features).reshape(-1, 2), np.array([right for _, right in given], dtype=bool)
    )
