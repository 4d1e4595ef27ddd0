"""``bigant ft scan``: which wireless force-torque units are there. Asks, and changes nothing.

Asks by ATI's discovery protocol and lists the units that answer.
"""

import argparse
import json
from dataclasses import asdict

from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument(
        "--discover",
        metavar="ADDRESS[:PORT]|none",
        default="255.255.255.255",
        help="where to ask (default: broadcast on the local network)",
    )
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Ask and list.

    Returns:
        OK when a unit answered, VERDICT_FAILED when none did.

    Raises:
        ConfigError: The address makes no sense.
        ForceStreamError: The question cannot be sent.
    """
    from drivers.ati.discovery import discover
    from robot.cli.devices import discovery_target

    address, port = discovery_target(options.discover)
    units = discover(address, port) if address else ()
    if options.json:
        print(json.dumps({"force_units": [asdict(unit) for unit in units]}, indent=2))
    for unit in () if options.json else units:
        print(f"{unit.address:<16} {unit.mac}  {unit.text}  {unit.location}")
    if not units and not options.json:
        print("no force-torque unit answered: check that it is on and on this network")
    return ExitCode.OK if units else ExitCode.VERDICT_FAILED
