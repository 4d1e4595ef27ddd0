"""``bigant doctor``: is this computer set up, and if not, what to do?

Looks at versions, optional parts, disk, serial ports and who may open them, latency timers, real-time
settings, the compiler's cache and OpenGL. Asks no device anything; the robot itself is looked at by bigant
check.
"""

import argparse
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from robot.bringup.preflight.finding import (
    Finding,
    Verdict,
    count_line,
    failed,
    lines_of,
    passed,
    plain_finding,
    skipped,
)
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.dynamixel.scan import SerialPort

LOG_FOLDER = Path("runs")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Look at the computer and print the list.

    Returns:
        OK, or VERDICT_FAILED when something failed.
    """
    findings = []
    for finding in _findings():
        findings.append(finding)
        for line in [] if options.json else lines_of(finding):
            print(line, flush=True)
    bad = any(finding.verdict is Verdict.FAIL for finding in findings)
    if options.json:
        listed = [plain_finding(finding) for finding in findings]
        print(json.dumps({"findings": listed, "fit": not bad}, indent=2))
    else:
        print(count_line(findings))
    return ExitCode.VERDICT_FAILED if bad else ExitCode.OK


def _findings() -> Iterator[Finding]:
    from record.log.versions import version_of
    from robot.bringup.preflight.computer import (
        cache_finding,
        extras_findings,
        host_settings_findings,
        machine_facts,
        machine_findings,
    )
    from robot.bringup.preflight.host import host_findings

    yield passed("bigant", version_of("bigant"))
    yield from host_findings(LOG_FOLDER)
    yield from extras_findings()
    yield cache_finding()
    yield from machine_findings(machine_facts())
    from robot.bringup.preflight.loop import host_settings

    host = host_settings(None)
    yield from host_settings_findings(host.governors, host.isolated, host.load, host.processors)
    from drivers.dynamixel.scan import serial_ports

    yield from port_findings(serial_ports())


def port_findings(ports: "tuple[SerialPort, ...]") -> Iterator[Finding]:
    """Judge permissions and latency timer of each USB port."""
    from drivers.dynamixel.port import latency_timer_ms
    from robot.bringup.preflight.servos import latency_finding

    adapters = [port for port in ports if port.usb_id]
    if not adapters:
        yield skipped("serial ports", "no USB adapter is plugged in; virtual hardware needs none")
    for port in adapters:
        if os.access(port.name, os.R_OK | os.W_OK):
            yield passed(port.name, f"{port.usb_id} {port.description}".strip())
        else:
            yield failed(
                port.name,
                "may not be opened by you",
                "join its group (see the line 'serial group'), or ask who looks after this computer",
            )
        timer = latency_finding(latency_timer_ms(port.name))
        yield Finding(f"{port.name} timer", timer.verdict, timer.found, timer.advice)
