"""``bigant check``: the pre-flight list. Is this robot fit to walk?

Only asks, except with --armed (and on virtual hardware), where torque goes on at the measured
positions to prove that the servos' own watchdog stops them; nothing is told to move.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_hardware, add_json, add_robot, between, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_hardware(parser)
    parser.add_argument(
        "--force-unit",
        metavar="HOST[:UDP:CONSOLE]|none",
        help="wireless force-torque unit (robot file); none leaves it out",
    )
    add_robot(parser)
    parser.add_argument(
        "--armed", action="store_true", help="torque on, holding still, to prove the watchdog"
    )
    parser.add_argument(
        "--loop",
        type=between(0.5, 3600, "s"),
        nargs="?",
        const=10.0,
        metavar="S",
        help="also run the loop without torque and say how late it is (10 s)",
    )
    add_json(parser)
    parser.add_argument("--html", type=Path, metavar="FILE", help="the list as one page, to keep")


def run(options: argparse.Namespace) -> ExitCode:
    """Check."""
    from robot.bringup.preflight.check import CheckRequest, check

    return check(parsed(options, CheckRequest))
