"""Diagnoses against ground truth: how often right, how well calibrated, how far the gap shrank.

Pure: takes what was wrong in each case and what the diagnosis named, and counts. Every share comes with
Wilson's interval (1927, JASA 22:209).
"""

import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binomtest, rankdata

from gap.check.calibration import CalibrationError, calibration_of
from gap.check.cases import (
    CONTROL,
    OUTSIDE,
    PAIR,
    REMOVED,
    SINGLE,
    UNEXPLAINED,
    CheckedCase,
    Truth,
    gap_declared,
    group_of,
    named_effects,
    named_right,
    probabilities_given,
    too_small,
)
from model.effects.catalogue import EFFECTS

VISIBLE = 3.0  # times repeatability
EITHER_SIGN = frozenset(name for name, one in EFFECTS.items() if one.even)


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure of the protocol.

    Attributes:
        value: Its value; NaN where there was no case.
        low: Lower end of the 95 % interval of a share; NaN for others.
        cases: How many cases it comes from.
        bar: The bar, in words.
        met: Whether it is met; None where there was no case.
        by_chance: Of a calibration error: what it would be of probabilities that are right, as there are so
            few; NaN for others.
        p: Chance of so large an error in that case; NaN for others.
    """

    name: str
    value: float
    low: float
    high: float
    cases: int
    bar: str
    met: bool | None
    by_chance: float = math.nan
    p: float = math.nan


@dataclass(frozen=True, slots=True)
class Confusion:
    """A case whose named effect was not the true one, and how visible it was over repeatability.

    ``too_small`` are its true effects that were missed and smaller than what the answer says it would have
    seen.
    """

    case: str
    truth: str
    said: str
    visible: float
    too_small: tuple[str, ...] = ()


def figures(
    cases: Sequence[CheckedCase], neutral: dict[tuple[str, str], float]
) -> tuple[Figure, ...]:
    """Return every figure of the protocol; ``neutral`` is by (effect, parameter)."""
    single = [c for c in cases if c.kind == SINGLE]
    visible = [c for c in single if not c.visible < VISIBLE]
    detected = [c for c in single if gap_declared(c)]
    legged = [c for c in detected if c.truths[0].joint and named_right(c)]
    controls = [c for c in cases if c.kind == CONTROL]
    open_set = [c for c in cases if c.kind in {OUTSIDE, REMOVED}]
    inside = [c for c in cases if c.kind in {SINGLE, PAIR} and gap_declared(c)]
    groups = [len(group_of(c)) for c in detected if c.answer.named]
    hits, truths, answers = count_pairs((c, named_effects(c)) for c in cases if c.kind == PAIR)
    seconds = [c.answer.seconds for c in cases if c.answer.seconds == c.answer.seconds]
    odd = [recognised_unlike(c) for c in open_set]
    auroc = area_under(
        [c.answer.none for c in open_set if gap_declared(c)], [c.answer.none for c in inside]
    )
    return (
        share(f"detection, visible at {VISIBLE:g}x repeatability or more",
            map(gap_declared, visible), 0.98),
        share("effect right, of detected", map(named_right, detected), 0.90),
        share(
            "effect right or in its declared group",
            (c.truths[0].effect in group_of(c) for c in detected), 0.97,
        ),
        number("mean size of a group", _mean(groups), len(groups), "<= 2", lambda v: v <= 2),
        share("leg right, of those with the right effect", (leg_right(c) for c in legged), 0.97),
        share("stage right, of detected", (stage_right(c) for c in detected), 0.97),
        share("controls called no_gap", (not gap_declared(c) for c in controls), 0.95),
        ratio("two effects: recall", hits, truths, 0.80),
        ratio("two effects: precision", hits, answers, 0.90),
        share("outside the catalogue: unexplained", odd, 0.80),
        share(
            "called unexplained, of the others", (c.answer.verdict == UNEXPLAINED for c in inside),
            0.03, at_most=True,
        ),
        number("AUROC of none of these", auroc, len(open_set), ">= 0.95", lambda v: v >= 0.95),
        calibration_figure("calibration error of probabilities", cases),
        number("median parameter error", *parameter_error(detected, neutral), "<= 10 %",
            lambda v: v <= 0.10),
        number("median shrink over what is reachable", *_shrinks(detected), ">= 95 %",
            lambda v: v >= 0.95),
        number("time of a case, median", _median(seconds), len(seconds), "<= 60 s",
            lambda v: v <= 60.0),
    )  # fmt: skip


def confusions(cases: Iterable[CheckedCase]) -> tuple[Confusion, ...]:
    """Return every case in which something else was named than was wrong, by what was wrong."""
    out = []
    for case in cases:
        true = sorted(t.effect for t in case.truths) if case.kind in {SINGLE, PAIR} else []
        named = sorted(set(named_effects(case)))
        odd = case.kind in {OUTSIDE, REMOVED}
        right = recognised_unlike(case) if odd else true == named
        if not right:
            words = " + ".join(named) or case.answer.verdict
            truth = " + ".join(sorted(t.effect for t in case.truths)) or "nothing"
            more = f" ({case.kind})" if odd else ""
            small = tuple(one for one in too_small(case) if one not in named)
            out.append(Confusion(case.name, truth + more, words, case.visible, small))
    return tuple(sorted(out, key=lambda c: (c.truth, c.case)))


def calibration_figure(name: str, cases: Sequence[CheckedCase]) -> Figure:
    """Return the calibration error of causes named, with what it would be of calibrated ones."""
    measured = calibration_error(cases)
    one = number(name, measured.error, measured.count, "<= 0.05", lambda v: v <= 0.05)
    return replace(one, by_chance=measured.by_chance, p=measured.p)


def calibration_error(cases: Sequence[CheckedCase]) -> CalibrationError:
    """Return the expected calibration error of causes named, in ten bins, and what it is by chance."""
    given = probabilities_given(cases)
    sure = np.array([probability for probability, _ in given])
    return calibration_of(sure, np.array([right for _, right in given], dtype=bool))


def parameter_error(
    cases: Iterable[CheckedCase], neutral: dict[tuple[str, str], float]
) -> tuple[float, int]:
    """Return the median relative error of parameters where effect and leg are right, and their number.

    An error counts relative to how far the truth is from neutral; of a vector (x, y) relative to the
    largest of its parts in the same unit, so that a part near zero does not decide.
    """
    errors = []
    for case in cases:
        if not first_right(case):
            continue
        truth, fitted = case.truths[0], dict(case.answer.named[0].values)
        away = {n: abs(v - neutral.get((truth.effect, n), 0.0)) for n, v in truth.values}
        for name, value in _signed(truth, fitted).values:
            scale = max(a for n, a in away.items() if _unit(n) == _unit(name))
            if name in fitted and scale > 0:
                errors.append(abs(fitted[name] - value) / scale)
    return _median(errors), len(errors)


def numbers_within(cases: Iterable[CheckedCase], times: float) -> tuple[bool, ...]:
    """Return whether each number is within so many of its +- of the truth, where effect and leg are right.

    Numbers without a +- do not count.
    """
    hits = []
    for case in cases:
        if not first_right(case):
            continue
        first = case.answer.named[0]
        fitted, errors = dict(first.values), dict(first.errors)
        for name, value in _signed(case.truths[0], fitted).values:
            if errors.get(name, 0.0) > 0.0:
                hits.append(abs(fitted[name] - value) <= times * errors[name])
    return tuple(hits)


def _signed(truth: Truth, fitted: Mapping[str, float]) -> Truth:
    """The truth with the sign of what was fitted, where both signs are the same effect."""
    same = sum(value * fitted.get(name, 0.0) for name, value in truth.values)
    if truth.effect not in EITHER_SIGN or same >= 0.0:
        return truth
    return replace(truth, values=tuple((name, -value) for name, value in truth.values))


def area_under(positive: Sequence[float], negative: Sequence[float]) -> float:
    """Return the area under the ROC curve of a score that should be higher for ``positive``."""
    if not positive or not negative:
        return math.nan
    ranks = rankdata([*positive, *negative])[: len(positive)]
    smallest = len(positive) * (len(positive) + 1) / 2
    return float((ranks.sum() - smallest) / (len(positive) * len(negative)))


def share(name: str, hits: Iterable[bool], bar: float, *, at_most: bool = False) -> Figure:
    """Return a share with Wilson's 95 % interval."""
    known = list(hits)
    return ratio(name, sum(known), len(known), bar, at_most=at_most)


def ratio(name: str, hits: int, cases: int, bar: float, *, at_most: bool = False) -> Figure:
    """Return so many hits of so many cases as a share with Wilson's 95 % interval."""
    words = f"{'<=' if at_most else '>='} {bar:.0%}"
    if cases == 0:
        return Figure(name, math.nan, math.nan, math.nan, 0, words, None)
    p = hits / cases
    interval = binomtest(hits, cases).proportion_ci(0.95, method="wilson")
    met = p <= bar if at_most else p >= bar
    return Figure(name, p, interval.low, interval.high, cases, words, met)


def number(name: str, value: float, cases: int, bar: str, met: Callable[[float], bool]) -> Figure:
    """Return a figure that is no share."""
    known = value == value
    return Figure(name, value, math.nan, math.nan, cases, bar, met(value) if known else None)


def first_right(case: CheckedCase) -> bool:
    """Whether the first cause that was named is the true one, at its leg."""
    return named_right(case) and leg_right(case)


def leg_right(case: CheckedCase) -> bool:
    """Whether the first cause named is at the true leg (of a single-effect case)."""
    joint = case.truths[0].joint
    return case.answer.named[0].joints == ((joint,) if joint else ())


def stage_right(case: CheckedCase) -> bool:
    """Whether the gap was said to lie in the true stage (of a single-effect case)."""
    return case.answer.stage == case.truths[0].stage


def recognised_unlike(case: CheckedCase) -> bool:
    """Whether a case outside the catalogue was recognised as one."""
    return case.answer.verdict == UNEXPLAINED


def count_pairs(answers: Iterable[tuple[CheckedCase, Sequence[str]]]) -> tuple[int, int, int]:
    """Count effects named that were there, effects that were there, and effects named."""
    hits = truths = count = 0
    for case, effects in answers:
        true, named = Counter(truth.effect for truth in case.truths), Counter(effects)
        hits += (true & named).total()
        truths += true.total()
        count += named.total()
    return hits, truths, count


def _shrinks(cases: Iterable[CheckedCase]) -> tuple[float, int]:
    known = [
        c.answer.shrink / c.reachable
        for c in cases
        if c.reachable > 0 and c.answer.shrink == c.answer.shrink
    ]
    return _median(known), len(known)


def _unit(name: str) -> str:
    """Return the unit's suffix: of ``x_m`` it is ``m``; of a name without one the name."""
    return name.split("_", 1)[1] if name.split("_", 1)[0] in {"x", "y", "z"} else name


def _mean(values: Sequence[float]) -> float:
    return statistics.fmean(values) if values else math.nan


def _median(values: Sequence[float]) -> float:
    return statistics.median(values) if values else math.nan
