"""A case of a check, both sides of it: what was wrong, and what the diagnosis named."""

from collections.abc import Iterable
from dataclasses import dataclass

from gap.detectable import Detectable

CONTROL, SINGLE, PAIR, OUTSIDE, REMOVED = "control", "single", "pair", "outside", "removed"
NO_GAP, UNEXPLAINED = "no_gap", "unexplained"


@dataclass(frozen=True, slots=True)
class Truth:
    """One thing that was wrong; the joint is empty for the whole machine, values are (parameter, value)."""

    effect: str
    stage: str
    joint: str
    values: tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class Named:
    """One cause that a diagnosis named; values are (parameter, value), errors (parameter, its +-)."""

    effect: str
    joints: tuple[str, ...]
    values: tuple[tuple[str, float], ...]
    probability: float
    errors: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Remainder:
    """What the causes of a diagnosis leave, from which it judges whether the catalogue has no name for it.

    Attributes:
        closed: Share of the explainable gap that they close, 0 to 1.
        excess: Energy over expectation that they leave.
        worst: The same of the worst channel.
        p: Chance of so much in a healthy machine.
        acting: Share of the gap that they close in the channels in which they act, 0 to 1.
        there: How much more is left at their joints on held-out runs than at others.
        unwatched: How many stages of the chain were not measured.
        rough: How roughly the form of the cause that gains most is known, 0 to 1.
    """

    closed: float
    excess: float
    worst: float
    p: float
    acting: float = 1.0
    there: float = 0.0
    unwatched: float = 0.0
    rough: float = 0.0


@dataclass(frozen=True, slots=True)
class CaseAnswer:
    """The diagnosis of one case.

    Attributes:
        verdict: ``no_gap``, ``explained``, ``ambiguous`` or ``unexplained``.
        named: Causes, the largest first.
        alike: Pairs of effects that it declared indistinguishable.
        none: Probability that the catalogue has no name for it.
        shrink: Share of the gap explained on held-out runs; NaN if not measured.
        seconds: Time that it took; NaN if not known.
        simpler: Simpler methods: name, and the effects that they named in their order.
        hidden: Effects that it said, before judging, these runs cannot show.
        remainder: What its causes leave; None if it does not say.
        referenced: Whether it had healthy runs.
        detectable: Sizes that it would have seen in these runs.
    """

    verdict: str
    stage: str
    named: tuple[Named, ...]
    alike: tuple[tuple[str, str], ...]
    none: float
    shrink: float
    seconds: float
    simpler: tuple[tuple[str, tuple[str, ...]], ...] = ()
    hidden: tuple[str, ...] = ()
    remainder: Remainder | None = None
    referenced: bool = True
    detectable: tuple[Detectable, ...] = ()


@dataclass(frozen=True, slots=True)
class CheckedCase:
    """A case, both sides of it.

    Attributes:
        kind: control, single, pair, outside or removed (from the catalogue).
        visible: Largest change of any channel over its repeatability; NaN if it was not measured.
        reachable: Share that the true effects with true parameters close; NaN if not measured.
    """

    name: str
    kind: str
    truths: tuple[Truth, ...]
    answer: CaseAnswer
    visible: float
    reachable: float


def gap_declared(case: CheckedCase) -> bool:
    """Whether a gap was declared."""
    return case.answer.verdict != NO_GAP


def named_effects(case: CheckedCase) -> tuple[str, ...]:
    """Return the effects that were named, the largest first; none where no gap was declared."""
    return tuple(one.effect for one in case.answer.named) if gap_declared(case) else ()


def named_right(case: CheckedCase) -> bool:
    """Whether the first cause named is the true effect (of a single-effect case)."""
    return bool(case.answer.named) and case.answer.named[0].effect == case.truths[0].effect


def too_small(case: CheckedCase) -> tuple[str, ...]:
    """Return the true effects that are smaller than what the diagnosis says it would have seen."""
    sizes = {(d.effect, d.parameter): d for d in case.answer.detectable}

    def seen(truth: Truth) -> list[bool]:
        known = [(v, sizes.get((truth.effect, name))) for name, v in truth.values]
        return [not abs(v - one.neutral) < one.size for v, one in known if one is not None]

    return tuple(t.effect for t in case.truths if seen(t) and not any(seen(t)))


def probabilities_given(cases: Iterable[CheckedCase]) -> tuple[tuple[float, bool], ...]:
    """Return the probability of each cause that was named, and whether it was there, at its leg.

    A probability leaves a share to causes that the catalogue does not have, and to the same effect at
    other legs. So cases whose cause is outside the catalogue count as well (what is named there is wrong):
    without them, probabilities that are right would seem too low.
    """
    return tuple(
        (one.probability, listed and any(is_true(one, truth) for truth in case.truths))
        for case in cases
        if gap_declared(case)
        for listed in (case.kind not in {OUTSIDE, REMOVED},)
        for one in case.answer.named
    )


def is_true(one: Named, truth: Truth) -> bool:
    """Whether what was named is what was wrong, at its joint."""
    return (one.effect, one.joints) == (truth.effect, (truth.joint,) if truth.joint else ())


def group_of(case: CheckedCase) -> frozenset[str]:
    """Return the first named effect with all that were declared to be like it."""
    if not case.answer.named:
        return frozenset()
    first = case.answer.named[0].effect
    pairs = [{_bare(a), _bare(b)} for a, b in case.answer.alike]
    return frozenset({first}.union(*(pair for pair in pairs if first in pair)))


def _bare(name: str) -> str:
    return name.split()[0]
