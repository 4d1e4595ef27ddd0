"""``bigant log cut``: a piece of a log.

Times stay those of the run, so the piece begins at --from; pieces of one log can be merged again.
"""

import argparse
from pathlib import Path

from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
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
    """Cut a piece out of a log.

    Raises:
        RecordError: The span is empty, or a file cannot be read or written.
    """
    from record.log.salvage import Pass
    from record.log.splice import cut_log
    from robot.cli.log.repair import print_damage
    from robot.console.progress import ProgressLine

    progress = Pass()
    with ProgressLine(f"reading {options.path}", progress):
        done = cut_log(
            options.path, options.out, from_s=options.from_s, to_s=options.to_s, progress=progress
        )
    print_damage(options.path, done.damages)
    print(f"{options.out}: {done.kept} messages")
    return ExitCode.OK
