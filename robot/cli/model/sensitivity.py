"""``bigant model sensitivity``: naive against fitted parameters on logs (the paper's sec:tripod)."""

import argparse
import math
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.description = (
        "Fit stiffness and friction to the earlier half of a log (of several logs: to the first of "
        "them), and judge fitted against naive parameters on the rest."
    )
    parser.add_argument("logs", type=Path, nargs="+", metavar="LOG")
    parser.add_argument("--form", type=int, choices=(18, 24), default=18,
        help="18 parameters, w fore and aft, or 24, w free (default: 18)")  # fmt: skip
    parser.add_argument("--law", choices=("viscous", "coulomb"), default="viscous",
        help="the paper's viscous ansatz or Coulomb's law (default: viscous)")  # fmt: skip
    parser.add_argument("--rest-mm-s", type=_speed, default=1.0, metavar="V",
        help="leave feet no faster than this out of the friction fit (default: 1)")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE.png", help="draw the changes as well")
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def _speed(text: str) -> float:
    value = float(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"must be a speed, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Fit, judge, print and draw."""
    from robot.study.sensitivity import SensitivityRequest, judge_sensitivity

    return judge_sensitivity(parsed(options, SensitivityRequest))
