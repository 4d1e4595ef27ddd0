"""``bigant devices``: ports, servos at each baud rate, force-torque units.

List serial ports, the servos that answer at each baud rate, and wireless force-torque units found by
discovery. Nothing is written and nothing moves.
"""

import argparse

from robot.console.arguments import add_discover, add_json, add_port, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser, required=False)
    add_discover(parser)
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """List the devices."""
    from robot.bringup.preflight.devices import DevicesRequest, list_devices

    return list_devices(parsed(options, DevicesRequest))
