"""``bigant sim faults``: every fault and setting that a scenario file can hold.

List the faults that a scenario file (--scenario of drive and sim serve) can put on the virtual hardware:
what each does, where it acts, and its keys with unit, default and bounds. examples/faults_servo.toml and
examples/faults_force.toml show them in use.
"""

import argparse

from robot.console.arguments import add_json
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_json(parser, "the list")


def run(options: argparse.Namespace) -> ExitCode:
    """List the faults."""
    from robot.virtual.listing import list_faults

    return list_faults(as_json=options.json)
