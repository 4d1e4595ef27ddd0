"""The pre-flight list as a page: what to keep beside the log of a run, or to send to someone."""

from collections.abc import Sequence

from robot.bringup.preflight.finding import Finding, Verdict, count_line
from robot.bringup.preflight.loop import LoopFigures
from robot.console.installed import version_lines
from robot.report.page import Section, report_page

VIRTUAL = "virtual"
PERCENTILES = ("half of the ticks", "95 %", "99 %", "the latest")


def check_page(
    robot: str,
    port: str,
    findings: Sequence[Finding],
    loops: Sequence[LoopFigures],
    *,
    robot_file: str,
    date: str,
) -> str:
    """Return the page.

    Args:
        robot: Name of the robot.
        port: Its servo port, or that it was virtual.
        findings: The list.
        loops: Figures of the loop, if it was run.
        robot_file: The robot file that was used.
        date: When it was looked at.
    """
    bad = [one.name for one in findings if one.verdict is Verdict.FAIL]
    where = "virtual devices" if port == VIRTUAL else port
    todo = [(one.name, one.advice) for one in findings if one.advice]
    rows = [(one.verdict.value, one.name, one.found) for one in findings]
    return report_page(
        f"{robot}: pre-flight",
        f"{date}; {where}; robot file {robot_file}; {count_line(findings)}",
        [
            Section("What to do", todo),
            Section("What was looked at", rows, ("", "check", "found")),
            *map(_loop, loops),
        ],
        verdict=f"Not fit to walk: {', '.join(bad)}." if bad else "Fit to walk.",
        kind="fail" if bad else "pass",
        footer=version_lines()[0],
    )


def _loop(loop: LoopFigures) -> Section:
    rows = [
        (words, f"{late:.3f}", f"{busy:.3f}")
        for words, late, busy in zip(PERCENTILES, loop.late_ms, loop.busy_ms, strict=True)
    ]
    head = (f"{loop.ticks} ticks of {loop.period_ms:g} ms", "late, ms", "work, ms")
    return Section("The loop without torque", rows, head, (1, 2))
