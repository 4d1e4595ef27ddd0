"""What is counted over all known cases, and how it differs from the count with constants as they are."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gap.check.cases import (
    CONTROL,
    NO_GAP,
    OUTSIDE,
    PAIR,
    REMOVED,
    SINGLE,
    UNEXPLAINED,
    CheckedCase,
    gap_declared,
    named_effects,
    named_right,
    probabilities_given,
)
from gap.check.score import calibration_error, leg_right, numbers_within

SURE = 1e-3  # no nearer to 0 or 1 than this, for a log loss


@dataclass(frozen=True, slots=True, eq=False)
class JudgedCase:
    """A case with its answer.

    Attributes:
        found: The diagnosis as JSON, with ``fit``, ``gap``, ``causes`` and ``rivals``.
        visible_sizes: Sizes that were said to be visible in it, by effect and parameter.
    """

    checked: CheckedCase
    found: Mapping[str, Any]
    visible_sizes: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Counts:
    """Figures of all cases; counts, if nothing else is said.

    Attributes:
        right: Answers that are right: the cause first, both of a pair, no gap, or unexplained.
        first: Single causes that were named first, with their joint.
        pairs: Pairs of which both were named.
        healthy: Healthy machines without a gap.
        outside: Causes outside the catalogue called unexplained.
        listed_unexplained: Causes in it called unexplained.
        calibration_error: Of the probabilities of causes.
        log_loss: Their mean negative log likelihood [nats].
        within_one: Share of the numbers within one of their +-.
        within_two: The same of two.
    """

    right: int
    first: int
    pairs: int
    healthy: int
    outside: int
    listed_unexplained: int
    calibration_error: float
    log_loss: float
    within_one: float
    within_two: float


@dataclass(frozen=True, slots=True)
class Differences:
    """What differs from the answers with all constants as they are.

    Attributes:
        verdicts: Cases with another verdict.
        causes: Cases with other causes, or other joints of them.
        visible_sizes: Median ratio of the sizes that are said to be visible.
    """

    verdicts: int
    causes: int
    visible_sizes: float


def counts(judged: Sequence[JudgedCase]) -> Counts:
    """Count the cases."""
    cases = [one.checked for one in judged]
    single = [one for one in cases if one.kind == SINGLE]
    declared = [one for one in single if gap_declared(one)]
    given = np.array(probabilities_given(cases)).reshape(-1, 2)
    chance = np.clip(given[:, 0], SURE, 1.0 - SURE)
    loss = -np.log(np.where(given[:, 1] > 0, chance, 1.0 - chance))
    return Counts(
        right=sum(map(_right, cases)),
        first=sum(_right(one) for one in single),
        pairs=sum(_right(one) for one in cases if one.kind == PAIR),
        healthy=sum(_right(one) for one in cases if one.kind == CONTROL),
        outside=sum(_right(one) for one in cases if one.kind in {OUTSIDE, REMOVED}),
        listed_unexplained=sum(
            one.answer.verdict == UNEXPLAINED for one in cases if one.kind in {SINGLE, PAIR}
        ),
        calibration_error=calibration_error(cases).error,
        log_loss=float(loss.mean()),
        within_one=_share(numbers_within(declared, 1.0)),
        within_two=_share(numbers_within(declared, 2.0)),
    )


def _share(hits: Sequence[bool]) -> float:
    return float(np.mean(hits)) if hits else math.nan


def _right(case: CheckedCase) -> bool:
    if case.kind == CONTROL:
        return case.answer.verdict == NO_GAP
    if case.kind in {OUTSIDE, REMOVED}:
        return case.answer.verdict == UNEXPLAINED
    if case.kind == PAIR:
        return {truth.effect for truth in case.truths} <= set(named_effects(case))
    return gap_declared(case) and named_right(case) and leg_right(case)


def differences(judged: Sequence[JudgedCase], before: Sequence[JudgedCase]) -> Differences:
    """Compare answers to the same cases."""
    pairs = list(zip(judged, before, strict=True))
    ratios = [
        one.visible_sizes[name] / size
        for one, old in pairs
        for name, size in old.visible_sizes.items()
        if name in one.visible_sizes and 0.0 < size < np.inf
    ]
    return Differences(
        verdicts=sum(a.checked.answer.verdict != b.checked.answer.verdict for a, b in pairs),
        causes=sum(_causes(a) != _causes(b) for a, b in pairs),
        visible_sizes=float(np.median(ratios)) if ratios else 1.0,
    )


def _causes(case: JudgedCase) -> frozenset[tuple[str, tuple[str, ...]]]:
    return frozenset((one.effect, one.joints) for one in case.checked.answer.named)
