"""A log that is read while it is written: nothing twice, nothing half, nothing left out."""

from pathlib import Path

import pytest
from mcap.reader import make_reader

from model.errors import RecordError
from record.log.follow import LogFollower
from record.log.reader import read_ticks
from tests.record.test_log import same, write_log


def test_a_log_that_grows_byte_by_byte_gives_every_tick_once(tmp_path: Path) -> None:
    whole = tmp_path / "whole.mcap"
    write_log(whole, 130)
    data = whole.read_bytes()
    growing = tmp_path / "growing.mcap"
    growing.write_bytes(b"")
    ticks = []
    with LogFollower(growing) as follower, growing.open("ab") as writer:
        for begin in range(0, len(data), 4099):  # no multiple of anything in the file
            writer.write(data[begin : begin + 4099])
            writer.flush()
            ticks += [item.tick for item in follower.new_ticks()]
        assert follower.finished
        assert follower.contents.config_text == "name = 'x'\n"
        assert follower.contents.metadata["gait"] == "tripod"
    expected = list(read_ticks(whole))
    assert len(ticks) == 130
    assert all(same(one, other) for one, other in zip(ticks, expected, strict=True))


def test_all_topics_come_with_their_types(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    write_log(path, 20)
    with LogFollower(path) as follower:
        kinds = {message.topic: message.kind for message in follower.new_messages()}
    assert kinds["/odom"] == "nav_msgs/msg/Odometry"
    assert kinds["/wrench/HL"] == "geometry_msgs/msg/WrenchStamped"
    assert kinds["/diagnostics"] == "diagnostic_msgs/msg/DiagnosticArray"


def test_what_is_no_log_is_said(tmp_path: Path) -> None:
    path = tmp_path / "text.mcap"
    path.write_text("hello, this is no log", encoding="utf-8")
    with LogFollower(path) as follower, pytest.raises(RecordError, match="is it a log"):
        list(follower.new_ticks())
    with pytest.raises(RecordError, match="cannot be read"):
        LogFollower(tmp_path / "absent.mcap")


def test_a_broken_chunk_is_an_error_with_advice(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    write_log(path, 60)
    data = bytearray(path.read_bytes())
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    chunk = summary.chunk_indexes[0]
    middle = chunk.chunk_start_offset + chunk.chunk_length // 2
    data[middle : middle + 40] = bytes(40)
    path.write_bytes(data)
    with LogFollower(path) as follower, pytest.raises(RecordError, match="bigant log repair"):
        list(follower.new_ticks())
