"""What simpler ways said of the same cases, counted in the same way as the diagnosis."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gap.check.score import CONTROL, PAIR, SINGLE, Case, count_pairs, named_effects

THIS = "this diagnosis"


@dataclass(frozen=True, slots=True)
class Method:
    """Counts of one way of naming causes.

    Attributes:
        name: The way.
        first: Single-effect cases whose effect it named first.
        singles: How many there were.
        hits: Effects of two-effect cases that it named.
        truths: How many there were.
        said: How many it named in those cases.
        silent: Cases with nothing wrong in which it named nothing.
        controls: How many there were.
    """

    name: str
    first: int
    singles: int
    hits: int
    truths: int
    said: int
    silent: int
    controls: int


def methods(cases: Sequence[Case]) -> tuple[Method, ...]:
    """Count the diagnosis and each simpler way that its answers tell of; nothing if they tell of none."""
    asked = [case for case in cases if case.kind in {CONTROL, SINGLE, PAIR}]
    names = list(dict.fromkeys(name for case in asked for name, _ in case.answer.simpler))
    return tuple(_count(name, asked) for name in [THIS, *names]) if names else ()


def _count(name: str, cases: Sequence[Case]) -> Method:
    told = list(_told(name, cases))
    single = [(case, said) for case, said in told if case.kind == SINGLE]
    pairs = count_pairs((case, said) for case, said in told if case.kind == PAIR)
    control = [said for case, said in told if case.kind == CONTROL]
    return Method(
        name,
        sum(said[:1] == (case.truths[0].effect,) for case, said in single),
        len(single),
        *pairs,
        sum(not said for said in control),
        len(control),
    )


def _told(name: str, cases: Sequence[Case]) -> Iterator[tuple[Case, tuple[str, ...]]]:
    for case in cases:
        if name == THIS:
            yield case, named_effects(case)
        for simpler, effects in case.answer.simpler:
            if simpler == name:
                yield case, effects
