"""Driving from the keyboard: what each key means, and the real thing through a pseudo-terminal."""

import contextlib
import os
import pty
import select
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pyte
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from model.values.faults import StopReason
from model.values.tick import Intent, Request
from robot.control.controller import Controller
from robot.run.operator import Interrupts
from robot.run.teleop import KeyboardOperator, KeyParser, Keys, help_line, press
from tests.robot.runs import CONFIG

BOOK = Controller(CONFIG, (), armed=False).book
START = Request(Intent.STAND, "tripod", 0.1, 0.0, StopReason.NONE)
ROOT = Path(__file__).resolve().parents[3]


def typed(text: str, wish: Request = START) -> Request:
    for key in text:
        wish = press(wish, key, BOOK)
    return wish


def test_what_the_keys_mean() -> None:
    assert typed("g").intent is Intent.WALK
    assert typed("gh").intent is Intent.STAND
    assert typed("g ").intent is Intent.STAND
    assert typed("q").intent is Intent.STOP
    assert typed("x").intent is Intent.CUT
    assert typed("aaa").steer == pytest.approx(0.3)
    assert typed("ddddd").steer == pytest.approx(-0.5)
    assert typed("aaac").steer == 0.0
    assert typed("2").gait == "metachronal"
    assert typed("ww").frequency_hz == pytest.approx(0.12)
    assert typed("?zZ9") == START, "a key that means nothing changes nothing"


def test_number_keys_are_the_gaits_in_the_order_of_the_robot_file() -> None:
    names = [f"gait{number}" for number in range(11)]
    gaits = tuple(replace(CONFIG.parameters.gaits[0], name=name) for name in names)
    many = replace(CONFIG, parameters=replace(CONFIG.parameters, gaits=gaits))
    book = Controller(many, (), armed=False).book
    wish = replace(START, gait="gait0")
    assert [press(wish, key, book).gait for key in "123456789"] == names[:9]
    assert press(wish, "0", book) == wish
    assert "  1 gait0  2 gait1  3 gait2  " in help_line(book)
    assert "  1 tripod  2 metachronal  q stop" in help_line(BOOK)


def test_no_key_asks_for_more_than_the_servos_can_do() -> None:
    assert not BOOK.refuses(typed("g" + "w" * 200))
    assert not BOOK.refuses(typed("g" + "w" * 200 + "2"))
    assert not BOOK.refuses(typed("g" + "s" * 200))
    assert typed("a" * 50).steer == 1.0


class Typed:
    """Keys that come at set times."""

    def __init__(self) -> None:
        self.waiting: list[str] = []
        self.ended = False

    def read(self) -> list[str]:
        keys, self.waiting = self.waiting, []
        return keys


def operator(keys: Typed, interrupts: Interrupts | None = None) -> KeyboardOperator:
    return KeyboardOperator(keys, START, BOOK, interrupts or Interrupts(), deadman_s=2.0)  # type: ignore[arg-type]


def test_a_robot_whose_driver_has_gone_stands() -> None:
    keys = Typed()
    driver = operator(keys)
    keys.waiting = ["g"]
    assert driver.request(None, 0).intent is Intent.WALK
    assert driver.request(None, 1_900_000_000).intent is Intent.WALK
    keys.waiting = ["w"]
    driver.request(None, 1_950_000_000)
    assert driver.request(None, 3_900_000_000).intent is Intent.WALK
    assert driver.request(None, 4_000_000_000).intent is Intent.STAND


def test_a_terminal_that_closes_is_a_stop() -> None:
    keys = Typed()
    driver = operator(keys)
    keys.waiting = ["g"]
    driver.request(None, 0)
    keys.ended = True
    request = driver.request(None, 1)
    assert (request.intent, request.reason) == (Intent.STOP, StopReason.OPERATOR)


def test_after_a_stop_only_the_emergency_key_counts() -> None:
    keys = Typed()
    driver = operator(keys)
    keys.waiting = ["q", "g"]
    assert driver.request(None, 0).intent is Intent.STOP
    keys.waiting = ["x"]
    request = driver.request(None, 1)
    assert (request.intent, request.reason) == (Intent.CUT, StopReason.EMERGENCY)


def test_interrupts_count_before_keys() -> None:
    keys, interrupts = Typed(), Interrupts()
    driver = operator(keys, interrupts)
    interrupts.count = 1
    assert driver.request(None, 0).intent is Intent.STOP
    interrupts.count = 2
    assert driver.request(None, 1).intent is Intent.CUT


def test_keys_from_a_terminal_and_the_terminal_put_back() -> None:
    import termios

    master, slave = pty.openpty()
    try:
        before = termios.tcgetattr(slave)
        with os.fdopen(slave, "r", closefd=False) as stream, Keys(stream) as keys:
            os.write(master, b"g\x1b[A\x1b[Dq")
            deadline = time.monotonic() + 5
            seen: list[str] = []
            while len(seen) < 4 and time.monotonic() < deadline:
                seen += keys.read()
            assert seen == ["g", "w", "a", "q"], "arrows are w, s, a, d"
        assert termios.tcgetattr(slave) == before
    finally:
        os.close(master)
        os.close(slave)


@pytest.mark.soak
def test_a_drive_through_a_pseudo_terminal() -> None:
    """A terminal as over SSH: walk, steer, stand, quit; the screen says what is going on."""
    pid, master = pty.fork()
    if pid == 0:
        os.chdir(ROOT)
        os.environ["TERM"] = "xterm"
        os.execv(
            sys.executable,
            [sys.executable, "-m", "bigant", "drive", "--teleop", "--deadman", "60",
             "--frequency-hz", "0.2", "--log", "none"],
        )  # fmt: skip
    screen = pyte.Screen(120, 40)
    stream = pyte.ByteStream(screen)

    def wait_for(words: str, seconds: float = 90) -> None:
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if select.select([master], [], [], 0.1)[0]:
                try:
                    stream.feed(os.read(master, 65536))
                except OSError:
                    break
            if any(words in line for line in screen.display):
                return
        raise AssertionError(f"{words!r} never came:\n" + "\n".join(screen.display))

    try:
        wait_for("mode HOLD")
        os.write(master, b"ga")
        wait_for("mode WALK")
        wait_for("predicted")
        assert any("EMERGENCY" in line for line in screen.display), "the keys are on the screen"
        os.write(master, b"h")
        wait_for("mode HOLD")
        os.write(master, b"q")
        wait_for("done (operator), torque off")
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGTERM)
        _, status = os.waitpid(pid, 0)
        os.close(master)
    # the signal may find it already at its end, or leaving
    assert os.waitstatus_to_exitcode(status) in {0, 128 + signal.SIGTERM, -signal.SIGTERM}


@pytest.mark.soak
def test_teleop_without_a_terminal_says_so() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "bigant", "drive", "--teleop", "--virtual-time", "--log", "none"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert done.returncode == 2
    assert "needs a terminal" in done.stderr


@pytest.mark.parametrize(
    ("pieces", "keys"),
    [
        (["\x1b[A\x1b[B\x1b[D\x1b[C"], "wsad"),
        (["\x1bOA\x1bOB\x1bOD\x1bOC"], "wsad"),  # application cursor mode
        (["\x1b[", "D"], "a"),  # split on the way
        (["\x1b", "[", "D"], "a"),
        (["\x1b", "OD"], "a"),
        (["\x1b[1;5D"], ""),  # Ctrl+Left
        (["\x1b[1;2D", "\x1b[2~", "\x1b[3~", "\x1bOP", "\x1b[[A", "\x1b[15~"], ""),
        (["\x1b[1", ";5", "D"], ""),
        (["\x1b[[", "A"], ""),  # F1 of the Linux console, split on the way
        (["\x1bd", "\x1b1"], ""),  # with Alt
        (["\x1b", "x"], "x"),  # Esc, and then the emergency key
        (["\x1b", "\x1b", "q"], "q"),
        (["\x1b[200~www.goo", "gle\x1b[201~h"], "h"),
        (["www.google.com/search"], ""),  # pasted into a terminal that does not mark it
        (["gww"], "gww"),
    ],
)
def test_only_whole_sequences_that_are_known_are_keys(pieces: list[str], keys: str) -> None:
    parser = KeyParser()
    assert "".join(key for piece in pieces for key in parser.keys(piece)) == keys


@given(st.text(alphabet="\x1b[O;15~ABCD", max_size=12), st.integers(0, 12))
@example("1111\x1b[[A", 7)
@settings(max_examples=1000)
def test_where_a_sequence_is_split_makes_no_difference(text: str, at: int) -> None:
    assume(not text[:at].endswith("\x1b"))  # Esc by itself, or the beginning of something
    whole, pieces = KeyParser(), KeyParser()
    assert whole.keys(text) == pieces.keys(text[:at]) + pieces.keys(text[at:])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_the_program_while_devices_are_being_opened(number: signal.Signals) -> None:
    before = signal.signal(number, signal.default_int_handler)
    try:
        with Interrupts(), pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
        with Interrupts() as interrupts:
            interrupts.begin()
            signal.raise_signal(number)
            assert interrupts.count == 1
    finally:
        signal.signal(number, before)
