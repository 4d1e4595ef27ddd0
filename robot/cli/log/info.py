"""``bigant log info``: what a log holds.

Duration, rate, ticks and missing ticks, topics, robot, gait, software versions and damage. Damage that was
stepped over makes the exit code 1.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_json
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="LOG")
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """List what a log holds."""
    from robot.report.log_files import info

    return info(options.path, as_json=options.json)
