"""``bigant log merge``: logs of one robot, one behind the other.

They are put in order of time, gaps between them stay, and logs that overlap are refused.
"""

import argparse
from pathlib import Path

from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("paths", type=Path, nargs="+", metavar="LOG")
    parser.add_argument("--out", type=Path, metavar="FILE", required=True, help="new log")


def run(options: argparse.Namespace) -> ExitCode:
    """Merge logs."""
    from robot.report.log_files import merge

    return merge(tuple(options.paths), options.out)
