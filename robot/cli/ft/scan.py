"""``bigant ft scan``: which wireless force-torque units are there. Asks, and changes nothing.

Asks by ATI's discovery protocol and lists the units that answer.
"""

import argparse

from robot.console.arguments import add_discover, add_json
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_discover(parser)
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """List the units."""
    from robot.bringup.preflight.devices import list_force_units

    return list_force_units(options.discover, as_json=options.json)
