"""``bigant view --ros2``: what a log holds, or a live run writes, published as ROS 2 topics with rclpy.

A log holds its messages as ROS 2 serialises them, so their bytes go out as they are.
"""

import importlib
import sys
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Self

from drivers.clock import MonotonicClock
from model.errors import ConfigError
from record.log.cdr import CdrWriter
from record.log.follow import LogFollower
from record.log.reader import LogContents, TopicMessage, read_messages
from robot.console.exit_codes import ExitCode
from robot.console.program_output import complain
from robot.requests.recorded import ViewRequest
from robot.view.log_source import be_nice, followed, log_path, paced

QUEUE = 10
CLOCK_TOPIC, CLOCK_TYPE = "/clock", "rosgraph_msgs/msg/Clock"
# ROS expects these where they are, whatever a robot's own topics are put below.
GLOBAL = frozenset({"/tf", CLOCK_TOPIC})
OURS = "bigant_msgs"  # no package of ROS; the log keeps it


def publish(request: ViewRequest) -> ExitCode:
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
    with Ros2Publisher(request.prefix or "", clock=not request.live) as publisher:
        complain(f"publishing {path} as node /bigant_bridge; Ctrl-C ends")
        try:
            for message in _messages(path, request):
                publisher.publish(message)
                if not publisher.ok():
                    break
        except KeyboardInterrupt:
            print(file=sys.stderr)
        print(publisher.report())
    return ExitCode.OK


def _messages(path: Path, request: ViewRequest) -> Iterator[TopicMessage]:
    clock = MonotonicClock()
    if request.live:
        be_nice()
        with LogFollower(path) as follower:
            yield from followed(follower, clock)
        return
    contents = LogContents()
    yield from paced(read_messages(path, contents), lambda m: m.unix_ns, clock, request.speed)
    if contents.damage:
        complain(f"warning: {path}: {contents.damage}")


class Ros2Publisher:
    """A node with one publisher a topic, made when the topic first comes.

    Args:
        prefix: What topics are put below, empty for nothing.
        clock: Whether to publish the log's time as /clock, for nodes with ``use_sim_time``.
    """

    def __init__(self, prefix: str, *, clock: bool) -> None:
        self._ros: Any = importlib.import_module("rclpy")  # here, so that this module needs no ROS
        self._ros.init()
        self._node: Any = importlib.import_module("rclpy.node").Node("bigant_bridge")
        self._prefix = f"/{prefix.strip('/')}" if prefix.strip("/") else ""
        self._clock = clock
        self._publishers: dict[str, Any] = {}
        self._counts: Counter[str] = Counter()
        self._last_ns = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Destroy the node."""
        self._node.destroy_node()
        if self._ros.ok():
            self._ros.shutdown()

    def ok(self) -> bool:
        """Whether ROS still runs."""
        return bool(self._ros.ok())

    def publish(self, message: TopicMessage) -> None:
        """Publish a message; those of types that ROS does not have are left out.

        Raises:
            ConfigError: The message's package is not installed in this ROS.
        """
        if message.kind.startswith(OURS):
            return
        if self._clock and message.unix_ns != self._last_ns:
            self._last_ns = message.unix_ns
            self._put(CLOCK_TOPIC, CLOCK_TYPE, _clock(message.unix_ns))
        self._put(message.topic, message.kind, message.data)

    def _put(self, topic: str, kind: str, data: bytes) -> None:
        name = topic if topic in GLOBAL else self._prefix + topic
        if name not in self._publishers:
            self._publishers[name] = self._node.create_publisher(_message_class(kind), name, QUEUE)
        self._publishers[name].publish(data)
        self._counts[name] += 1

    def report(self) -> str:
        """Return what was published, a line a topic."""
        return "\n".join(f"{count:>8} x {name}" for name, count in sorted(self._counts.items()))


def _message_class(kind: str) -> Any:
    """Return the class of ``package/msg/Name``."""
    package, _, name = kind.replace("/msg/", "/").partition("/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError) as error:
        raise ConfigError(
            "ROS 2", f"has no {kind}; install the ROS package {package.replace('_', '-')}"
        ) from error


def _clock(unix_ns: int) -> bytes:
    """rosgraph_msgs/msg/Clock."""
    w = CdrWriter()
    w.record("iI", *divmod(unix_ns, 10**9))
    return w.done()
