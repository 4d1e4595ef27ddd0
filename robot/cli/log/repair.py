"""``bigant log repair``: a proper file of a cut or damaged log.

Everything that can be read goes into a new file with index and summary; the old file is not touched.
"""

import argparse
from pathlib import Path

from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="new log (default: LOG.repaired.mcap next to it)"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Repair a log."""
    from robot.report.log_files import repair

    return repair(options.path, options.out)
