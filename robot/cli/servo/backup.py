"""``bigant servo backup``: everything the servos keep, into a file.

Reads all EEPROM registers and the gains of every servo that answers, with id, model, firmware and
date, into a TOML file that ``bigant servo restore`` puts back. Writes nothing to any servo.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_port, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser)
    parser.add_argument("--out", type=Path, metavar="FILE", required=True, help="a new .toml file")


def run(options: argparse.Namespace) -> ExitCode:
    """Back up."""
    from robot.bringup.servo.backup import BackupRequest, back_up

    return back_up(parsed(options, BackupRequest))
