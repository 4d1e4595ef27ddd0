"""What is counted over the answers, each share with Wilson's 95 % interval (1927, JASA 22:209)."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from scipy.stats import binomtest

from benchmarks.gap.apart.answers import Question, answer_file
from benchmarks.gap.apart.cases import Case
from gap.check.cases import NO_GAP, UNEXPLAINED, CaseAnswer, Named, Truth, is_true
from model.effects.catalogue import EFFECTS
from robot.campaign.case import read_answer


@dataclass(frozen=True, slots=True)
class Answered:
    """A case with the answer to it; None where there is none."""

    case: Case
    referenced: bool
    answer: CaseAnswer | None

    @property
    def listed(self) -> bool:
        """Whether its cause is in the catalogue of today: dry friction came in after these cases."""
        return self.case.effect in EFFECTS

    @property
    def healthy(self) -> bool:
        """Whether nothing is wrong."""
        return not self.case.effect

    @property
    def verdict(self) -> str:
        """Verdict of the answer; empty where there is none."""
        return "" if self.answer is None else self.answer.verdict

    @property
    def named(self) -> tuple[Named, ...]:
        """Causes that were named, the first first; none where no gap was declared."""
        return () if self.answer is None or self.verdict == NO_GAP else self.answer.named

    def right(self, named: Named) -> bool:
        """Whether a cause that was named is what is wrong, at its joint or leg."""
        return is_true(named, Truth(self.case.effect, "", self.case.fault.place, ()))

    @property
    def first_right(self) -> bool:
        """Whether the first cause that was named is what is wrong."""
        return bool(self.named) and self.right(self.named[0])


@dataclass(frozen=True, slots=True)
class Count:
    """How many cases of how many."""

    question: str
    hits: int
    cases: int

    @property
    def words(self) -> str:
        """The count, with the interval of its share."""
        if not self.cases:
            return "no case"
        share = binomtest(self.hits, self.cases).proportion_ci(0.95, method="wilson")
        return f"{self.hits} of {self.cases} ({100 * share.low:.0f} to {100 * share.high:.0f} %)"


def read_answers(out: Path, questions: Sequence[Question]) -> list[Answered]:
    """Return the answers that are there.

    Raises:
        RecordError: A file is no answer.
    """
    return [
        Answered(one.case, one.referenced, read_answer(path) if path.is_file() else None)
        for one in questions
        for path in (answer_file(out, one),)
    ]


def counts(answered: Sequence[Answered]) -> tuple[Count, ...]:
    """Count the answers; a case without an answer is not right."""
    referenced = [one for one in answered if one.referenced]
    listed = [one for one in referenced if one.listed]
    right = [one for one in listed if one.first_right]
    outside = [one for one in referenced if not one.listed and not one.healthy]
    alone = [one for one in answered if not one.referenced]
    return (
        _count("cause of the catalogue named first, at its joint or leg",
               (one.first_right for one in listed)),
        _count("another cause named, too, that is not there, of these",
               (not all(map(one.right, one.named)) for one in right)),
        _count("healthy robots called no_gap",
               (one.verdict == NO_GAP for one in referenced if one.healthy)),
        _count("causes outside the catalogue called unexplained",
               (one.verdict == UNEXPLAINED for one in outside)),
        _count("without references: true cause among the named",
               (any(map(one.right, one.named)) for one in alone)),
        _count("without an answer", (one.answer is None for one in answered)),
    )  # fmt: skip


def case_rows(answered: Iterable[Answered]) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, what is wrong, verdict, and causes with their probabilities."""
    for one in answered:
        name = one.case.name if one.referenced else f"{one.case.name}, no references"
        wrong = " ".join(filter(None, (one.case.words, one.case.fault.place)))
        causes = (
            f"{' '.join((cause.effect, *cause.joints))} {cause.probability:.2f}"
            for cause in one.named
        )
        yield name, wrong, one.verdict or "no answer", ", ".join(causes)


def _count(question: str, hits: Iterable[bool]) -> Count:
    known = list(hits)
    return Count(question, sum(known), len(known))
