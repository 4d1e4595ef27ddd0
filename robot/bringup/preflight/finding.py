"""One line of the pre-flight list. Pure."""

import enum
from collections.abc import Iterable
from dataclasses import dataclass


class Verdict(enum.Enum):
    """How a check ended."""

    PASS = "pass"
    WARN = "warn"
    FAIL = "fail"
    SKIP = "skip"


@dataclass(frozen=True, slots=True)
class Finding:
    """One check.

    Attributes:
        name: What was looked at.
        verdict: How it ended.
        found: What was found, or why it was skipped.
        advice: What to do; empty if it passed.
    """

    name: str
    verdict: Verdict
    found: str
    advice: str = ""


def passed(name: str, found: str) -> Finding:
    """Return a check that passed."""
    return Finding(name, Verdict.PASS, found)


def warned(name: str, found: str, advice: str) -> Finding:
    """Return a check whose result should be put right."""
    return Finding(name, Verdict.WARN, found, advice)


def failed(name: str, found: str, advice: str) -> Finding:
    """Return a check whose result has to be put right before the robot walks."""
    return Finding(name, Verdict.FAIL, found, advice)


def skipped(name: str, why: str) -> Finding:
    """Return a check that was not made."""
    return Finding(name, Verdict.SKIP, why)


def lines_of(finding: Finding) -> list[str]:
    """Return a finding as one line, and a second one if there is something to do."""
    lines = [f"{finding.verdict.value}  {finding.name:<16} {finding.found}"]
    if finding.advice:
        lines.append(f"{'':>23}-> {finding.advice}")
    return lines


def plain_finding(finding: Finding) -> dict[str, str]:
    """Return a finding as JSON can hold it."""
    return {
        "name": finding.name,
        "verdict": finding.verdict.value,
        "found": finding.found,
        "advice": finding.advice,
    }


def count_line(findings: Iterable[Finding]) -> str:
    """Return how many checks ended how."""
    verdicts = [finding.verdict for finding in findings]
    counts = {verdict: verdicts.count(verdict) for verdict in Verdict}
    return ", ".join(
        f"{counts[verdict]} {words}"
        for verdict, words in (
            (Verdict.PASS, "passed"),
            (Verdict.WARN, "warned"),
            (Verdict.FAIL, "failed"),
            (Verdict.SKIP, "skipped"),
        )
    )
