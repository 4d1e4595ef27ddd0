"""``bigant servo jog``: turn one leg a little and back, and find wrong ids, signs and zeros.

For a robot that hangs in a frame, feet in the air. Only the servo that the robot file gives to the leg gets
torque, for about three seconds; every goal goes through the safety gate. Afterwards it asks which leg
moved and which way its foot went, and says which line of the robot file is to be changed to what. On real
hardware it needs --armed. --virtual-robot is a virtual robot that differs from the robot file.
"""

import argparse

from robot.console.arguments import (
    add_hardware,
    add_json,
    add_robot,
    add_virtual_robot,
    between,
    parsed,
)
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_hardware(parser)
    add_robot(parser)
    add_virtual_robot(parser)
    parser.add_argument(
        "--leg", default="all", metavar="LEG|all", help="leg to turn (all, in turn)"
    )
    parser.add_argument(
        "--deg", type=between(-20, 20, "deg"), default=10.0, metavar="A", help="how far (10 deg)"
    )
    parser.add_argument("--armed", action="store_true", help="torque may be switched on")
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Turn."""
    from robot.bringup.mapping.jog import JogRequest, jog

    return jog(parsed(options, JogRequest))
