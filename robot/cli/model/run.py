"""``bigant model run``: a named system through the model, as a table and a picture."""

import argparse
from pathlib import Path

from gaits.names import GAIT_NAMES
from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode

# spelled out here so that the parser imports nothing heavy; robot.study.systems knows how to build
SYSTEM_NAMES = ("bigant", "disk", "multipod", "quadruped", "stairs", "slither")
LAW_NAMES = ("viscous", "coulomb", "both")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("system", choices=SYSTEM_NAMES, metavar="SYSTEM",
                        help=", ".join(SYSTEM_NAMES))  # fmt: skip
    parser.add_argument(
        "--legs", type=int, metavar="N", help="legs of a disk or multipod, contacts of slither"
    )
    parser.add_argument("--gait", choices=GAIT_NAMES, help="of bigant (tripod)")
    parser.add_argument("--robot", type=Path, metavar="FILE", help="robot file of bigant")
    parser.add_argument("--cycles", type=float, metavar="N", help="length of the motion")
    parser.add_argument("--law", choices=LAW_NAMES, default="viscous", help="friction (viscous)")
    parser.add_argument("--tilt-coupling", action="store_true",
                        help="feet's vertical speed pushes a tilted body sideways")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE", help=".png or .html (model_SYSTEM.png)")
    parser.add_argument("--json", action="store_true",
                        help="print JSON; no picture without --out")  # fmt: skip


def run(options: argparse.Namespace) -> ExitCode:
    """Predict, print, draw."""
    from robot.study.model_run import ModelRunRequest, run_model

    return run_model(parsed(options, ModelRunRequest))
