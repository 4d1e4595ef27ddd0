"""Absolute poses over UDP: golden lines, wrong lines, a real socket on loopback."""

import socket

import numpy as np
import pytest

from drivers.lines.poses import MOST_LINES, PoseListener, parse_pose
from drivers.lines.sources import LOOPBACK
from model.errors import ConfigError
from model.values.faults import FaultKind
from sim_hw.clock import VirtualClock

UNIX_NS = 1_767_225_600_000_000_000
LINE = "1767225600.25 1.5 -0.25 0.125 0 0 0.6 0.8 0.002 0.01"


def test_a_golden_line() -> None:
    found = parse_pose(LINE, UNIX_NS - 5_000_000_000)
    assert found.t_ns == 5_250_000_000
    assert found.position_W.tolist() == [1.5, -0.25, 0.125]
    assert found.quaternion_xyzw.tolist() == [0.0, 0.0, 0.6, 0.8]
    assert (found.sd_position_m, found.sd_angle_rad) == (0.002, 0.01)


def test_what_is_not_told_is_nan() -> None:
    found = parse_pose("1767225600 0 0 0 nan nan nan nan", UNIX_NS)
    assert np.isnan(found.quaternion_xyzw).all()
    assert np.isnan([found.sd_position_m, found.sd_angle_rad]).all()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("1 2 3", "3 numbers"),
        ("1 2 3 4 0 0 0 1 1 1 1", "11 numbers"),
        ("1 nan 3 4 0 0 0 1", "finite"),
        ("1 2 3 4 0 0 0 2", "length 2"),
        ("1 2 3 4 0 0 nan 1", "length nan"),
        ("1 2 3 4 0 0 0 1 -0.1", "above 0"),
        ("one 2 3 4 0 0 0 1", "convert"),
    ],
)
def test_a_line_without_sense_says_why(line: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        parse_pose(line, 0)


def test_lines_through_a_socket() -> None:
    clock = VirtualClock(start_ns=5_000_000_000)
    listener = PoseListener(0, clock, UNIX_NS)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        assert listener.read() == ((), ())
        there = (LOOPBACK, listener.port)
        sender.sendto(f"# a comment\n{LINE}\n\n{LINE}\n".encode(), there)
        sender.sendto(b"\xff\xfe nonsense", there)
        sender.sendto(LINE.encode(), there)
        poses, faults = listener.read()  # loopback delivers before sendto returns
        assert [pose.t_ns for pose in poses] == [5_250_000_000] * 3
        assert [fault.kind for fault in faults] == [FaultKind.POSE_BAD]
        with pytest.raises(ConfigError, match="cannot be had"):
            PoseListener(listener.port, clock, UNIX_NS)
    finally:
        sender.close()
        listener.close()


@pytest.mark.parametrize("factor", [10**3, 10**6, 10**9, 10**30])
def test_a_stamp_in_another_unit_is_refused_and_says_so(factor: int) -> None:
    clock = VirtualClock(start_ns=5_000_000_000)
    listener = PoseListener(0, clock, UNIX_NS)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        line = f"{UNIX_NS // 10**9 * factor} 0.1 0.2 0 0 0 0 1"
        sender.sendto(line.encode(), (LOOPBACK, listener.port))
        poses, (fault,) = listener.read()
    listener.close()
    assert poses == ()
    assert "UNIX time in seconds" in fault.detail


def test_a_flood_holds_nobody_up() -> None:
    clock = VirtualClock(start_ns=5_000_000_000)
    listener = PoseListener(0, clock, UNIX_NS)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for _ in range(40):
            sender.sendto(f"{LINE}\n".encode() * 50, (LOOPBACK, listener.port))
        poses, (fault,) = listener.read()
    listener.close()
    assert len(poses) == MOST_LINES
    assert "only the newest are used" in fault.detail
