"""The pre-flight list: one finding a check, printed as it comes, counted and judged at the end."""

import enum
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace

from robot.console.exit_codes import ExitCode
from robot.console.progress import StatusLine

# Parts of the robot that findings are about.
COMPUTER, ROBOT_FILE, SERVOS, FORCE_UNIT = "Computer", "Robot file", "Servos", "Force unit"
IMU, LOOP = "IMU", "Loop"


class CheckVerdict(enum.Enum):
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
        legs: Legs that it is about; empty where it is about none in particular.
        part: What part of the robot it is about.
    """

    name: str
    verdict: CheckVerdict
    found: str
    advice: str = ""
    legs: tuple[str, ...] = ()
    part: str = ""


def passed(name: str, found: str) -> Finding:
    """Return a check that passed."""
    return Finding(name, CheckVerdict.PASS, found)


def warned(name: str, found: str, advice: str) -> Finding:
    """Return a check whose result should be corrected."""
    return Finding(name, CheckVerdict.WARN, found, advice)


def failed(name: str, found: str, advice: str) -> Finding:
    """Return a check whose result has to be corrected before the robot walks."""
    return Finding(name, CheckVerdict.FAIL, found, advice)


def skipped(name: str, why: str) -> Finding:
    """Return a check that was not made."""
    return Finding(name, CheckVerdict.SKIP, why)


def about(legs: Iterable[str], finding: Finding) -> Finding:
    """Return a finding about some legs."""
    return replace(finding, legs=tuple(legs))


def in_part(part: str, findings: Iterable[Finding]) -> Iterator[Finding]:
    """Return findings about a part of the robot, as they come."""
    return (replace(finding, part=part) for finding in findings)


def lines_of(finding: Finding) -> list[str]:
    """Return a finding as one line, and a second one if there is something to do."""
    lines = [f"{finding.verdict.value}  {finding.name:<16} {finding.found}"]
    if finding.advice:
        lines.append(f"{'':>23}-> {finding.advice}")
    return lines


def listed(findings: Iterator[Finding], status: StatusLine, *, quiet: bool) -> list[Finding]:
    """Return findings, each printed as it comes.

    Args:
        findings: Makes them, one after the other.
        status: Shows what is being looked at meanwhile.
        quiet: Whether to print nothing.
    """
    result = []
    for finding in findings:
        status.clear()
        result.append(finding)
        if not quiet:
            print("\n".join(lines_of(finding)), flush=True)
    return result


def plain_findings(findings: Sequence[Finding]) -> dict[str, object]:
    """Return findings, and whether nothing failed, as JSON can hold them."""
    plain = [{**asdict(one), "verdict": one.verdict.value} for one in findings]
    return {"findings": plain, "fit": fit(findings)}


def fit(findings: Iterable[Finding]) -> bool:
    """Whether nothing failed."""
    return all(one.verdict is not CheckVerdict.FAIL for one in findings)


def exit_code(findings: Iterable[Finding]) -> ExitCode:
    """Return OK, or VERDICT_FAILED when something failed."""
    return ExitCode.OK if fit(findings) else ExitCode.VERDICT_FAILED


def count_line(findings: Sequence[Finding]) -> str:
    """Return how many checks ended how."""
    words = {
        CheckVerdict.PASS: "passed",
        CheckVerdict.WARN: "warned",
        CheckVerdict.FAIL: "failed",
        CheckVerdict.SKIP: "skipped",
    }
    verdicts = [one.verdict for one in findings]
    return ", ".join(f"{verdicts.count(verdict)} {word}" for verdict, word in words.items())
