"""``bigant sim serve``: virtual devices on a pseudo-terminal and loopback sockets until Ctrl-C.

Serve a virtual robot that any Dynamixel or WNet program can talk to, and print where to find it. Ctrl-C
ends it.
"""

import argparse

from robot.console.arguments import add_robot, add_scenario, baud_rate, parsed, seed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_robot(parser)
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of virtual noise")
    parser.add_argument("--baud", type=baud_rate, metavar="B", help="baud rate of the servos")
    parser.add_argument(
        "--absent", type=int, action="append", default=[], metavar="ID", help="a servo to leave out"
    )
    parser.add_argument("--no-force-unit", action="store_true", help="leave out the force unit")
    add_scenario(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Serve."""
    from robot.virtual.serve import ServeRequest, serve_robot

    return serve_robot(parsed(options, ServeRequest))
