"""``bigant servo scan``: who answers at which baud rate.

Pings everybody at every baud rate (0.8 s each) and lists model and firmware. Writes nothing.
"""

import argparse
import json
from dataclasses import asdict
from typing import TYPE_CHECKING

from robot.bringup.servo.access import add_port, bauds_of, scan_port
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.dynamixel.scan import FoundServo


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser, required=False)
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Scan and print.

    Returns:
        OK when a servo answered, VERDICT_FAILED when none did.

    Raises:
        BusError: A port cannot be opened.
    """
    from drivers.dynamixel.scan import serial_ports

    names = [options.port] if options.port else [p.name for p in serial_ports() if p.usb_id]
    found = [
        (name, servo)
        for name in names
        for servo in scan_port(name, bauds_of(options), quiet=options.json)
    ]
    if options.json:
        print(json.dumps([{"port": name, **asdict(servo)} for name, servo in found], indent=2))
    for line in [] if options.json else lines_of(names, found):
        print(line)
    return ExitCode.OK if found else ExitCode.VERDICT_FAILED


def lines_of(names: list[str], found: "list[tuple[str, FoundServo]]") -> list[str]:
    """Return one line for each servo, or what to do if there is none."""
    if not names:
        return ["no USB serial port: plug in the U2D2, or name a port with --port"]
    if not found:
        return [f"no servo answers on {', '.join(names)}: check power and cable"]
    return [f"{name}  {servo_line(servo)}" for name, servo in found]


def servo_line(servo: "FoundServo") -> str:
    """Return one servo as a line."""
    kinds = {321: "MX-106 (protocol 2.0)", 320: "MX-106 (protocol 1.0)"}
    kind = kinds.get(servo.model, f"model {servo.model}")
    return f"{servo.baud_rate:>8} baud  id {servo.servo_id:>3}  {kind}  firmware {servo.firmware}"
