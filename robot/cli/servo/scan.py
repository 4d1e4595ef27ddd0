"""``bigant servo scan``: who answers at which baud rate.

Pings everybody at every baud rate (0.8 s each) and lists model and firmware. Writes nothing.
"""

import argparse

from robot.console.arguments import add_json, add_port, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser, required=False)
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Scan."""
    from robot.bringup.preflight.devices import ScanRequest, scan_servos

    return scan_servos(parsed(options, ScanRequest))
