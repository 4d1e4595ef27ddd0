"""``bigant bridge``: what a log holds, or a live run writes, published as ROS 2 topics."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from drivers.clock import MonotonicClock
from model.errors import ConfigError
from record.log.follow import LogFollower
from record.log.reader import LogContents
from record.log.topic_reader import TopicMessage, stored_messages
from robot.console.exit_codes import ExitCode
from robot.view.log_source import be_nice, followed, log_path, paced
from robot.view.ros2_publisher import Ros2Publisher


@dataclass(frozen=True, slots=True)
class BridgeRequest:
    """Options of ``bigant bridge``."""

    path: Path | None
    live: bool
    speed: float
    prefix: str


def bridge(request: BridgeRequest) -> ExitCode:
    """Publish until the log or the operator ends.

    Raises:
        ConfigError: There is no ROS 2 here.
        RecordError: The log cannot be read.
    """
    path = log_path(request.path, live=request.live)
    if find_spec("rclpy") is None:
        raise ConfigError(
            "ROS 2",
            "rclpy cannot be imported; set up ROS 2 in this shell (source /opt/ros/DISTRO/setup.sh) "
            "with the Python it was built for, or open the log without ROS (see docs/ros2.md)",
        )
    with Ros2Publisher(request.prefix, clock=not request.live) as publisher:
        print(f"publishing {path} as node /bigant_bridge; Ctrl-C ends", file=sys.stderr)
        try:
            for message in _messages(path, request):
                publisher.publish(message)
                if not publisher.ok():
                    break
        except KeyboardInterrupt:
            print(file=sys.stderr)
        print(publisher.report())
    return ExitCode.OK


def _messages(path: Path, request: BridgeRequest) -> Iterator[TopicMessage]:
    clock = MonotonicClock()
    if request.live:
        be_nice()
        with LogFollower(path) as follower:
            yield from followed(follower, clock)
        return
    contents = LogContents()
    yield from paced(stored_messages(path, contents), lambda m: m.unix_ns, clock, request.speed)
    if contents.damage:
        print(f"warning: {path}: {contents.damage}", file=sys.stderr)
