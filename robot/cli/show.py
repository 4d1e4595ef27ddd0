"""``bigant show``: what a log says, as a table and as pictures.

Print a summary of a log (distance, speed, slip, faults, loop) and write a page with trajectory, body
velocity and foot forces, predicted against measured.
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help=".html or .png (default: next to the log, .html)"
    )
    parser.add_argument("--json", action="store_true", help="the summary as JSON, no picture")


def run(options: argparse.Namespace) -> ExitCode:
    """Show a log."""
    return show(options)


def show(options: argparse.Namespace) -> ExitCode:
    """Summarise a log and draw it."""
    from robot.report.show import ShowRequest, show_log

    return show_log(parsed(options, ShowRequest))
