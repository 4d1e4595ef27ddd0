"""An IMU's lines: golden ones, wrong ones, a real socket, a serial port that is pulled, silence."""

import contextlib
import os
import pty
import socket
import time
import tty
from collections.abc import Iterator
from math import isnan, nan
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.lines.imu import MOST_READINGS, STUCK_READINGS, ImuListener, imu_line, parse_imu
from drivers.lines.sources import LONGEST_LINE, LOOPBACK, SerialLines, UdpLines
from model.errors import ConfigError
from model.values.faults import Fault, FaultKind
from model.values.readings import ImuRecord
from sim_hw.clock import VirtualClock

UNIX_NS = 1_767_225_600_000_000_000
BEGIN_NS = 5_000_000_000
STALE_S = 0.2


class Lines:
    """A source that gives what a test puts in."""

    def __init__(self) -> None:
        self.waiting: list[str] = []

    def receive(self) -> list[str]:
        given, self.waiting = self.waiting, []
        return given

    def close(self) -> None:
        pass


def listening() -> tuple[Lines, VirtualClock, ImuListener]:
    """A listener whose first read, which forgives all, is over."""
    lines, clock = Lines(), VirtualClock(start_ns=BEGIN_NS)
    listener = ImuListener(lines, clock, UNIX_NS, STALE_S)
    assert listener.read() == ((), ())
    return lines, clock, listener


def line(t_ns: int, *numbers: float) -> str:
    """A line of a sender whose UNIX time is ours."""
    return imu_line(ImuRecord(t_ns, *[*numbers, nan, nan][:3]), UNIX_NS - BEGIN_NS)


def test_golden_lines() -> None:
    offset_ns = UNIX_NS - BEGIN_NS
    assert parse_imu("1767225600.25 -0.125", offset_ns, 7).t_ns == BEGIN_NS + 250_000_000
    alone = parse_imu("1767225600.25 -0.125", offset_ns, 7)
    assert alone.yaw_rate_rad_s == -0.125
    assert isnan(alone.roll_rad)
    assert isnan(alone.pitch_rad)
    whole = parse_imu("  1767225600.123456789 1e-3 0.5 -0.25\r", offset_ns, 7)
    assert whole == ImuRecord(BEGIN_NS + 123_456_789, 0.001, 0.5, -0.25)
    tilt_alone = parse_imu("1767225600 nan 0.5 -0.25", offset_ns, 7)
    assert isnan(tilt_alone.yaw_rate_rad_s)
    assert parse_imu("nan 0.1", offset_ns, 7).t_ns == 7, "a sender without a clock"


@given(
    st.integers(0, 2**61),
    st.floats(-35, 35),
    st.floats(-3.14, 3.14),
    st.floats(-3.14, 3.14),
)
def test_a_reading_survives_its_line(t_ns: int, rate: float, roll: float, pitch: float) -> None:
    record = ImuRecord(t_ns, rate, roll, pitch)
    assert parse_imu(imu_line(record, UNIX_NS), UNIX_NS, 0) == record


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1", "1 numbers in place of 2 or 4"),
        ("1 2 3", "3 numbers"),
        ("1 2 3 4 5", "5 numbers"),
        ("1 inf", "finite or nan"),
        ("inf 1", "finite or nan"),
        ("1 57.3", "rad/s"),
        ("1 0.1 12.5 0", "in rad"),
        ("one 2", "convert"),
        ("1,2", "1 numbers"),
    ],
)
def test_a_line_without_sense_says_why(text: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        parse_imu(text, 0, 0)


@given(st.lists(st.text(max_size=40), max_size=8))
def test_no_text_at_all_ends_in_an_exception(texts: list[str]) -> None:
    lines, _, listener = listening()
    lines.waiting = texts
    readings, faults = listener.read()
    assert all(fault.kind in {FaultKind.IMU_BAD, FaultKind.IMU_STALE} for fault in faults)
    assert len(readings) <= MOST_READINGS


def test_lines_through_a_socket() -> None:
    clock = VirtualClock(start_ns=BEGIN_NS)
    source = UdpLines(0, "imu")
    listener = ImuListener(source, clock, UNIX_NS, STALE_S)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        assert listener.read() == ((), ())
        text = f"# a comment\n{line(BEGIN_NS, 0.1)}\n\n{line(BEGIN_NS + 5, 0.2)}\n"
        sender.sendto(text.encode(), (LOOPBACK, source.port))
        sender.sendto(b"\xff\xfe nonsense", (LOOPBACK, source.port))
        readings, faults = listener.read()
    assert [(one.t_ns, one.yaw_rate_rad_s) for one in readings] == [
        (BEGIN_NS, 0.1), (BEGIN_NS + 5, 0.2),
    ]  # fmt: skip
    assert [fault.kind for fault in faults] == [FaultKind.IMU_BAD]
    with pytest.raises(ConfigError, match=r"imu: port .* cannot be had"):
        UdpLines(source.port, "imu")
    listener.close()


def test_of_a_flood_the_newest_count() -> None:
    lines, _, listener = listening()
    lines.waiting = [line(BEGIN_NS + k, 0.001 * k) for k in range(1000)]
    readings, (fault,) = listener.read()
    assert [one.t_ns for one in readings] == [
        BEGIN_NS + k for k in range(1000 - MOST_READINGS, 1000)
    ]
    assert fault.kind is FaultKind.IMU_BAD
    assert f"more than {MOST_READINGS} lines" in fault.detail


def test_what_came_before_the_first_read_is_no_fault() -> None:
    lines, clock = Lines(), VirtualClock(start_ns=BEGIN_NS)
    listener = ImuListener(lines, clock, UNIX_NS, STALE_S)
    lines.waiting = ["torn", *(line(BEGIN_NS - 10**9 + 10**7 * k, 0.001 * k) for k in range(101))]
    readings, faults = listener.read()
    assert faults == ()
    assert readings[-1].t_ns == BEGIN_NS


def kinds(faults: tuple[Fault, ...]) -> list[FaultKind]:
    return [fault.kind for fault in faults]


def test_silence_is_a_fault_once_a_second_until_it_is_back() -> None:
    lines, clock, listener = listening()
    stale = []
    for k in range(300):  # three seconds
        clock.advance(10_000_000)
        if k < 10 or k >= 250:
            lines.waiting = [line(clock.now_ns(), 0.001 * k)]
        readings, faults = listener.read()
        assert bool(readings) is (k < 10 or k >= 250)
        stale += [(k, fault.detail) for fault in faults]
    assert [k for k, _ in stale] == [30, 130, 230]
    assert stale[0][1] == "no reading for 0.2 s"
    never = ImuListener(Lines(), clock, UNIX_NS, STALE_S)
    never.read()
    clock.advance(300_000_000)
    _, (fault,) = never.read()
    assert "none ever came" in fault.detail


@pytest.mark.parametrize("wrong_s", [-5.0, 5.0])
def test_a_clock_that_does_not_agree_makes_it_stale(wrong_s: float) -> None:
    lines, clock, listener = listening()
    lines.waiting = [line(clock.now_ns() + round(wrong_s * 1e9), 0.1)]
    readings, (fault,) = listener.read()
    assert readings == ()
    assert fault.kind is FaultKind.IMU_STALE
    assert "its clock and ours must agree" in fault.detail


def test_a_stamp_in_another_unit_says_so() -> None:
    lines, _, listener = listening()
    lines.waiting = ["1767225600250 0.1"]
    readings, faults = listener.read()
    assert readings == ()
    assert kinds(faults) == [FaultKind.IMU_BAD]
    assert "UNIX time in seconds" in faults[0].detail


def test_one_that_never_changes_is_stuck_and_not_used() -> None:
    lines, clock, listener = listening()
    used, bad = 0, []
    for k in range(300):
        clock.advance(10_000_000)
        rate = 0.25 if k >= 100 else 0.001 * k
        lines.waiting = [line(clock.now_ns(), rate, 0.01, nan)]
        readings, faults = listener.read()
        used += len(readings)
        bad += [fault for fault in faults if fault.kind is FaultKind.IMU_BAD]
        assert FaultKind.IMU_STALE not in kinds(faults), "it is not silent"
    assert used == 100 + 101
    assert used - 100 > STUCK_READINGS
    assert bad[0].detail.endswith("in a row are the same; it is stuck")
    lines.waiting = [line(clock.now_ns() + 1, 0.3)]
    assert len(listener.read()[0]) == 1, "it moves again"


class Cable:
    """A serial device that can be pulled and plugged in again under the same name."""

    def __init__(self, folder: Path) -> None:
        self.name = folder / "imu"
        self._fds: list[int] = []
        self.plug_in()

    def plug_in(self) -> None:
        master, slave = pty.openpty()
        tty.setraw(slave)
        self._fds = [master, slave]
        self.name.symlink_to(os.ttyname(slave))

    def pull(self) -> None:
        self.name.unlink(missing_ok=True)
        for fd in self._fds:
            os.close(fd)
        self._fds = []

    def print(self, data: bytes) -> None:
        os.write(self._fds[0], data)


def rates(listener: ImuListener) -> list[float]:
    """The next readings; a pseudo-terminal hands bytes over a moment later."""
    for _ in range(2000):
        readings, faults = listener.read()
        assert faults == ()
        if readings:
            return [one.yaw_rate_rad_s for one in readings]
        time.sleep(0.001)
    raise AssertionError("nothing came")


def fault_of(listener: ImuListener) -> Fault:
    """The next fault."""
    for _ in range(2000):
        readings, faults = listener.read()
        assert readings == ()
        if faults:
            return faults[0]
        time.sleep(0.001)
    raise AssertionError("no fault came")


@pytest.fixture
def cable(tmp_path: Path) -> Iterator[Cable]:
    made = Cable(tmp_path)
    yield made
    with contextlib.suppress(OSError):
        made.pull()


def test_split_lines_and_a_pulled_cable(cable: Cable) -> None:
    clock = VirtualClock(start_ns=BEGIN_NS)
    source = SerialLines(str(cable.name), 115_200, "imu", clock)
    listener = ImuListener(source, clock, UNIX_NS, STALE_S)
    assert listener.read() == ((), ())
    whole = [line(BEGIN_NS + k, 0.125 * k).encode() + b"\r\n" for k in range(4)]
    cable.print(whole[0][7:])  # it was opened amid a line
    cable.print(whole[1] + whole[2][:9])
    assert rates(listener) == [0.125]
    cable.print(whole[2][9:])
    assert rates(listener) == [0.25]
    cable.pull()
    assert fault_of(listener).kind is FaultKind.IMU_BAD
    for _ in range(300):  # three seconds without it: two faults a second at most, and no exception
        clock.advance(10_000_000)
        assert len(listener.read()[1]) <= 2
    cable.plug_in()
    clock.advance(2_000_000_000)
    listener.read()
    cable.print(b"torn\n" + line(clock.now_ns(), 0.5).encode() + b"\n")
    assert rates(listener) == [0.5]
    listener.close()


def test_bytes_without_an_end_of_line_are_thrown_away(cable: Cable) -> None:
    clock = VirtualClock(start_ns=BEGIN_NS)
    listener = ImuListener(
        SerialLines(str(cable.name), 9600, "imu", clock), clock, UNIX_NS, STALE_S
    )
    listener.read()
    cable.print(b"\x80" * (LONGEST_LINE + 1))
    assert "check the baud rate" in fault_of(listener).detail
    cable.print(b"\n" + line(BEGIN_NS, 0.25).encode() + b"\n")
    assert rates(listener) == [0.25]
    listener.close()


def test_a_port_that_is_not_there_is_an_error_before_the_run(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be opened"):
        SerialLines(str(tmp_path / "none"), 115_200, "imu.port", VirtualClock())
