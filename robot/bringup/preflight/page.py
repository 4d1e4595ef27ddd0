"""The pre-flight list as a page: what to keep beside the log of a run, or to send to someone."""

from collections.abc import Sequence

from robot.bringup.preflight.finding import Finding, Verdict, count_line
from robot.bringup.preflight.loop import LoopFigures
from robot.console.versions import version_lines
from robot.report.page import grid_table, heading, page_frame, rows_table, section

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
        robot_file: The robot file that was believed.
        date: When it was looked at.
    """
    bad = [one.name for one in findings if one.verdict is Verdict.FAIL]
    answer = f"Not fit to walk: {', '.join(bad)}" if bad else "Fit to walk"
    colour = "fail" if bad else "pass"
    todo = [(one.name, one.advice) for one in findings if one.advice]
    rows = [(one.verdict.value, one.name, one.found) for one in findings]
    where = "virtual devices" if port == VIRTUAL else port
    return page_frame(
        f"{robot}: pre-flight",
        [
            heading(
                f"{robot}: pre-flight",
                f"{date}; {where}; robot file {robot_file}; {count_line(findings)}",
            ),
            f"<p class='verdict {colour}'>{answer}.</p>",
            section("What to do", rows_table(todo)),
            section("What was looked at", grid_table(("", "check", "found"), rows)),
            *(section("The loop without torque", _loop(one)) for one in loops),
            f"<footer><p>{version_lines()[0]}</p></footer>",
        ],
    )


def _loop(loop: LoopFigures) -> str:
    rows = [
        (words, f"{late:.3f}", f"{busy:.3f}")
        for words, late, busy in zip(PERCENTILES, loop.late_ms, loop.busy_ms, strict=True)
    ]
    head = (f"{loop.ticks} ticks of {loop.period_ms:g} ms", "late, ms", "work, ms")
    return grid_table(head, rows, numbers=(1, 2))
