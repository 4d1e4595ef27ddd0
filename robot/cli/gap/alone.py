"""``bigant gap alone``: how much of the gap an effect explains by itself, for example a delay.

Fits effects of the catalogue by least squares to the runs that the diagnosis would fit to, each by itself
(or several joined with +), and judges them on the held-out runs. It does not say what the cause is: it
shows what a decoy could have claimed, next to what ``bigant gap diagnose`` names.
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("trials", type=Path, nargs="+", metavar="TRIAL")
    parser.add_argument("--effect", action="append", default=[], metavar="NAME[+NAME...]",
        help="an effect, or several together; may be given again (default: every effect)")  # fmt: skip
    parser.add_argument("--joint", action="append", default=[], metavar="NAME",
        help="only this joint of a bench of servos; may be given again")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Fit and judge."""
    from robot.gap_report.alone import AloneRequest, fit_alone

    return fit_alone(parsed(options, AloneRequest))
