"""``bigant gap apply``: a diagnosis into a corrected robot file, and the gap measured again through it.

Causes that have a key of their own (links, mounts, springs, friction) change that key; all others go into
a table [effects], which drive, odom, sim, replay and gap read. All comments stay. Then the corrected file
is read back, and the held-out runs of the diagnosis are predicted with it: before and after are printed.
Exit code 1: the gap did not shrink.
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("diagnosis", type=Path, metavar="DIAGNOSIS.json")
    parser.add_argument("--robot", type=Path, metavar="FILE",
        help="robot file to correct (default: the one that the runs name)")  # fmt: skip
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE", help="the corrected file"
    )
    parser.add_argument("--anyway", action="store_true",
        help="apply the causes of a diagnosis that does not explain the gap, too")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="what was done as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Correct the robot file and measure again."""
    from robot.gap_report.apply import ApplyRequest, apply_diagnosis

    return apply_diagnosis(parsed(options, ApplyRequest))
