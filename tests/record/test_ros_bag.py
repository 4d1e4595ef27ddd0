"""ROS 2 bags written by rosbags come in as runs: joints, poses, transforms, forces, on their own stamps."""

import math
import random
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from benchmarks.fuzz.damage import damaged
from model.errors import RecordError
from record.trial.column_map import read_column_map
from record.trial.import_run import import_run
from record.trial.import_table import ImportReport
from record.trial.ros_bag import BagMap, is_bag, open_bag, with_topics
from record.trial.trial import Trial

STORE = get_typestore(Stores.ROS2_HUMBLE)
START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 10_000_000
SAMPLES = 60
MAP = '[bag]\njoints = "/js"\npose = "/tf"\nframes = ["map", "base"]\n[trial]\nlegs = ["L", "R"]\n'


def kind(name: str) -> Any:
    return STORE.types[name]


def head(ns: int, frame: str = "") -> Any:
    stamp = kind("builtin_interfaces/msg/Time")(ns // 10**9, ns % 10**9)
    return kind("std_msgs/msg/Header")(stamp, frame)


def point(*xyz: float, name: str = "Point") -> Any:
    return kind(f"geometry_msgs/msg/{name}")(*xyz)


def quaternion(yaw: float) -> Any:
    return kind("geometry_msgs/msg/Quaternion")(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))


def joint_state(
    ns: int, names: Sequence[str], angles: Sequence[float], speeds: Sequence[float] = ()
) -> Any:
    nothing = np.zeros(0)
    return kind("sensor_msgs/msg/JointState")(
        head(ns), list(names), np.array(angles, float), np.array(speeds, float), nothing
    )


class BagWriter:
    def __init__(self, writer: Writer) -> None:
        self._writer, self._topics = writer, {}  # type: ignore[var-annotated]

    def put(self, topic: str, ns: int, message: Any) -> None:
        name = message.__msgtype__
        if topic not in self._topics:
            self._topics[topic] = self._writer.add_connection(topic, name, typestore=STORE)
        self._writer.write(self._topics[topic], ns, STORE.serialize_cdr(message, name))


@contextmanager
def writing(path: Path, plugin: StoragePlugin = StoragePlugin.SQLITE3) -> Iterator[BagWriter]:
    with Writer(path, version=9, storage_plugin=plugin) as writer:
        yield BagWriter(writer)


def write_run(path: Path, plugin: StoragePlugin = StoragePlugin.SQLITE3) -> None:
    """Two joints in changing order, a transform at a third of their rate and 4 ms later, one force."""
    names: tuple[str, ...] = ("left", "right")
    with writing(path, plugin) as bag:
        for k in range(SAMPLES):
            ns, t_s = START_NS + k * PERIOD_NS, k * PERIOD_NS * 1e-9
            angles: tuple[float, ...] = (2 * t_s, -3 * t_s)
            order = slice(None, None, -1 if k % 2 else 1)
            bag.put("/js", ns, joint_state(ns, names[order], angles[order]))
            bag.put("/wrench/L", ns, kind("geometry_msgs/msg/WrenchStamped")(
                head(ns), kind("geometry_msgs/msg/Wrench")(
                    point(1.0, 2.0, k, name="Vector3"), point(0.0, 0.0, 0.0, name="Vector3"))))  # fmt: skip
            if k % 3 == 0:
                later = ns + 4_000_000
                where = t_s + 0.004
                each = [
                    kind("geometry_msgs/msg/TransformStamped")(
                        head(later, parent), child, kind("geometry_msgs/msg/Transform")(
                            point(x, 0.0, 0.1, name="Vector3"), quaternion(0.5 * where)))
                    for parent, child, x in (("map", "base", where), ("map", "other", 99.0))
                ]  # fmt: skip
                bag.put("/tf", later, kind("tf2_msgs/msg/TFMessage")(each))


def brought(path: Path, column_map: str, folder: Path) -> tuple[Trial, ImportReport]:
    (folder / "map.toml").write_text(column_map)
    (one,) = import_run(path, read_column_map(folder / "map.toml"))
    assert one.trial is not None
    return one.trial, one.report


@pytest.mark.parametrize("plugin", [StoragePlugin.SQLITE3, StoragePlugin.MCAP])
def test_joints_transforms_and_forces_come_together_on_the_joints_times(
    plugin: StoragePlugin, tmp_path: Path
) -> None:
    write_run(tmp_path / "bag", plugin)
    assert is_bag(tmp_path / "bag")
    trial, report = brought(
        tmp_path / "bag", MAP + '[bag.names]\nL = "left"\nR = "right"\n', tmp_path
    )
    t_s = np.arange(SAMPLES) * PERIOD_NS * 1e-9
    np.testing.assert_allclose(trial.time_s - START_NS * 1e-9, t_s, atol=1e-6)
    np.testing.assert_allclose(trial.shaft_rad, np.outer(t_s, [2, -3]), atol=1e-12)
    np.testing.assert_allclose(trial.shaft_rad_s, np.tile([2.0, -3.0], (SAMPLES, 1)), rtol=1e-5)
    np.testing.assert_array_equal(trial.force_n[:, 0, 2], np.arange(SAMPLES))
    known = np.isfinite(trial.body_position_m[:, 0])
    assert known.sum() >= SAMPLES - 4  # none before the first, none behind the last
    np.testing.assert_allclose(trial.body_position_m[known, 0], t_s[known], atol=1e-6)
    np.testing.assert_allclose(trial.body_angles_rad[known, 2], 0.5 * t_s[known], atol=1e-6)
    read = {f.column for f in report.findings if f.kind == "read"}
    assert read == {"/js", "/tf", "/wrench/L"}
    assert any(f.kind == "derived" for f in report.findings)


def test_without_a_map_what_can_only_be_one_thing_is_taken_by_the_bag_s_own_names(
    tmp_path: Path,
) -> None:
    with writing(tmp_path / "bag") as bag:
        for k in range(30):
            ns = START_NS + k * PERIOD_NS
            bag.put("/joint_states", ns, joint_state(ns, ["a", "b"], [k, 2 * k], [3.0, 4.0]))
            bag.put("/goal/joints", ns, joint_state(ns, ["a", "b"], [k, k]))
            estimate = kind("nav_msgs/msg/Odometry")
            cov = np.zeros(36)
            pose = kind("geometry_msgs/msg/Pose")(point(k, 0.0, 0.0), quaternion(0.0))
            twist = kind("geometry_msgs/msg/Twist")(
                point(0.0, 0.0, 0.0, name="Vector3"), point(0.0, 0.0, 0.0, name="Vector3")
            )
            for topic in ("/odom", "/vicon/body"):
                bag.put(topic, ns, estimate(
                    head(ns), "base",
                    kind("geometry_msgs/msg/PoseWithCovariance")(pose, cov),
                    kind("geometry_msgs/msg/TwistWithCovariance")(twist, cov)))  # fmt: skip
    trial, report = brought(tmp_path / "bag", "", tmp_path)
    assert trial.joints == ("a", "b")
    np.testing.assert_array_equal(trial.command_rad[:, 1], np.arange(30))
    np.testing.assert_array_equal(trial.shaft_rad_s[:, 1], np.full(30, 4.0))
    np.testing.assert_allclose(trial.body_position_m[:, 0], np.arange(30))
    # an estimate is no truth
    assert "/odom" in {f.column for f in report.findings if f.kind == "ignored"}


def test_a_column_map_goes_before_the_topics_and_may_turn_signs(tmp_path: Path) -> None:
    write_run(tmp_path / "bag")
    columns = (
        '[columns]\nshaft_L_rad = { from = "/js:position[left]", sign = -1, offset = 0.5 }\n'
        '[trial]\nlegs = ["L"]\n'
    )
    trial, _ = brought(tmp_path / "bag", columns, tmp_path)
    t_s = np.arange(SAMPLES) * PERIOD_NS * 1e-9
    np.testing.assert_allclose(trial.shaft_rad[:, 0], 0.5 - 2 * t_s, atol=1e-12)


def test_only_the_topics_that_are_asked_for_are_taken_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_run(tmp_path / "bag")
    read: list[str] = []
    with open_bag(tmp_path / "bag") as bag:
        whole = bag._reader.deserialize

        def noted(data: bytes, name: str) -> Any:
            read.append(name)
            return whole(data, name)

        monkeypatch.setattr(bag._reader, "deserialize", noted)
        assert bag.table(bag.topic("/js")).rows == SAMPLES
    assert set(read) == {"sensor_msgs/msg/JointState"}


@pytest.mark.parametrize(
    ("column_map", "words"),
    [
        (MAP.replace("/js", "/jx"), "has no topic /jx; of the types that are read it has /js (JointState)"),
        (MAP, "no joint on /js is called as ours (L, R); it has left, right"),
        (MAP + '[bag.names]\nL = "lefft"\n', "/js has no joint lefft; it has left, right"),
        (MAP.replace('"base"', '"foot"') + '[bag.names]\nL = "left"\n', "no messages for map -> foot"),
        ('[bag]\njoints = "/wrench/L"\n[trial]\nlegs = ["L"]\n', "WrenchStamped, no JointState"),
        (
            MAP.replace('frames = ["map", "base"]\n', "") + '[bag.names]\nL = "left"\n',
            "holds map -> base, map -> other; say which",
        ),
        ("[bag]\njoint = 3\n", "bag.joint: is not a known key"),
    ],
)  # fmt: skip
def test_a_map_that_does_not_fit_says_what_the_bag_has(
    column_map: str, words: str, tmp_path: Path
) -> None:
    write_run(tmp_path / "bag")
    with pytest.raises(RecordError) as raised:
        brought(tmp_path / "bag", column_map, tmp_path)
    assert words in str(raised.value)


def test_two_topics_that_could_be_meant_are_asked_about(tmp_path: Path) -> None:
    with writing(tmp_path / "bag") as bag:
        for topic in ("/arm", "/leg"):
            bag.put(topic, START_NS, joint_state(START_NS, ["a"], [1.0]))
    with pytest.raises(RecordError, match=r"joints of .* could be /arm, /leg; say which"):
        brought(tmp_path / "bag", "", tmp_path)


def test_a_file_that_is_no_bag_and_a_wrong_option_are_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.mcap").write_bytes(b"no mcap at all")
    with pytest.raises(RecordError, match="cannot be read as a ROS 2 bag"):
        next(import_run(tmp_path / "bad.mcap", read_column_map_of(tmp_path)))
    with pytest.raises(Exception, match="'joint=/a' is none of joints="):
        with_topics(BagMap(), "joint=/a")
    assert with_topics(BagMap(), "joints=/a, force_HL=/w").forces == {"HL": "/w"}


@pytest.mark.parametrize("plugin", StoragePlugin)
@pytest.mark.parametrize("damages", [4, pytest.param(25, marks=pytest.mark.thorough)])
def test_whatever_is_damaged_in_a_bag_is_one_error(
    damages: int, tmp_path: Path, plugin: StoragePlugin
) -> None:
    write_run(tmp_path / "bag", plugin)
    source = random.Random(7)
    outcomes = set()
    for path in sorted((tmp_path / "bag").iterdir()):
        good = path.read_bytes()
        for _ in range(damages):
            path.write_bytes(damaged(good, source))
            try:
                with open_bag(tmp_path / "bag") as bag:
                    bag.table(bag.topic("/js"))
            except RecordError:
                outcomes.add("refused")
            else:
                outcomes.add("read")
        path.write_bytes(
            b"a: " + b"[" * 1_000 if path.suffix == ".yaml" else good[: len(good) // 2]
        )
        with (
            pytest.raises(RecordError, match="cannot be read as a ROS 2 bag"),
            open_bag(tmp_path / "bag") as bag,
        ):
            bag.table(bag.topic("/js"))
        path.write_bytes(good)
    assert outcomes == {"refused", "read"}


def read_column_map_of(folder: Path) -> Any:
    (folder / "map.toml").write_text("")
    return read_column_map(folder / "map.toml")


def test_without_rosbags_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("rosbags", "rosbags.highlevel", "rosbags.typesys"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(RecordError, match=r"needs rosbags.*'\.\[bags\]'"), open_bag(tmp_path):
        pass
