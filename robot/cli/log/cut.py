"""``bigant log cut``: a piece of a log.

Times stay those of the run, so the piece begins at --from; pieces of one log can be merged again.
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument(
        "--from", type=float, default=float("-inf"), metavar="S", dest="from_s",
        help="first second kept (default: the beginning)",
    )  # fmt: skip
    parser.add_argument(
        "--to", type=float, default=float("inf"), metavar="S", dest="to_s",
        help="first second not kept (default: the end)",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE", required=True, help="new log")


def run(options: argparse.Namespace) -> ExitCode:
    """Cut a piece out of a log."""
    from robot.report.log_files import CutRequest, cut

    return cut(parsed(options, CutRequest))
