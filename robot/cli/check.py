"""``bigant check``: the pre-flight list. Is this robot fit to walk?

Only asks, except with --armed (and on virtual hardware), where torque goes on at the measured
positions to prove that the servos' own watchdog stops them; nothing is told to move.
"""

import argparse
import json
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import BigantError, ConfigError, ConnectionLost
from robot.bringup.preflight.finding import (
    Finding,
    Verdict,
    count_line,
    failed,
    lines_of,
    plain_finding,
    skipped,
)
from robot.bringup.servo.access import new_port, progress, robot_of
from robot.console.arguments import add_robot
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.settings import ForceSensorSettings
    from robot.bringup.preflight.loop import LoopFigures
    from robot.config.robot_file import RobotConfig

VIRTUAL = "virtual"
NONE = "none"
LISTEN_S = 3.0
LOOP_S = 10.0
LOG_FOLDER = Path("runs")


@dataclass(frozen=True, slots=True)
class Target:
    """The robot that is looked at.

    Attributes:
        config: Robot file.
        port: Serial port.
        unit: Force-torque unit, None to leave it out.
        armed: Whether torque may be switched on for the proof of the watchdog.
    """

    config: "RobotConfig"
    port: str
    unit: "ForceSensorSettings | None"
    armed: bool


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--hardware",
        default=VIRTUAL,
        metavar="virtual|PORT",
        help="virtual (default), or the serial port of the servo bus",
    )
    parser.add_argument(
        "--force-unit",
        metavar="HOST[:UDP:CONSOLE]|none",
        help="wireless force-torque unit (robot file); none leaves it out",
    )
    add_robot(parser)
    parser.add_argument(
        "--armed", action="store_true", help="torque on, holding still, to prove the watchdog"
    )
    parser.add_argument(
        "--loop",
        type=_seconds,
        nargs="?",
        const=LOOP_S,
        metavar="S",
        help="also run the loop without torque and say how late it is (10 s)",
    )
    parser.add_argument("--json", action="store_true", help="the result as JSON")
    parser.add_argument("--html", type=Path, metavar="FILE", help="the list as one page, to keep")


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.5 <= value <= 3600:
        raise argparse.ArgumentTypeError(f"must be from 0.5 to 3600 s, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Look at everything and print the list.

    Returns:
        OK, or VERDICT_FAILED when something failed.

    Raises:
        BigantError: The robot file or an argument cannot be used.
    """
    if options.html is not None and options.html.suffix != ".html":
        raise ConfigError("--html", f"must end in .html, not {options.html.name!r}")
    with ExitStack() as stack:
        target = _target(options, stack)
        findings: list[Finding] = []
        figures: list[LoopFigures] = []
        for finding in _findings(target, options, figures):
            progress("", quiet=options.json)
            findings.append(finding)
            for line in [] if options.json else lines_of(finding):
                print(line, flush=True)
    if options.json:
        print(json.dumps(_as_json(findings, figures), indent=2))
    else:
        print(count_line(findings))
    if options.html is not None:
        from robot.bringup.preflight.page import check_page
        from robot.report.page import write_page
        from robot.report.run_date import utc_words

        page = check_page(
            target.config.name,
            options.hardware,
            findings,
            figures,
            robot_file=_short(options.robot),
            date=utc_words(time.time_ns()),
        )
        write_page(options.html, page)
        if not options.json:
            print(f"page: {options.html}")
    bad = any(finding.verdict is Verdict.FAIL for finding in findings)
    return ExitCode.VERDICT_FAILED if bad else ExitCode.OK


def _short(path: Path) -> str:
    """Return a path as seen from here, if it lies below."""
    here = Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)


def _target(options: argparse.Namespace, stack: ExitStack) -> Target:
    config = robot_of(options)
    from robot.run.force_unit import check_no_unit, unit_settings

    if options.hardware == VIRTUAL:
        check_no_unit(options.force_unit)
        from robot.virtual.open import start_virtual

        devices, unit = start_virtual(config, seed=0)
        stack.callback(devices.close)
        port = devices.addresses.servo_port
        return Target(config, port, None if options.force_unit == NONE else unit, armed=True)
    wanted = None
    if options.force_unit != NONE:
        wanted = unit_settings(options.force_unit, config.force_sensor)
    return Target(config, options.hardware, wanted, options.armed)


def _findings(
    target: Target, options: argparse.Namespace, figures: "list[LoopFigures]"
) -> Iterator[Finding]:
    from robot.bringup.preflight.host import host_findings

    yield from host_findings(LOG_FOLDER)
    progress("looking at the servos ...", quiet=options.json)
    yield from _servo_findings(target)
    if target.unit is None:
        yield skipped("force unit", "left out with --force-unit none")
    else:
        progress(f"listening to the force-torque unit, {LISTEN_S:g} s ...", quiet=options.json)
        yield from _force_findings(target.unit)
    if options.loop is not None:
        yield _loop_finding(target, options, figures)


def _servo_findings(target: Target) -> Iterator[Finding]:
    from drivers.dynamixel.bus import ServoBus
    from robot.bringup.preflight.servos import servo_findings

    settings = target.config.servo_bus
    port = new_port(target.port, settings.baud_rate)
    bus = ServoBus(port, settings, port.clock)
    with closing(bus):
        try:
            yield from servo_findings(bus, target.config, armed=target.armed)
        except ConnectionLost as error:
            yield failed("port", str(error), "put the cable back and check again")


def _force_findings(unit: "ForceSensorSettings") -> Iterator[Finding]:
    from drivers.clock import MonotonicClock
    from robot.bringup.preflight.forces import force_findings
    from robot.run.force_unit import open_force_links

    clock = MonotonicClock()
    yield from force_findings(
        lambda: open_force_links(unit, clock),
        unit,
        clock,
        seconds=LISTEN_S,
        unix_offset_ns=time.time_ns() - clock.now_ns(),
    )


def _loop_finding(
    target: Target, options: argparse.Namespace, figures: "list[LoopFigures]"
) -> Finding:
    from robot.bringup.preflight.loop import host_settings, loop_finding, run_loop
    from robot.run.hardware import open_real

    try:
        rig = open_real(target.config, target.port, target.unit, armed=False)
    except BigantError as error:
        return failed("loop", f"not run: {error}", "put right what failed above first")
    with closing(rig):

        def say(ticks: int) -> None:
            words = f"the loop without torque, {options.loop:g} s: {ticks} ticks ..."
            progress(words, quiet=options.json)

        result = run_loop(rig, target.config, options.loop, say)
        figures.append(result)
        host = host_settings(rig.bus.latency_timer_ms)
    return loop_finding(result, host, target.config.loop.late_limit_s)


def _as_json(findings: list[Finding], figures: "list[LoopFigures]") -> dict[str, object]:
    result: dict[str, object] = {
        "findings": [plain_finding(finding) for finding in findings],
        "fit": all(f.verdict is not Verdict.FAIL for f in findings),
    }
    for loop in figures:
        late = dict(zip(("p50", "p95", "p99", "max"), loop.late_ms, strict=True))
        busy = dict(zip(("p50", "p95", "p99", "max"), loop.busy_ms, strict=True))
        result["loop"] = {
            "period_ms": loop.period_ms,
            "ticks": loop.ticks,
            "missed": loop.missed,
            "late_ticks": loop.late_ticks,
            "late_ms": late,
            "busy_ms": busy,
            "ended": loop.reason.name.lower(),
        }
    return result
