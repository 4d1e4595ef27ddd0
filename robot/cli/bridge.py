"""``bigant bridge``: a live run or a log as ROS 2 topics.

Publishes what the log holds under its own names and types: joint states and commands, a wrench a foot
(measured and predicted), odometry, truth, transforms and diagnostics, frames after REP-105, units and axes
after REP-103. Needs a shell in which ROS 2 is set up. A run is followed by reading its log, so it cannot be
commanded or disturbed from ROS. See docs/ros2.md.
"""

import argparse
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from typing import TYPE_CHECKING

from model.errors import ConfigError
from robot.console.exit_codes import ExitCode
from robot.view.log_source import add_source, be_nice, followed, log_path, paced

if TYPE_CHECKING:
    from pathlib import Path

    from drivers.clock import Clock
    from record.log.reader import TopicMessage


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_source(parser)
    parser.add_argument(
        "--prefix", default="", metavar="NAME", help="put all topics but /tf and /clock below it"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Publish until the log or the operator ends.

    Raises:
        ConfigError: There is no ROS 2 here.
        RecordError: The log cannot be read.
    """
    from drivers.clock import MonotonicClock

    path = log_path(options)
    if find_spec("rclpy") is None:
        raise ConfigError(
            "ROS 2",
            "rclpy cannot be imported; set up ROS 2 in this shell (source /opt/ros/DISTRO/setup.sh) "
            "with the Python it was built for, or open the log without ROS (see docs/ros2.md)",
        )
    from robot.view.ros2_publisher import Ros2Publisher

    with Ros2Publisher(options.prefix, clock=not options.live) as publisher:
        print(f"publishing {path} as node /bigant_bridge; Ctrl-C ends", file=sys.stderr)
        try:
            for message in _messages(path, options, MonotonicClock()):
                publisher.publish(message)
                if not publisher.ok():
                    break
        except KeyboardInterrupt:
            print(file=sys.stderr)
        print(publisher.report())
    return ExitCode.OK


def _messages(
    path: "Path", options: argparse.Namespace, clock: "Clock"
) -> "Iterator[TopicMessage]":
    from record.log.follow import LogFollower
    from record.log.reader import LogContents, read_messages

    if options.live:
        be_nice()
        with LogFollower(path) as follower:
            yield from followed(follower, clock)
        return
    contents = LogContents()
    yield from paced(read_messages(path, contents), lambda m: m.unix_ns, clock, options.speed)
    if contents.damage:
        print(f"warning: {path}: {contents.damage}", file=sys.stderr)
