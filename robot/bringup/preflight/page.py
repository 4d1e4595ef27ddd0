"""The page of ``bigant check``: the robot from above by what was found, one sentence, then the numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robot.bringup.preflight.finding import CheckVerdict, Finding, count_line
from robot.bringup.preflight.loop import LoopFigures
from robot.bringup.preflight.servo_figures import ServoFigures
from robot.config.robot_file import RobotConfig
from robot.console.installed import version_lines
from robot.report.figure_style import NEUTRAL
from robot.report.page import Section, report_page
from robot.report.pictures import page_picture
from robot.report.plan_view import (
    LOOKS,
    PlanState,
    draw_plan,
    draw_rows,
    leg_places,
    state_legend,
)
from robot.report.plots import STYLE
from robot.requests.single import VIRTUAL

PERCENTILE_WORDS = ("half of the ticks", "95 %", "99 %", "the latest")
SAYS = (
    "Left: each leg by the worst that was found about its servo and its force sensor. Middle: all checks, "
    "in their order. Right: how long each read of all servos took; the dashed line is what its bytes take "
    "on the wire."
)
STATES = {
    CheckVerdict.PASS: PlanState.GOOD,
    CheckVerdict.WARN: PlanState.WARNED,
    CheckVerdict.FAIL: PlanState.BAD,
    CheckVerdict.SKIP: PlanState.UNKNOWN,
}
WORST_FIRST = (PlanState.BAD, PlanState.WARNED, PlanState.GOOD)
SERVO_HEAD = ("leg", "id", "voltage, V", "temperature, °C", "return delay, us")
READ_COLOUR = "#0072B2"


@dataclass(frozen=True, slots=True)
class CheckedRobot:
    """What was looked at.

    Attributes:
        config: Its robot file.
        port: Its servo port, or that it was virtual.
        file: The robot file's path.
    """

    config: RobotConfig
    port: str
    file: str


def check_page(
    robot: CheckedRobot,
    findings: Sequence[Finding],
    loops: Sequence[LoopFigures],
    servos: ServoFigures,
    *,
    date: str,
) -> str:
    """Return the page.

    Args:
        robot: The robot that was looked at.
        findings: The list.
        loops: Figures of the loop, if it was run.
        servos: What was measured of the servos.
        date: When it was looked at.
    """
    bad = [one.name for one in findings if one.verdict is CheckVerdict.FAIL]
    where = "virtual devices" if robot.port == VIRTUAL else robot.port
    todo = [(one.verdict.value, one.name, one.advice) for one in findings if one.advice]
    figure = draw_check(robot.config, findings, servos)
    return report_page(
        f"{robot.config.name}: pre-flight",
        f"{date}; {where}; robot file {robot.file}",
        [
            Section("What to do", todo, ("", "check", "what to do")),
            Section("Servos in numbers", _servo_rows(servos), SERVO_HEAD, (1, 2, 3, 4)),
            Section("Reading all servos", _read_rows(servos)),
            *map(_loop_section, loops),
            *(
                Section(part or "Checks", rows, ("", "check", "found"))
                for part, rows in _parts(findings).items()
            ),
        ],
        lead=page_picture(figure, "The robot from above, all checks, and the servo bus", "0", SAYS),
        verdict=f"{_sentence(bad)} {count_line(findings).capitalize()}.",
        kind="fail" if bad else "pass",
        footer=version_lines()[0],
    )


def leg_states(
    names: Sequence[str], findings: Sequence[Finding], asked: set[str]
) -> list[PlanState]:
    """Return the worst that was found about each leg.

    Args:
        names: Of the legs.
        findings: The list.
        asked: Legs whose servos answered: without a complaint they are fine.
    """
    states = []
    for name in names:
        found = {STATES[one.verdict] for one in findings if name in one.legs}
        usual = PlanState.GOOD if name in asked else PlanState.UNKNOWN
        states.append(next((one for one in WORST_FIRST if one in found), usual))
    return states


def draw_check(config: RobotConfig, findings: Sequence[Finding], servos: ServoFigures) -> Figure:
    """Draw the robot from above, a mark for each check, and how long the bus took."""
    asked = {one.leg: one for one in servos.conditions}
    places = leg_places(config)
    legs = leg_states(places.names, findings, set(asked))
    words = [
        f"{asked[name].temperature_c:.0f} °C" if name in asked else "" for name in places.names
    ]
    rows: dict[str, list[PlanState]] = {}
    for one in findings:
        rows.setdefault(one.part or "Checks", []).append(STATES[one.verdict])
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 3.9), layout="constrained")
        panels = 3 if servos.read_ms else 2
        plan, checks, *bus = figure.subplots(1, panels, width_ratios=(1.35, 1, 1)[:panels])
        draw_plan(plan, places, legs, words)
        draw_rows(checks, rows, "all checks", "check")
        if bus:
            _draw_reads(bus[0], servos)
        state_legend(figure, [*legs, *(state for states in rows.values() for state in states)])
    return figure


def _draw_reads(ax: Axes, servos: ServoFigures) -> None:
    took = np.array(servos.read_ms)
    number, whole = np.arange(1, len(took) + 1), np.array(servos.complete)
    ax.plot(number[whole], took[whole], ".", color=READ_COLOUR, ms=4)
    bad = LOOKS[PlanState.BAD]
    ax.plot(number[~whole], took[~whole], bad.marker, color=bad.colour, ms=6, ls="None")
    ax.axhline(servos.wire_ms, color=NEUTRAL, lw=1, ls="--")
    ax.axhline(servos.period_ms, color=bad.colour, lw=1)
    ax.set(ylim=(0, 1.15 * max(servos.period_ms, float(took.max()))), xlabel="read of all servos",
           ylabel="took [ms]", title=f"servo bus; line: period of {servos.period_ms:g} ms")  # fmt: skip


def _sentence(bad: Sequence[str]) -> str:
    return f"Not fit to walk: {', '.join(dict.fromkeys(bad))}." if bad else "Fit to walk."


def _parts(findings: Sequence[Finding]) -> dict[str, list[tuple[str, str, str]]]:
    """Rows of each part; what is wrong comes first."""
    order = (CheckVerdict.FAIL, CheckVerdict.WARN, CheckVerdict.SKIP, CheckVerdict.PASS)
    parts: dict[str, list[tuple[str, str, str]]] = {}
    for one in sorted(findings, key=lambda finding: order.index(finding.verdict)):
        parts.setdefault(one.part, []).append((one.verdict.value, one.name, one.found))
    names = list(dict.fromkeys(one.part for one in findings))
    return {name: parts[name] for name in names}


def _servo_rows(servos: ServoFigures) -> list[tuple[str, ...]]:
    return [
        (one.leg, str(one.servo_id), f"{one.voltage_v:.1f}", f"{one.temperature_c:.0f}",
         f"{one.return_delay_us:.0f}")
        for one in servos.conditions
    ]  # fmt: skip


def _read_rows(servos: ServoFigures) -> list[tuple[str, str]]:
    if not servos.read_ms:
        return []
    half, most = np.percentile(servos.read_ms, (50, 100))
    lost = servos.complete.count(False)
    return [
        ("reads", f"{len(servos.read_ms)}, {lost} without an answer of every servo"),
        ("half of them within", f"{half:.2f} ms"),
        ("the longest", f"{most:.2f} ms"),
        ("bytes on the wire", f"{servos.wire_ms:.2f} ms"),
        ("period of the loop", f"{servos.period_ms:g} ms"),
    ]


def _loop_section(loop: LoopFigures) -> Section:
    rows = [
        (words, f"{late:.3f}", f"{busy:.3f}")
        for words, late, busy in zip(PERCENTILE_WORDS, loop.late_ms, loop.busy_ms, strict=True)
    ]
    head = (f"{loop.ticks} ticks of {loop.period_ms:g} ms", "late, ms", "work, ms")
    return Section("The loop without torque", rows, head, (1, 2))
