"""Simpler methods on the same cases, counted in the same way as the diagnosis."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from gap.check.cases import CONTROL, PAIR, SINGLE, CheckedCase, named_effects
from gap.check.score import count_pairs

THIS = "this diagnosis"


@dataclass(frozen=True, slots=True)
class Method:
    """Counts of one method of naming causes.

    Attributes:
        first: Of ``singles`` single-effect cases, those whose effect it named first.
        hits: Of ``truths`` effects of two-effect cases, those that it named; it named ``said`` in them.
        silent: Of ``controls`` cases with nothing wrong, those in which it named nothing.
    """

    name: str
    first: int
    singles: int
    hits: int
    truths: int
    said: int
    silent: int
    controls: int


def methods(cases: Sequence[CheckedCase]) -> tuple[Method, ...]:
    """Count the diagnosis and each simpler method in its answers; nothing if there are none."""
    counted = [case for case in cases if case.kind in {CONTROL, SINGLE, PAIR}]
    names = list(dict.fromkeys(name for case in counted for name, _ in case.answer.simpler))
    return tuple(_count(name, counted) for name in [THIS, *names]) if names else ()


def _count(name: str, cases: Sequence[CheckedCase]) -> Method:
    answers = list(_answers(name, cases))
    single = [(case, named) for case, named in answers if case.kind == SINGLE]
    pairs = count_pairs((case, named) for case, named in answers if case.kind == PAIR)
    control = [named for case, named in answers if case.kind == CONTROL]
    return Method(
        name,
        sum(named[:1] == (case.truths[0].effect,) for case, named in single),
        len(single),
        *pairs,
        sum(not named for named in control),
        len(control),
    )


def _answers(
    name: str, cases: Sequence[CheckedCase]
) -> Iterator[tuple[CheckedCase, tuple[str, ...]]]:
    for case in cases:
        if name == THIS:
            yield case, named_effects(case)
        for simpler, effects in case.answer.simpler:
            if simpler == name:
                yield case, effects
