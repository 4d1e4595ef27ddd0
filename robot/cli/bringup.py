"""``bigant bringup``: the first day with a real robot, step by step.

Thirteen numbered steps for a robot that hangs in a frame: who answers, what the servos keep, each leg by
ten degrees, torque, watchdog, reboots, the loop, the cable pulled, each foot pressed, the force unit's
console, one cycle in the air, one on the floor. Each step says what it will do, asks, keeps every byte,
judges, and is written to one page; the same command goes on where it stopped. What the steps settle about
the devices is written to measured.toml, a scenario file for virtual devices. Without --armed nothing moves.
Virtual devices (the default) bring a virtual person with them: the day runs through in virtual time.
docs/first_day.md is the page to hang beside the robot.
"""

import argparse
from pathlib import Path

from robot.console.arguments import (
    add_hardware,
    add_robot,
    add_scenario,
    add_virtual_robot,
    between,
    parsed,
    seed,
)
from robot.console.exit_codes import ExitCode

LAST_STEP = 13


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--folder", type=Path, default=Path("bringup"), metavar="FOLDER",
        help="state, page, logs and measured.toml (bringup)",
    )  # fmt: skip
    add_hardware(parser)
    parser.add_argument(
        "--force-unit",
        metavar="HOST[:UDP:CONSOLE]|none",
        help="wireless force-torque unit (robot file); none leaves it out",
    )
    add_robot(parser)
    parser.add_argument("--armed", action="store_true", help="torque may be switched on")
    parser.add_argument(
        "--yes", action="store_true", help="do not ask before steps that move and set nothing"
    )
    step = between(1, LAST_STEP, whole=True)
    parser.add_argument("--from", dest="begin", type=step, metavar="N", help="begin with this step")
    parser.add_argument("--only", type=step, metavar="N", help="do this step only")
    parser.add_argument("--list", action="store_true", help="list the steps and stop")
    parser.add_argument(
        "--seconds", type=between(1, 36000, "s"), metavar="S",
        help="how long the loop runs in step 8 (600; virtual: 10)",
    )  # fmt: skip
    parser.add_argument(
        "--reboots", type=between(1, 100, whole=True), metavar="N",
        help="reboots of each servo in step 7 (10; virtual: 3)",
    )  # fmt: skip
    add_virtual_robot(parser)
    add_scenario(parser)
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="of virtual devices")
    parser.add_argument(
        "--ask", action="store_true", help="virtual hardware: you answer, its hands are simulated"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Bring up."""
    from robot.bringup.first_day.bringup import BringupRequest, bring_up

    return bring_up(parsed(options, BringupRequest))
