"""``bigant servo restore``: put a backup back.

Shows what differs between the file and each servo, asks, writes with torque off, and reads back. A
servo is found by its id; one of another model, or with torque on, is refused before anything is written.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_port, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="FILE", help="made by bigant servo backup")
    add_port(parser)
    parser.add_argument("--yes", action="store_true", help="write without being asked")


def run(options: argparse.Namespace) -> ExitCode:
    """Restore."""
    from robot.bringup.servo.backup import RestoreRequest, restore

    return restore(parsed(options, RestoreRequest))
