"""``bigant check --computer``: is this computer set up? ``computer`` has the checks; no device is used."""

import os
from collections.abc import Iterator

from drivers.dynamixel.port import latency_timer_ms
from drivers.dynamixel.scan import SerialPort, serial_ports
from record.log.header import version_of
from robot.bringup.preflight.computer import (
    cache_finding,
    extras_findings,
    host_settings,
    host_settings_findings,
    machine_facts,
    machine_findings,
    software_findings,
)
from robot.bringup.preflight.finding import (
    Finding,
    count_line,
    exit_code,
    failed,
    listed,
    passed,
    plain_findings,
    skipped,
)
from robot.bringup.preflight.servos import latency_finding
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.progress import StatusLine
from robot.requests.single import CheckRequest


def check_computer(request: CheckRequest) -> ExitCode:
    """Look at the computer and print the list.

    Returns:
        OK, or VERDICT_FAILED when something failed.
    """
    with StatusLine() as status:
        findings = listed(_findings(), status, quiet=request.json)
    print_result(plain_findings(findings), [count_line(findings)], as_json=request.json)
    return exit_code(findings)


def _findings() -> Iterator[Finding]:
    yield passed("bigant", version_of("bigant"))
    yield from software_findings()
    yield from extras_findings()
    yield cache_finding()
    yield from machine_findings(machine_facts())
    yield from host_settings_findings(host_settings(None))
    yield from port_findings(serial_ports())


def port_findings(ports: tuple[SerialPort, ...]) -> Iterator[Finding]:
    """Judge permissions and latency timer of each USB port."""
    adapters = [port for port in ports if port.usb_id]
    if not adapters:
        yield skipped("serial ports", "no USB adapter is plugged in; virtual hardware needs none")
    for port in adapters:
        if os.access(port.name, os.R_OK | os.W_OK):
            yield passed(port.name, f"{port.usb_id} {port.description}".strip())
        else:
            yield failed(
                port.name,
                "you have no permission to open it",
                "join its group (see the line 'serial group'), or ask who looks after this computer",
            )
        timer = latency_finding(latency_timer_ms(port.name))
        yield Finding(f"{port.name} timer", timer.verdict, timer.found, timer.advice)
