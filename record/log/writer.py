"""Writing a log: every tick to an MCAP file, in small chunks, flushed twice a second.

A process that is killed loses what lies in the open chunk and since the last flush: less than a second.
Nothing of the wall clock, the machine or the path goes in by itself, so that the same ticks give the same
bytes.
"""

import struct
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO

from model.errors import RecordError
from model.values.readings import ImuRecord
from model.values.tick import Tick
from model.values.wire import WireBytes
from record.log import messages
from record.log.definitions import DEFINITIONS, IMU_DEFINITION, IMU_TYPE
from record.log.mcap_file import McapFile
from record.log.state_message import (
    STATE_DEFINITION,
    STATE_TOPIC,
    STATE_TYPE,
    LoggedState,
    encode_state,
)
from record.log.tick_message import TickEncoder
from record.log.wire_message import (
    WIRE_DEFINITION,
    WIRE_TOPICS,
    WIRE_TYPE,
    encode_wire,
    wire_topic,
)
from record.topics import TICK_TOPIC
from record.whole_file import clear_name, writing

FLUSH_PERIOD_NS = 500_000_000
DIAGNOSTICS_PERIOD_NS = 1_000_000_000
LIBRARY = "bigant"
TICK_SCHEMA = "bigant_msgs/msg/Tick"
CONFIG_NAME = "robot.toml"
METADATA_NAME = "bigant"
NAMES_KEY = "leg_names"
JOINTS_KEY = "joint_names"  # where they are others than those of the legs
START_KEY = "start_ns"
START_UNIX_KEY = "start_unix_ns"
IMU_TOPIC = "/imu"
# What values raise that no message can hold.
UNENCODABLE = (ValueError, TypeError, ArithmeticError, struct.error)
RATE_KEY = "rate_hz"  # of the loop, where it is known
# What rosbags and ros2 bag want to read beside a topic: reliable, volatile, keep the last ten.
QOS = (
    "- history: 1\n  depth: 10\n  reliability: 1\n  durability: 2\n"
    "  deadline: {sec: 9223372036, nsec: 854775807}\n"
    "  lifespan: {sec: 9223372036, nsec: 854775807}\n"
    "  liveliness: 1\n"
    "  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}\n"
    "  avoid_ros_namespace_conventions: false\n"
)


class LogWriter:
    """Writes ticks to a file.

    Args:
        path: The log file.
        names: Leg names.
        joints: Joint names; empty where they are those of the legs.
        config_text: The robot file's text.
        metadata: Whatever else is worth knowing, as texts.
        start_ns: Monotonic time of the beginning.
        start_unix_ns: The same moment in UNIX time; stamps in the log are UNIX time.

    Raises:
        RecordError: The file cannot be written.
    """

    def __init__(
        self,
        path: Path,
        *,
        names: tuple[str, ...],
        joints: tuple[str, ...] = (),
        config_text: str,
        metadata: Mapping[str, str],
        start_ns: int,
        start_unix_ns: int,
    ) -> None:
        self.path = path
        self._joints = joints or names
        self._wrenches = [(f"/wrench/{name}", f"/wrench_predicted/{name}") for name in names]
        self._names = names
        self._offset_ns = start_unix_ns - start_ns
        self._error: RecordError | None = None
        self._encoder = TickEncoder()
        self._sequence = 0
        self._wires = 0
        self._next_flush_ns = start_ns + FLUSH_PERIOD_NS
        self._next_diagnostics_ns = start_ns
        clear_name(path, "--log")
        with writing(path, "--log"):
            self._file: BinaryIO = path.open("wb")
        self._writer = McapFile(self._file)
        details = {
            **metadata,
            NAMES_KEY: ",".join(names),
            **({} if self._joints == names else {JOINTS_KEY: ",".join(self._joints)}),
            START_KEY: str(start_ns),
            START_UNIX_KEY: str(start_unix_ns),
        }
        self._guard(lambda: self._begin(config_text, details, start_unix_ns))
        if self._error is not None:
            self._abandon()
            raise self._error

    @property
    def error(self) -> RecordError | None:
        """Why nothing more can be written, None while it can."""
        return self._error

    def _guard(self, action: Callable[[], None]) -> None:
        if self._error is not None:
            return
        try:
            action()
        except OSError as error:
            self._error = RecordError(
                f"the log {self.path} can no longer be written: {error.strerror}; "
                "make room or choose another --log"
            )
        except UNENCODABLE as error:
            self._error = RecordError(
                f"the log {self.path} takes no tick any more: {error}; please report it"
            )

    def _begin(self, config_text: str, details: Mapping[str, str], unix_ns: int) -> None:
        self._writer.start(profile="ros2", library=LIBRARY)
        schemas = {
            name: self._writer.register_schema(name, "ros2msg", text.encode("utf-8"))
            for name, text in DEFINITIONS.items()
        }
        self._channels = MappingProxyType(
            {
                topic: self._writer.register_channel(
                    topic, "cdr", schemas[kind], {"offered_qos_profiles": QOS}
                )
                for topic, kind in topics(self._names)
            }
        )
        self._writer.add_metadata(METADATA_NAME, dict(sorted(details.items())))
        self._writer.add_attachment(
            unix_ns, unix_ns, CONFIG_NAME, "application/toml", config_text.encode("utf-8")
        )
        self._flush()

    def write(self, tick: Tick) -> None:
        """Write one tick and its standard messages. After an error nothing more is written."""
        self._guard(lambda: self._write(tick))

    def _write(self, tick: Tick) -> None:
        unix_ns = tick.t_ns + self._offset_ns
        joints, sent = tick.joints, tick.sent
        estimate = tick.estimate
        predicted_force = tick.contact.traction.force_B if estimate is None else estimate.force_B
        state = messages.joint_state(unix_ns, self._joints, joints.angle_rad, joints.rate_rad_s)
        wanted = messages.joint_state(unix_ns, self._joints, sent.angle_rad, sent.rate_rad_s)
        published = [
            (TICK_TOPIC, self._encoder.encode(tick)), ("/joint_states", state), ("/joint_commands", wanted),
        ]  # fmt: skip
        measured = messages.wrenches(unix_ns, tick.forces.force_n)
        predicted = messages.wrenches(unix_ns, predicted_force)
        for (topic, predicted_topic), one, other in zip(
            self._wrenches, measured, predicted, strict=True
        ):
            published += ((topic, one), (predicted_topic, other))
        best = tick.dead_reckoning if estimate is None else estimate
        published += zip(("/odom", "/tf"), messages.planar_pose(unix_ns, best), strict=True)
        if estimate is not None:
            reckoned, _ = messages.planar_pose(unix_ns, tick.dead_reckoning)
            published.append(("/odom_open_loop", reckoned))
        truth = tick.inputs.truth
        if truth is not None:
            published.append(("/odom_truth", messages.truth_odometry(unix_ns, truth)))
        self._put(unix_ns, published)
        if tick.inputs.imu:
            self._write_imu(tick.inputs.imu, unix_ns)
        if tick.t_ns >= self._next_diagnostics_ns:
            self._next_diagnostics_ns = tick.t_ns + DIAGNOSTICS_PERIOD_NS
            diagnostics = messages.diagnostics(unix_ns, self._joints, tick)
            self._put(unix_ns, [("/diagnostics", diagnostics)])
        self._sequence += 1
        if tick.t_ns >= self._next_flush_ns:
            self._next_flush_ns = tick.t_ns + FLUSH_PERIOD_NS
            self._flush()

    def _put(self, unix_ns: int, published: list[tuple[str, bytes]]) -> None:
        """Write messages of this tick: topic and bytes of each."""
        channels = self._channels
        put = [(channels[topic], data) for topic, data in published]
        self._writer.add_messages(unix_ns, put, self._sequence)

    def _write_imu(self, readings: tuple[ImuRecord, ...], unix_ns: int) -> None:
        """Write readings with their own stamps; their topic begins with the first of them."""
        if IMU_TOPIC not in self._channels:
            self._add_topics(IMU_TYPE, IMU_DEFINITION, (IMU_TOPIC,))
        published = [(IMU_TOPIC, messages.imu(one.t_ns + self._offset_ns, one)) for one in readings]
        self._put(unix_ns, published)

    def _add_topics(self, kind: str, definition: str, names: tuple[str, ...]) -> None:
        schema = self._writer.register_schema(kind, "ros2msg", definition.encode("utf-8"))
        added = {
            topic: self._writer.register_channel(
                topic, "cdr", schema, {"offered_qos_profiles": QOS}
            )
            for topic in names
        }
        self._channels = MappingProxyType({**self._channels, **added})

    def write_state(self, t_ns: int, index: int, encode: Callable[[], bytes]) -> None:
        """Write what the controller remembers after a tick; its topic begins with the first of them.

        Args:
            t_ns: Time of the tick.
            index: Number of the next tick.
            encode: Gives the state as ``record.exact_values`` writes it.
        """
        self._guard(lambda: self._write_state(t_ns, LoggedState(index, encode())))

    def _write_state(self, t_ns: int, state: LoggedState) -> None:
        if STATE_TOPIC not in self._channels:
            self._add_topics(STATE_TYPE, STATE_DEFINITION, (STATE_TOPIC,))
        message = (self._channels[STATE_TOPIC], encode_state(state))
        self._writer.add_messages(t_ns + self._offset_ns, (message,), state.index)

    def write_wires(self, heard: tuple[WireBytes, ...]) -> None:
        """Write raw bytes of the devices, oldest first; their topics begin with the first of them."""
        self._guard(lambda: self._write_wires(heard))

    def _write_wires(self, heard: tuple[WireBytes, ...]) -> None:
        if heard and WIRE_TOPICS[0] not in self._channels:
            self._add_topics(WIRE_TYPE, WIRE_DEFINITION, WIRE_TOPICS)
        for piece in heard:
            channel, unix_ns = self._channels[wire_topic(piece.wire)], piece.t_ns + self._offset_ns
            self._writer.add_messages(unix_ns, ((channel, encode_wire(piece)),), self._wires)
            self._wires += 1  # one count over all wires: their common order

    def _flush(self) -> None:
        self._writer.flush()

    def fileno(self) -> int:
        """Return the file's descriptor, for fsync."""
        return self._file.fileno()

    def close(self) -> None:
        """Finish the file. An error is kept in ``error``."""
        self._guard(self._writer.finish)
        self._abandon()

    def _abandon(self) -> None:
        try:
            self._file.close()
        except OSError as error:
            self._error = self._error or RecordError(
                f"the log {self.path} can no longer be written: {error.strerror}"
            )


def topics(names: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Return the topics of a log and their types."""
    wrenches = [
        (f"/{kind}/{name}", "geometry_msgs/msg/WrenchStamped")
        for kind in ("wrench", "wrench_predicted")
        for name in names
    ]
    return (
        (TICK_TOPIC, TICK_SCHEMA),
        ("/joint_states", "sensor_msgs/msg/JointState"),
        ("/joint_commands", "sensor_msgs/msg/JointState"),
        *wrenches,
        ("/odom", "nav_msgs/msg/Odometry"),
        ("/odom_open_loop", "nav_msgs/msg/Odometry"),
        ("/odom_truth", "nav_msgs/msg/Odometry"),
        ("/tf", "tf2_msgs/msg/TFMessage"),
        ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
    )
