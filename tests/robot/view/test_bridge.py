"""``bigant view --ros2``: what a stand-in for rclpy is given, decoded by somebody else's ROS library."""

import sys
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from record.log.blocks.read import read_log
from robot.cli import main as cli
from robot.console.exit_codes import ExitCode
from robot.view import bridge
from tests.robot.view.test_view_command import _WritingClock

STORE = get_typestore(Stores.ROS2_HUMBLE)


class Ros:
    """What rclpy was asked to do, in order."""

    def __init__(self) -> None:
        self.published: dict[str, list[bytes]] = defaultdict(list)
        self.kinds: dict[str, str] = {}
        self.running = False
        self.nodes: list[str] = []
        self.stop_after = sys.maxsize

    def decoded(self, topic: str) -> list[Any]:
        return [STORE.deserialize_cdr(data, self.kinds[topic]) for data in self.published[topic]]


@pytest.fixture
def ros(monkeypatch: pytest.MonkeyPatch) -> Ros:
    """A module rclpy, and the message packages, that note what comes."""
    world = Ros()

    class Publisher:
        def __init__(self, topic: str) -> None:
            self.topic = topic

        def publish(self, message: object) -> None:
            assert isinstance(message, bytes), "rclpy takes serialised messages as bytes"
            world.published[self.topic].append(message)
            world.stop_after -= 1

    class Node:
        def __init__(self, name: str) -> None:
            assert world.running, "init comes first"
            world.nodes.append(name)

        def create_publisher(self, kind: type, topic: str, qos: int) -> Publisher:
            assert topic not in world.kinds, "one publisher a topic"
            assert qos > 0
            world.kinds[topic] = f"{kind.__module__.replace('.', '/')}/{kind.__name__}"
            return Publisher(topic)

        def destroy_node(self) -> None:
            world.nodes.clear()

    def set_running(value: bool) -> Callable[[], None]:
        return lambda: setattr(world, "running", value)

    def module(name: str, **content: object) -> None:
        made = ModuleType(name)
        made.__spec__ = __import__("importlib.machinery").machinery.ModuleSpec(name, None)
        vars(made).update(content)
        monkeypatch.setitem(sys.modules, name, made)

    module(
        "rclpy",
        init=set_running(True),
        shutdown=set_running(False),
        ok=lambda: world.running and world.stop_after > 0,
    )
    module("rclpy.node", Node=Node)
    packages = {
        "sensor_msgs": ("JointState",),
        "geometry_msgs": ("WrenchStamped",),
        "nav_msgs": ("Odometry",),
        "tf2_msgs": ("TFMessage",),
        "diagnostic_msgs": ("DiagnosticArray",),
        "rosgraph_msgs": ("Clock",),
    }
    for package, kinds in packages.items():
        module(package)
        classes = {kind: type(kind, (), {"__module__": f"{package}.msg"}) for kind in kinds}
        module(f"{package}.msg", **classes)
    return world


def test_a_log_is_published_as_it_is(
    short_walk: Path, ros: Ros, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["view", "--ros2", str(short_walk), "--speed", "1000"]) == ExitCode.OK
    log = read_log(short_walk)
    joints = ros.decoded("/joint_states")
    assert len(joints) == len(log.t_s)
    assert tuple(joints[-1].name) == log.names
    np.testing.assert_array_equal(joints[-1].position, log.angle_rad[-1])
    force = ros.decoded("/wrench/FR")[-1].wrench.force
    np.testing.assert_array_equal([force.x, force.y, force.z], log.force_n[-1, 5])
    times = [c.clock.sec * 10**9 + c.clock.nanosec for c in ros.decoded("/clock")]
    assert len(times) == len(log.t_s)
    assert times == sorted(set(times))
    assert "/bigant/tick" not in ros.published
    assert not ros.running
    assert not ros.nodes
    assert f"{len(log.t_s):>8} x /joint_states" in capsys.readouterr().out


def test_frames_are_those_of_rep_105(cycle_walk: Path, ros: Ros) -> None:
    assert cli.run(["view", "--ros2", str(cycle_walk), "--speed", "1000"]) == ExitCode.OK
    odom, truth = ros.decoded("/odom")[-1], ros.decoded("/odom_truth")[-1]
    assert (odom.header.frame_id, odom.child_frame_id) == ("odom", "base_link")
    assert (truth.header.frame_id, truth.child_frame_id) == ("map", "base_link")
    (transform,) = ros.decoded("/tf")[-1].transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "base_link")
    q = transform.transform.rotation
    assert np.isclose(q.x**2 + q.y**2 + q.z**2 + q.w**2, 1)
    assert ros.decoded("/wrench/HL")[0].header.frame_id == "base_link"
    moved = ros.decoded("/odom_truth")
    assert moved[-1].pose.pose.position.x > moved[0].pose.pose.position.x, "forward is +x"


def test_a_prefix_leaves_transforms_where_they_are(short_walk: Path, ros: Ros) -> None:
    assert (
        cli.run(["view", "--ros2", str(short_walk), "--speed", "1000", "--prefix", "/lab1/"])
        == ExitCode.OK
    )
    assert {"/lab1/joint_states", "/lab1/odom", "/tf", "/clock"} <= set(ros.published)
    assert "/odom" not in ros.published


def test_a_live_run_is_followed_without_a_clock_of_its_own(
    short_walk: Path, ros: Ros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = short_walk.read_bytes()
    growing = tmp_path / "now.mcap"
    growing.write_bytes(data[:50_000])
    clock = _WritingClock(data[50_000:], growing)
    monkeypatch.setattr("robot.view.bridge.MonotonicClock", lambda: clock)
    monkeypatch.setattr(bridge, "be_nice", lambda: None)
    assert cli.run(["view", "--ros2", str(growing), "--live"]) == ExitCode.OK
    assert len(ros.published["/odom"]) == len(read_log(short_walk).t_s)
    assert "/clock" not in ros.published


def test_when_ros_shuts_down_the_bridge_ends(short_walk: Path, ros: Ros) -> None:
    ros.stop_after = 50
    assert cli.run(["view", "--ros2", str(short_walk), "--speed", "1000"]) == ExitCode.OK
    assert sum(map(len, ros.published.values())) <= 52


def test_an_absent_message_package_is_named(
    short_walk: Path, ros: Ros, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "rosgraph_msgs.msg", None)
    assert cli.run(["view", "--ros2", str(short_walk)]) == ExitCode.USAGE
    assert "install the ROS package rosgraph-msgs" in capsys.readouterr().err
    assert not ros.running


def test_without_ros_it_is_said_what_to_do(
    short_walk: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if "rclpy" in sys.modules:
        pytest.skip("there is a ROS here")
    assert cli.run(["view", "--ros2", str(short_walk)]) == ExitCode.USAGE
    printed = capsys.readouterr().err
    assert "rclpy cannot be imported" in printed
    assert "docs/ros2.md" in printed
    assert len(printed.splitlines()) == 1
