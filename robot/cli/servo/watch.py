"""``bigant servo watch``: position, speed, current, voltage, temperature and errors, live.

Only listens. A table that is redrawn on a terminal, one table a second anywhere else; at the end
histograms of round trip and jitter and what went wrong on the wire. Ctrl-C ends it.
"""

import argparse

from robot.console.arguments import add_json, add_port, add_robot, between, parsed, positive
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser, baud="baud rate (robot file)")
    add_robot(parser)
    parser.add_argument("--seconds", type=positive, metavar="S", help="how long (until Ctrl-C)")
    parser.add_argument(
        "--rate-hz",
        type=between(1, 500, "Hz", whole=True),
        metavar="R",
        default=50,
        help="reads a second (50)",
    )
    add_json(parser, "last readings and counts")


def run(options: argparse.Namespace) -> ExitCode:
    """Watch."""
    from robot.bringup.servo.watch import WatchRequest, watch_servos

    return watch_servos(parsed(options, WatchRequest))
