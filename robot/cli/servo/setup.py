"""``bigant servo setup``: bring servos into the settings of the robot file.

Shows what differs in each servo's memory before anything is written (id, baud rate, return delay,
operating mode, homing offset, limits, shutdown), asks, writes, reads back, and talks at the new baud
rate. Refuses servos with torque on, and two servos with one id. A servo with an id that the robot
file does not know gets the one that is missing, if it is the only one; otherwise connect one at a time.
"""

import argparse

from robot.console.arguments import add_port, add_robot, baud_rate, parsed, servo_id
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser)
    add_robot(parser)
    parser.add_argument("--id", type=servo_id, metavar="N", help="this servo only")
    parser.add_argument("--new-id", type=servo_id, metavar="M", help="the id it is to have")
    parser.add_argument(
        "--new-baud", type=baud_rate, metavar="B", help="the baud rate to have (robot file)"
    )
    parser.add_argument("--yes", action="store_true", help="write without being asked")


def run(options: argparse.Namespace) -> ExitCode:
    """Set servos up."""
    from robot.bringup.servo.setup import SetupRequest, set_up

    return set_up(parsed(options, SetupRequest))
