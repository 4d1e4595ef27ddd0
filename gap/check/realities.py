"""How often a diagnosis is right on each of several realities, and on which it is worst.

Pure: takes the checked cases of each reality. A mean over realities would hide the one that counts.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from gap.check.cases import (
    CONTROL,
    OUTSIDE,
    PAIR,
    REMOVED,
    SINGLE,
    UNEXPLAINED,
    CheckedCase,
    gap_declared,
    group_of,
    is_true,
    named_effects,
    named_right,
    too_small,
)
from gap.check.score import (
    Figure,
    area_under,
    calibration_figure,
    first_right,
    leg_right,
    number,
    numbers_within,
    ratio,
    recognised_unlike,
    share,
    stage_right,
)

FIRST = "first cause right, with leg"
LARGE_ENOUGH = "of those large enough to be seen"
BOTH = "both causes of a pair"
BOTH_LARGE_ENOUGH = "of pairs that are both large enough to be seen"
AMONG = "true cause among the named"
HEALTHY_ALONE = "healthy: nothing but the baseline"
WITHIN_LOW, WITHIN_HIGH = 0.60, 0.80


@dataclass(frozen=True, slots=True)
class RealityFigures:
    """Figures of one reality.

    Attributes:
        name: Of the reality.
        figures: In the order of the bars.
        cases: How many cases there are.
        hidden: Cases left out because their sensors cannot show an effect of theirs, which was said before.
        crashed: Names of cases without an answer.
    """

    name: str
    figures: tuple[Figure, ...]
    cases: int
    hidden: int
    crashed: tuple[str, ...] = ()

    @property
    def missed(self) -> tuple[str, ...]:
        """Names of the bars that were missed."""
        return tuple(figure.name for figure in self.figures if figure.met is False)


def figures_of_reality(
    name: str, cases: Sequence[CheckedCase], crashed: Sequence[str] = ()
) -> RealityFigures:
    """Count the cases of one reality.

    Single cases and pairs count whether their gap was declared or not. Those of which each cause has a
    number as large as the diagnosis says it would have seen, or of whose effect it says nothing, count once
    more. Those with an effect that it said beforehand its sensors cannot show do not count.
    """
    counted = [case for case in cases if not _cannot_be_seen(case)]
    single = [c for c in counted if c.kind == SINGLE]
    declared = [c for c in single if gap_declared(c)]
    controls = [c for c in counted if c.kind == CONTROL]
    pairs = [c for c in counted if c.kind == PAIR]
    odd = [c for c in counted if c.kind in {OUTSIDE, REMOVED}]
    inside = [c for c in counted if c.kind in {SINGLE, PAIR} and gap_declared(c)]
    auroc = area_under(
        [c.answer.none for c in odd if gap_declared(c)], [c.answer.none for c in inside]
    )
    within = numbers_within(declared, 1.0)
    figures = (
        share(FIRST, map(first_right, single), 0.88),
        share(LARGE_ENOUGH, (first_right(c) for c in single if not too_small(c)), 0.80),
        share("or in its declared group", (_in_group(c) for c in single), 0.95),
        share("stage right, of detected", (stage_right(c) for c in declared), 0.97),
        share("healthy called no_gap", (not gap_declared(c) for c in controls), 0.95),
        share(BOTH, map(_all_named, pairs), 0.80),
        share(BOTH_LARGE_ENOUGH, (_all_named(c) for c in pairs if not too_small(c)), 0.80),
        share("outside: unexplained", map(recognised_unlike, odd), 0.75),
        number("AUROC of none of these", auroc, len(odd), ">= 0.93", lambda v: v >= 0.93),
        share(
            "listed, called unexplained", (c.answer.verdict == UNEXPLAINED for c in inside),
            0.05, at_most=True,
        ),
        calibration_figure("calibration error", counted),
        _between("number within one of its +-", within),
        share("number within two of its +-", numbers_within(declared, 2.0), 0.90),
        _crashed(cases, crashed),
    )  # fmt: skip
    return RealityFigures(name, figures, len(cases), len(cases) - len(counted), tuple(crashed))


def figures_alone(
    name: str,
    cases: Sequence[tuple[CheckedCase, Collection[str] | None]],
    crashed: Sequence[str] = (),
) -> RealityFigures:
    """Count the cases of one reality that were diagnosed without references.

    Such a diagnosis names what the simulator lacks, in a healthy robot too: its baseline, the effects that
    healthy robots of this kind have or show (given with each case). So the true cause should be among what
    is named, and nothing but the baseline in a healthy robot. Where the baseline is not known (None),
    healthy robots are not counted.
    """
    every = [case for case, _ in cases]
    counted = [(case, known) for case, known in cases if not _cannot_be_seen(case)]
    single = [c for c, _ in counted if c.kind == SINGLE]
    controls = [(c, known) for c, known in counted if c.kind == CONTROL and known is not None]
    figures = (
        share(AMONG, (_is_among(c) for c in single), 0.85),
        share(HEALTHY_ALONE, (set(named_effects(c)) <= set(known) for c, known in controls), 0.90),
        _crashed(every, crashed),
    )
    return RealityFigures(name, figures, len(cases), len(cases) - len(counted), tuple(crashed))


def _crashed(cases: Sequence[CheckedCase], crashed: Sequence[str]) -> Figure:
    return number("crashed", float(len(crashed)), len(cases) + len(crashed), "0", lambda v: v == 0)


def _is_among(case: CheckedCase) -> bool:
    """Whether the true cause is one of those named, at its joint."""
    return gap_declared(case) and _all_named(case)


def worst_reality(rows: Sequence[RealityFigures]) -> RealityFigures:
    """Return the reality that misses most bars; of equal ones that with fewest first causes right."""
    return max(rows, key=lambda row: (len(row.missed), -_first(row)))


def _first(row: RealityFigures) -> float:
    value = row.figures[0].value
    return 1.0 if math.isnan(value) else value


def _cannot_be_seen(case: CheckedCase) -> bool:
    return any(truth.effect in case.answer.hidden for truth in case.truths)


def _in_group(case: CheckedCase) -> bool:
    """Whether the true effect is the first named, at its leg, or declared to be like it."""
    if named_right(case):
        return leg_right(case)
    return case.truths[0].effect in group_of(case)


def _all_named(case: CheckedCase) -> bool:
    """Whether each true cause is named, at its joint."""
    return all(any(is_true(one, truth) for one in case.answer.named) for truth in case.truths)


def _between(name: str, hits: Sequence[bool]) -> Figure:
    one = ratio(name, sum(hits), len(hits), WITHIN_LOW)
    met = None if one.met is None else WITHIN_LOW <= one.value <= WITHIN_HIGH
    return replace(one, bar=f"{WITHIN_LOW:.0%} to {WITHIN_HIGH:.0%}", met=met)
