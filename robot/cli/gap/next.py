"""``bigant gap next``: which run settles what a diagnosis left open.

Takes the JSON of a diagnosis (its runs must still be where they were), or runs, which are diagnosed
first. Each gait at several frequencies, straight and turning, and with a weight on the body, is played
through the simulator with each candidate; what is left of their difference after one is adjusted to the
other, in units of the noise, is the separation that the run would show. A separation of 22 decides with
one error in a hundred.
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("paths", type=Path, nargs="+", metavar="DIAGNOSIS.json|TRIAL")
    parser.add_argument("--reference", type=Path, nargs="+", default=[], metavar="TRIAL",
        help="with TRIAL: healthy runs of the same machine")  # fmt: skip
    parser.add_argument("--against", action="append", default=[], metavar="EFFECT[@LEG]",
        help="a candidate in place of the first cause, besides those left open")  # fmt: skip
    parser.add_argument("--robot", type=Path, metavar="FILE",
        help="robot file to use (default: the one that the runs name)")  # fmt: skip
    parser.add_argument("--effects", type=Path, metavar="FILE.py",
        help="effects of your own (run as Python: open only files that you trust)")  # fmt: skip
    parser.add_argument("--all", action="store_true", help="show all runs, not only 5")
    parser.add_argument("--json", action="store_true", help="all runs as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Propose runs."""
    from robot.gap_report.next import NextRequest, propose_runs

    return propose_runs(parsed(options, NextRequest))
