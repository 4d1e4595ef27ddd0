"""ROS 2 bags as tables: joint states, poses, odometry, transforms and wrenches, a table a topic.

    [bag]
    joints = "/joint_states"            # sensor_msgs/JointState
    commands = "/joint_commands"        # the same, or left out
    pose = "/mocap/robot/pose"          # PoseStamped, PoseWithCovarianceStamped, Odometry
    frames = ["map", "base_link"]       # where pose is a topic of transforms: parent and child
    forces = { HL = "/wrench/HL" }      # WrenchStamped of each leg
    imu = "/imu/data"                   # sensor_msgs/Imu, or left out
    names = { HL = "hind_left_crank" }  # our joint to the bag's, where they differ

What is not said is taken where only one topic can be meant. A column is called TOPIC:FIELD, so that
[columns] can name it: ``shaft_HL_rad = { from = "/joint_states:position[crank]", sign = -1 }``.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from model.errors import ConfigError, RecordError
from model.parameters.toml_table import Table
from record.trial.foreign_file import foreign_file
from record.trial.table_file import DataTable, TableColumn

BAG_SUFFIXES = (".mcap", ".db3")
JOINT_STATE = "sensor_msgs/msg/JointState"
IMU_MESSAGE = "sensor_msgs/msg/Imu"
WRENCH = "geometry_msgs/msg/WrenchStamped"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
POSE, POSE_COVARIANCE = (
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
)
ODOMETRY = "nav_msgs/msg/Odometry"
POSES = (POSE, POSE_COVARIANCE, ODOMETRY, TRANSFORMS)
READ = (JOINT_STATE, WRENCH, IMU_MESSAGE, *POSES)
# Words in the name of a topic of odometry that is no estimate but the truth.
TRUE_WORDS = ("truth", "mocap", "vicon", "optitrack", "qualisys", "ground")
IMU_FIELDS = (
    ("imu_yaw_rate_rad_s", "angular_velocity.z"),
    *((f"imu_quaternion_{axis}", f"orientation.{axis}") for axis in "xyzw"),
)
NO_NAMES: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class BagMap:
    """Which topics of a bag are what; what is empty is chosen where only one can be meant.

    Attributes:
        joints: Measured joints.
        commands: Commanded joints.
        pose: The body.
        frames: Parent and child of its transform, where ``pose`` is a topic of transforms.
        forces: Leg to topic.
        names: Our joint to the bag's name of it.
        imu: The IMU.
    """

    joints: str = ""
    commands: str = ""
    pose: str = ""
    frames: tuple[str, ...] = ()
    forces: Mapping[str, str] = field(default_factory=lambda: NO_NAMES)
    names: Mapping[str, str] = field(default_factory=lambda: NO_NAMES)
    imu: str = ""


@dataclass(frozen=True, slots=True)
class BagTopic:
    """A topic of a bag: its name, type, and number of messages."""

    name: str
    kind: str
    messages: int


def read_bag_map(table: Table) -> BagMap:
    """Read the table [bag].

    Raises:
        ConfigError: Something in it means nothing.
    """
    forces, names = table.maybe_table("forces"), table.maybe_table("names")
    bag = BagMap(
        joints=table.maybe_text("joints"),
        commands=table.maybe_text("commands"),
        pose=table.maybe_text("pose"),
        frames=table.texts("frames") if table.has("frames") else (),
        forces={leg: forces.text(leg) for leg in forces.names()},
        names={joint: names.text(joint) for joint in names.names()},
        imu=table.maybe_text("imu"),
    )
    table.done()
    return bag


def with_topics(given: BagMap, words: str) -> BagMap:
    """Return a map with topics as an option names them: ``joints=/joint_states,pose=/mocap``.

    Raises:
        ConfigError: A word names nothing.
    """
    for word in words.split(","):
        what, _, topic = word.strip().partition("=")
        if what == "joints" and topic:
            given = replace(given, joints=topic)
        elif what == "commands" and topic:
            given = replace(given, commands=topic)
        elif what == "pose" and topic:
            given = replace(given, pose=topic)
        elif what == "imu" and topic:
            given = replace(given, imu=topic)
        elif what.startswith("force_") and topic:
            given = replace(given, forces={**given.forces, what.removeprefix("force_"): topic})
        else:
            raise ConfigError(
                "--topics",
                f"{word.strip()!r} is none of joints=, commands=, pose=, imu= and force_LEG= with a topic",
            )
    return given


def is_bag(path: Path) -> bool:
    """Whether a path is that of a bag: its folder, or one of its files."""
    return path.suffix in BAG_SUFFIXES or (path / "metadata.yaml").is_file()


class Bag:
    """An open bag; made by ``open_bag``. Messages are taken apart only of the topics that are asked for."""

    def __init__(self, path: Path, reader: Any) -> None:
        self.path = path
        self._reader = reader
        self.topics = tuple(
            BagTopic(name, info.msgtype or "", info.msgcount)
            for name, info in reader.topics.items()
        )

    def topic(self, name: str, kinds: Sequence[str] = READ) -> BagTopic:
        """Return a topic.

        Raises:
            RecordError: There is none of that name, or it is of another type.
        """
        for one in self.topics:
            if one.name == name:
                if one.kind not in kinds:
                    wanted = " or ".join(kind.split("/")[-1] for kind in kinds)
                    raise RecordError(
                        f"{name} of {self.path} is {one.kind}, no {wanted}; {self.listing()}"
                    )
                return one
        raise RecordError(f"{self.path} has no topic {name}; {self.listing()}")

    def listing(self) -> str:
        """Return in one sentence what the bag has."""
        known = [
            f"{one.name} ({one.kind.split('/')[-1]})" for one in self.topics if one.kind in READ
        ]
        return f"of the types that are read it has {', '.join(known) or 'none'}"

    def table(self, topic: BagTopic, frames: Sequence[str] = ()) -> DataTable:
        """Return a topic as a table, columns TOPIC:FIELD, with a column TOPIC:stamp.

        Raises:
            RecordError: Nothing in it can be read.
        """
        rows: list[Mapping[str, float]] = []
        pairs: set[str] = set()
        connections = [c for c in self._reader.connections if c.topic == topic.name]
        with _reading(self.path):
            for connection, received_ns, data in self._reader.messages(connections):
                message = self._reader.deserialize(data, connection.msgtype)
                rows += _rows_of(message, topic.kind, received_ns, frames)
                if topic.kind == TRANSFORMS:
                    pairs |= {
                        f"{t.header.frame_id} -> {t.child_frame_id}" for t in message.transforms
                    }
        if len(pairs) > 1 and not frames:
            raise RecordError(
                f"{topic.name} of {self.path} holds {', '.join(sorted(pairs))}; say which in the map's "
                "[bag]: frames = [parent, child]"
            )
        if not rows:
            why = f" for {' -> '.join(frames)}" if frames else ""
            raise RecordError(f"{topic.name} of {self.path} holds no messages{why}")
        names = dict.fromkeys(name for row in rows for name in row)
        columns = (
            TableColumn(f"{topic.name}:{name}", np.array([row.get(name, math.nan) for row in rows]))
            for name in names
        )
        return DataTable(tuple(columns), len(rows))


@contextmanager
def open_bag(path: Path) -> Iterator[Bag]:
    """Open a bag: its folder, its .mcap or its .db3 file.

    Raises:
        RecordError: It cannot be read.
    """
    try:  # an extra, and a tenth of a second to load
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise RecordError(
            f"{path} is a ROS 2 bag, and reading it needs rosbags; install it with: "
            "pip install -e '.[bags]' in the clone, or pip install rosbags"
        ) from error
    with _reading(path):
        reader = AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.open()
    try:
        with _reading(path):
            bag = Bag(path, reader)
        yield bag
    finally:
        reader.close()


def _reading(path: Path) -> AbstractContextManager[None]:
    return foreign_file(f"{path} cannot be read as a ROS 2 bag")


def _seconds(stamp: Any, received_ns: int) -> float:
    """Time of a header, or of the reception where the header has none."""
    ns = int(stamp.sec) * 10**9 + int(stamp.nanosec)
    return (ns or received_ns) * 1e-9


def _rows_of(
    message: Any, kind: str, received_ns: int, frames: Sequence[str]
) -> Iterator[Mapping[str, float]]:
    if kind == TRANSFORMS:
        for one in message.transforms:
            names = (one.header.frame_id.lstrip("/"), one.child_frame_id.lstrip("/"))
            if not frames or names == tuple(frames):
                moved, turned = one.transform.translation, one.transform.rotation
                yield {"stamp": _seconds(one.header.stamp, received_ns), **_pose(moved, turned)}
        return
    row = {"stamp": _seconds(message.header.stamp, received_ns)}
    if kind == JOINT_STATE:
        for name, values in (
            ("position", message.position), ("velocity", message.velocity), ("effort", message.effort)
        ):  # fmt: skip
            # what was not measured is an empty list
            pairs = zip(message.name, values, strict=False)
            row |= {f"{name}[{joint}]": float(value) for joint, value in pairs}
    elif kind == WRENCH:
        force = message.wrench.force
        row |= {f"force.{axis}": float(getattr(force, axis)) for axis in "xyz"}
    elif kind == IMU_MESSAGE:
        row |= _imu(message)
    else:
        pose = message.pose if kind == POSE else message.pose.pose
        row |= _pose(pose.position, pose.orientation)
    yield row


def _pose(place: Any, turn: Any) -> Mapping[str, float]:
    return {
        **{f"position.{axis}": float(getattr(place, axis)) for axis in "xyz"},
        **{f"orientation.{axis}": float(getattr(turn, axis)) for axis in "xyzw"},
    }


def _imu(message: Any) -> Mapping[str, float]:
    """Rates and orientation; a covariance that begins with -1 says that one was not measured."""
    rates, turn = message.angular_velocity, message.orientation
    row: dict[str, float] = {}
    if message.angular_velocity_covariance[0] != -1:
        row |= {f"angular_velocity.{axis}": float(getattr(rates, axis)) for axis in "xyz"}
    if message.orientation_covariance[0] != -1:
        row |= {f"orientation.{axis}": float(getattr(turn, axis)) for axis in "xyzw"}
    return row


def chosen_topics(bag: Bag, given: BagMap, legs: Sequence[str]) -> BagMap:
    """Complete a map by the topics that alone can be meant.

    Raises:
        RecordError: Joints or poses could be on several topics, or a named topic is not there.
    """
    states = [one.name for one in bag.topics if one.kind == JOINT_STATE]
    ordered = [name for name in states if "command" in name or "goal" in name or "target" in name]
    measured = [name for name in states if name not in ordered]
    joints = given.joints or _only(bag, "joints", [n for n in measured if n != given.commands])
    commands = given.commands or _only(bag, "commands", [n for n in ordered if n != joints])
    poses = [one.name for one in bag.topics if one.kind in {POSE, POSE_COVARIANCE} or _true(one)]
    forces = dict(given.forces)
    for one in bag.topics:
        leg = one.name.rsplit("/", 1)[-1]
        predicted = "predict" in one.name or "estimat" in one.name
        if one.kind == WRENCH and leg in legs and not predicted:
            forces.setdefault(leg, one.name)
    units = [one.name for one in bag.topics if one.kind == IMU_MESSAGE]
    return BagMap(
        joints=joints,
        commands=commands,
        pose=given.pose or _only(bag, "pose", poses),
        frames=given.frames,
        forces=forces,
        names=given.names,
        imu=given.imu or (units[0] if len(units) == 1 else ""),
    )


def _true(one: BagTopic) -> bool:
    return one.kind == ODOMETRY and any(word in one.name.lower() for word in TRUE_WORDS)


def _only(bag: Bag, what: str, names: Sequence[str]) -> str:
    if len(names) > 1:
        raise RecordError(
            f"{what} of {bag.path} could be {', '.join(names)}; say which: [bag] {what} in the map, or "
            f"--topics {what}={names[0]}"
        )
    return names[0] if names else ""


def bag_columns(
    tables: Mapping[str, DataTable], given: BagMap, joints: Sequence[str]
) -> Iterator[tuple[str, str]]:
    """Yield our column and the bag's for what the map's topics hold; times are not among them.

    Raises:
        RecordError: A joint that is named is not on its topic.
    """
    fields: tuple[tuple[str, str, Callable[[str], str]], ...] = (
        (given.joints, "position", "shaft_{}_rad".format),
        (given.joints, "velocity", "shaft_{}_rad_s".format),
        (given.commands, "position", "command_{}_rad".format),
    )
    for topic, name, ours in fields:
        for joint in joints if topic else ():
            theirs = f"{topic}:{name}[{given.names.get(joint, joint)}]"
            if theirs in tables[topic].names:
                yield ours(joint), theirs
            elif joint in given.names and name == "position":
                has = ", ".join(joints_on(tables[topic]))
                raise RecordError(f"{topic} has no joint {given.names[joint]}; it has {has}")
    if given.pose:
        yield from ((f"body_{a}_m", f"{given.pose}:position.{a}") for a in "xyz")
        yield from ((f"body_quaternion_{a}", f"{given.pose}:orientation.{a}") for a in "xyzw")
    if given.imu:
        for column, field_name in IMU_FIELDS:
            if f"{given.imu}:{field_name}" in tables[given.imu].names:
                yield column, f"{given.imu}:{field_name}"
    for leg, topic in given.forces.items():
        yield from ((f"force_{leg}_{a}_n", f"{topic}:force.{a}") for a in "xyz")


def joints_on(table: DataTable) -> tuple[str, ...]:
    """Names of the joints of a table of joint states."""
    parts = (name.partition(":position[") for name in table.names)
    return tuple(joint.removesuffix("]") for _, mark, joint in parts if mark)
