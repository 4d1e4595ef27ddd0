"""``bigant log merge``: logs of one robot, one behind the other.

They are put in order of time, gaps between them stay, and logs that overlap are refused.
"""

import argparse
from pathlib import Path

from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("paths", type=Path, nargs="+", metavar="LOG")
    parser.add_argument("--out", type=Path, metavar="FILE", required=True, help="new log")


def run(options: argparse.Namespace) -> ExitCode:
    """Merge logs.

    Raises:
        RecordError: They do not fit, or a file cannot be read or written.
    """
    from record.log.salvage import Pass
    from record.log.splice import merge_logs
    from robot.cli.log.repair import print_damage
    from robot.console.progress import ProgressLine

    progress = Pass()
    with ProgressLine(f"writing {options.out}", progress):
        done = merge_logs(tuple(options.paths), options.out, progress)
    print_damage(options.out, done.damages)
    print(f"{options.out}: {done.kept} messages of {len(options.paths)} logs")
    return ExitCode.OK
