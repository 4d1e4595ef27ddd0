"""``bigant servo zero``: the servo_zero line of the robot file.

Turn every shaft by hand to shaft angle 0 (mid-stance), torque off, and run it. Takes the median of
several readings, refuses shafts that move, and prints the line for the robot file. --robot-out writes a
copy of the robot file with these zeros in it, --write a record of them with servo ids and models. No
file that exists is ever changed.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_json, add_port, add_robot, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser, baud="baud rate (robot file)")
    add_robot(parser)
    parser.add_argument(
        "--robot-out", type=Path, metavar="FILE", help="the robot file with these zeros"
    )
    parser.add_argument(
        "--write", type=Path, metavar="FILE", help="zeros, servo ids, models (.toml)"
    )
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Measure the zeros."""
    from robot.bringup.servo.zero import ZeroRequest, zero

    return zero(parsed(options, ZeroRequest))
