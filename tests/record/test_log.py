"""The log: complete, standard, the same bytes for the same ticks, readable when cut anywhere."""

import dataclasses
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from model.errors import RecordError
from model.values.tick import Tick
from record.log.background import QUEUE_TICKS, BackgroundWriter
from record.log.blocks.read import read_log
from record.log.definitions import DEFINITIONS
from record.log.reader import LogContents, read_ticks
from record.log.rewrite import repair
from record.log.tick_message import decode_inputs, decode_tick, encode_tick
from record.log.writer import LogWriter, topics
from tests.record.ticks import NAMES, PERIOD_NS, make_tick

START_UNIX_NS = 1_767_225_600_000_000_000


def write_log(path: Path, count: int, names: tuple[str, ...] = NAMES) -> list[Tick]:
    ticks = [make_tick(i, legs=len(names)) for i in range(count)]
    writer = LogWriter(
        path,
        names=names,
        config_text="name = 'x'\n",
        metadata={"gait": "tripod", "robot": "BigANT"},
        start_ns=ticks[0].t_ns,
        start_unix_ns=START_UNIX_NS,
    )
    for tick in ticks:
        writer.write(tick)
    writer.close()
    assert writer.error is None
    return ticks


def same(one: object, other: object) -> bool:
    """Equal in every field, NaN equal to NaN."""
    if dataclasses.is_dataclass(one):
        return type(one) is type(other) and all(
            same(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one)
        )
    if isinstance(one, np.ndarray):
        assert isinstance(other, np.ndarray)
        return one.shape == other.shape and bool(np.array_equal(one, other, equal_nan=_floats(one)))
    if isinstance(one, tuple):
        assert isinstance(other, tuple)
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float) and np.isnan(one):
        return isinstance(other, float) and bool(np.isnan(other))
    return one == other


def _floats(array: np.ndarray) -> bool:
    return array.dtype.kind == "f"


@given(st.integers(0, 500), st.integers(3, 9))
def test_a_tick_survives_its_message(index: int, legs: int) -> None:
    tick = make_tick(index, legs=legs)
    assert same(decode_tick(encode_tick(tick)), tick)


@given(st.integers(0, 40), st.data())
def test_a_cut_message_is_an_error_not_a_tick(index: int, data: st.DataObject) -> None:
    message = encode_tick(make_tick(index))
    cut = data.draw(st.integers(0, len(message) - 1))
    with pytest.raises(ValueError, match=r"too early|not little-endian"):
        decode_tick(message[:cut])


def test_a_log_gives_back_its_ticks(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    ticks = write_log(path, 60)
    contents = LogContents()
    back = list(read_ticks(path, contents))
    assert len(back) == 60
    assert all(map(same, back, ticks))
    assert contents.damage == ""
    assert contents.config_text == "name = 'x'\n"


def test_a_log_as_arrays(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    ticks = write_log(path, 20)
    log = read_log(path)
    assert log.names == NAMES
    assert log.t_s == pytest.approx(np.arange(20) * 0.01)
    assert np.isnan(log.truth_position_W[3]).all(), "no truth in that tick"
    assert log.force_n.shape == (20, 6, 3)
    assert log.faults[0] == (1, ticks[1].faults[0])
    assert log.metadata["gait"] == "tripod"


def test_the_same_ticks_give_the_same_bytes(tmp_path: Path) -> None:
    write_log(tmp_path / "a.mcap", 30)
    write_log(tmp_path / "b.mcap", 30)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


# Other people's readers.


def test_rosbags_reads_every_topic(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    ticks = write_log(path, 120)
    seen: dict[str, int] = {}
    with AnyReader([path]) as reader:
        for connection, stamp, raw in reader.messages():
            message: Any = reader.deserialize(raw, connection.msgtype)
            seen[connection.topic] = seen.get(connection.topic, 0) + 1
            if connection.topic == "/joint_states" and seen[connection.topic] == 1:
                assert stamp == START_UNIX_NS
                assert tuple(message.name) == NAMES
                np.testing.assert_array_equal(message.position, ticks[0].joints.angle_rad)
            if connection.topic == "/bigant/tick" and seen[connection.topic] == 3:
                assert message.faults[0].detail == ticks[2].faults[0].detail
                np.testing.assert_array_equal(message.load_n, ticks[2].contact.support.load_n)
    assert set(seen) == {"/imu", *(topic for topic, _ in topics(NAMES))}
    assert seen["/diagnostics"] == 2, "once a second"


def test_mcap_ros2_reads_every_topic(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    ticks = write_log(path, 12)
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        messages = [(c.topic, m) for _, c, _, m in reader.iter_decoded_messages()]
    odometry = [m for topic, m in messages if topic == "/odom"]
    assert odometry[5].header.frame_id == "odom"
    assert odometry[5].child_frame_id == "base_link"
    assert odometry[5].pose.pose.position.x == ticks[5].dead_reckoning.position_m[0]
    said = ticks[4].estimate
    assert said is not None
    assert odometry[4].pose.pose.position.x == said.position_m[0]
    pose = np.array(odometry[4].pose.covariance).reshape(6, 6)
    np.testing.assert_array_equal(pose[np.ix_([0, 1, 5], [0, 1, 5])], said.pose_covariance)
    assert pose[2, 2] == pose[3, 3] == pose[4, 4] == 1e6, "height, roll, pitch: not estimated"
    twist = np.array(odometry[4].twist.covariance).reshape(6, 6)
    np.testing.assert_array_equal(twist[np.ix_([0, 1, 5], [0, 1, 5])], said.twist_covariance)
    reckoned = [m for topic, m in messages if topic == "/odom_open_loop"]
    assert reckoned[3].pose.pose.position.x == ticks[4].dead_reckoning.position_m[0], (
        "tick 2 has none"
    )
    force = [m for topic, m in messages if topic == "/wrench_predicted/ML"][4].wrench.force
    assert (force.x, force.y, force.z) == tuple(said.force_B[1])
    transforms = [m for topic, m in messages if topic == "/tf"]
    assert transforms[0].transforms[0].child_frame_id == "base_link"
    wrench = next(m for topic, m in messages if topic == "/wrench/HL")
    assert wrench.header.stamp.sec == START_UNIX_NS // 10**9
    tick = [m for topic, m in messages if topic == "/bigant/tick"][4]
    assert tick.servos_attached is False


@pytest.mark.parametrize("index", range(6))
def test_our_bytes_are_those_of_an_independent_encoder(index: int) -> None:
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(DEFINITIONS["bigant_msgs/msg/Tick"], "bigant_msgs/msg/Tick"))
    ours = encode_tick(make_tick(index))
    message = store.deserialize_cdr(ours, "bigant_msgs/msg/Tick")
    theirs = bytes(store.serialize_cdr(message, "bigant_msgs/msg/Tick"))
    assert theirs == ours


# A log that ends early.


@pytest.mark.parametrize("share", [0.45, 0.5, 0.55, 0.6, 0.65])
def test_a_damaged_byte_is_noticed(tmp_path: Path, share: float) -> None:
    path = tmp_path / "log.mcap"
    write_log(path, 150)
    data = bytearray(path.read_bytes())
    data[int(len(data) * share)] ^= 0xFF
    path.write_bytes(data)
    log = read_log(path)
    assert "cut or damaged" in log.damage
    assert 0 < len(log.t_s) <= 150


@pytest.mark.parametrize("content", [b"", b"not a log", b"\x89MCAP0\r\n"])
def test_what_is_no_log_is_an_error(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "log.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordError, match="cannot be read as a log"):
        read_log(path)


def test_a_log_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match=r"none\.mcap cannot be read: No such file"):
        read_log(tmp_path / "none.mcap")


def test_a_cut_log_can_be_made_whole(tmp_path: Path) -> None:
    path, whole = tmp_path / "log.mcap", tmp_path / "whole.mcap"
    write_log(path, 150)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    kept = repair(path, whole).kept
    with AnyReader([whole]) as reader:
        assert reader.message_count == kept
    assert read_log(whole).damage == ""
    assert len(read_log(whole).t_s) == len(read_log(path).t_s)


KILLED = """
import sys
from pathlib import Path
from typing import Any
from record.log.writer import LogWriter
from tests.record.ticks import NAMES, make_tick
first = make_tick(0)
writer = LogWriter(Path(sys.argv[1]), names=NAMES, config_text="", metadata={},
                   start_ns=first.t_ns, start_unix_ns=0)
index = 0
while True:
    writer.write(make_tick(index))
    print(index, flush=True)
    index += 1
"""


def test_a_killed_process_loses_less_than_a_second(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    root = Path(__file__).resolve().parents[2]
    child = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(path)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
    )
    assert child.stdout is not None
    written = -1
    while written < 333:
        written = int(child.stdout.readline())
    child.send_signal(signal.SIGKILL)
    child.wait()
    written = max([written, *(int(line) for line in child.stdout if line.strip().isdigit())])
    child.stdout.close()
    last = read_log(path).t_s[-1]
    assert last > (written + 1) * PERIOD_NS * 1e-9 - 1.0


# Logs that cannot be written.


def test_a_full_disk_is_an_error_and_loses_nothing_else() -> None:
    with pytest.raises(RecordError, match="/dev/full can no longer be written: No space left"):
        LogWriter(
            Path("/dev/full"),
            names=NAMES,
            config_text="",
            metadata={},
            start_ns=0,
            start_unix_ns=0,
        )


@pytest.mark.parametrize("place", ["missing/log.mcap", "file/log.mcap", "."])
def test_a_place_that_cannot_be_written_is_an_error(tmp_path: Path, place: str) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordError, match=r"cannot be written: .*; choose another --log"):
        LogWriter(
            tmp_path / place,
            names=NAMES,
            config_text="",
            metadata={},
            start_ns=0,
            start_unix_ns=0,
        )


def test_the_background_writer_writes_the_same_file(tmp_path: Path) -> None:
    ticks = write_log(tmp_path / "direct.mcap", 40)
    writer = LogWriter(
        tmp_path / "thread.mcap",
        names=NAMES,
        config_text="name = 'x'\n",
        metadata={"gait": "tripod", "robot": "BigANT"},
        start_ns=ticks[0].t_ns,
        start_unix_ns=START_UNIX_NS,
    )
    background = BackgroundWriter(writer)
    for tick in ticks:
        background.write(tick)
    background.close()
    assert background.error is None
    assert (tmp_path / "thread.mcap").read_bytes() == (tmp_path / "direct.mcap").read_bytes()


class StuckFile:
    """A writer whose disk never answers."""

    error = None
    path = Path("stuck")

    def write(self, _tick: Tick) -> None:
        time.sleep(0.01)

    def fileno(self) -> int:
        raise OSError("nothing to sync")

    def close(self) -> None:
        pass


def test_a_disk_that_does_not_keep_up_is_an_error_and_never_blocks() -> None:
    background = BackgroundWriter(StuckFile())  # type: ignore[arg-type]
    tick = make_tick(0)
    for _ in range(2300):
        background.write(tick)
    assert background.dropped > 0
    assert background.error is not None
    assert "does not keep up" in str(background.error)


class BrokenFile(StuckFile):
    """A writer that meets what nobody thought of."""

    def write(self, _tick: Tick) -> None:
        raise KeyError("unheard of")


def test_whatever_the_thread_meets_is_an_error_at_once_and_closing_ends() -> None:
    background = BackgroundWriter(BrokenFile())  # type: ignore[arg-type]
    background.write(make_tick(0))
    background.close()
    assert "KeyError: 'unheard of'" in str(background.error)
    tick = make_tick(1)
    for _ in range(QUEUE_TICKS + 10):  # the loop goes on until it stands
        background.write(tick)


def test_closing_gives_up_on_a_disk_that_takes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("record.log.background.CLOSE_LIMIT_S", 0.05)
    stuck = threading.Event()
    file = StuckFile()
    monkeypatch.setattr(file, "write", lambda _tick: stuck.wait())
    background = BackgroundWriter(file)  # type: ignore[arg-type]
    background.write(make_tick(0))
    background.close()
    stuck.set()
    assert "takes nothing any more" in str(background.error)


def test_a_tick_that_cannot_be_written_is_an_error_of_the_log(tmp_path: Path) -> None:
    tick = make_tick(0)
    writer = LogWriter(
        tmp_path / "a.mcap",
        names=NAMES,
        config_text="",
        metadata={},
        start_ns=tick.t_ns,
        start_unix_ns=START_UNIX_NS,
    )
    writer.write(dataclasses.replace(tick, index=2**70))
    assert "takes no tick any more" in str(writer.error)
    writer.close()


@pytest.mark.parametrize("legs", [3, 6])
def test_inputs_are_decoded_without_the_truth_and_end_where_the_outputs_begin(legs: int) -> None:
    for index in range(8):
        tick = make_tick(index, legs=legs)
        data = encode_tick(tick)
        seen = decode_inputs(data)
        assert same(seen.inputs, dataclasses.replace(tick.inputs, truth=None))
        whole = dataclasses.replace(tick, inputs=seen.inputs)
        assert same(decode_tick(data, seen=seen), whole)
        for cut in range(0, seen.end, 7):
            with pytest.raises(ValueError, match=r"early|unpack|buffer"):
                decode_inputs(data[: cut + 4])
