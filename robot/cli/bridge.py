"""``bigant bridge``: a live run or a log as ROS 2 topics.

Publishes what the log holds under its own names and types: joint states and commands, a wrench a foot
(measured and predicted), odometry, truth, transforms and diagnostics, frames after REP-105, units and axes
after REP-103. Needs a shell in which ROS 2 is set up. A run is followed by reading its log, so it cannot be
commanded or disturbed from ROS. See docs/ros2.md.
"""

import argparse

from robot.console.arguments import add_source, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_source(parser)
    parser.add_argument(
        "--prefix", default="", metavar="NAME", help="put all topics but /tf and /clock below it"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Publish."""
    from robot.view.bridge import BridgeRequest, bridge

    return bridge(parsed(options, BridgeRequest))
