"""``bigant sim serve`` in a process: the pseudo-terminal and the sockets are real.

``Sim`` starts the command as a shell does. ``ForkedSim`` is a copy of the process of the tests, in which
everything is imported and compiled already: the same devices without the three seconds of a start.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import IO, TypeVar

from robot.console.arguments import DEFAULT_ROBOT_FILE

ROOT = Path(__file__).resolve().parents[2]
# Limits of a host that does little else; a machine that runs tests may keep a process waiting for a second.
PATIENCE = (
    ("watchdog = 0.24 ", "watchdog = 2.4 "),
    ("silent_limit = 5 ", "silent_limit = 200 "),
    ("silent_limit = 0.5 ", "silent_limit = 30.0 "),
    ("late_ticks = 20 ", "late_ticks = 1000 "),
    ("max_following_error = 0.6 ", "max_following_error = 3.0 "),
)
WATCHDOG_S = 2.4
T = TypeVar("T")


def patient_robot(folder: Path) -> str:
    """Write BigANT's robot file with limits that a busy machine keeps in real time; return its path."""
    text = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    for old, new in PATIENCE:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "patient.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


class Sim:
    """``bigant sim serve`` as a command."""

    def __init__(self, *words: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "bigant", "sim", "serve", *words],
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        assert self.process.stdout is not None
        self.said = self.process.stdout
        self.port, self.unit, self.imu = read_places(self.said)

    def close(self) -> None:
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(20)
        finally:  # one that lives on would slow down every test after this one
            self.process.kill()
            self.process.wait()
            self.said.close()


class ForkedSim:
    """``bigant sim serve`` in a copy of this process."""

    def __init__(self, *words: str) -> None:
        self.process, self.said = forked(_serve, words)
        self.port, self.unit, self.imu = read_places(self.said)

    def close(self) -> None:
        assert self.process.pid is not None
        os.kill(self.process.pid, signal.SIGINT)
        try:
            self.process.join(20)
            assert self.process.exitcode == 0
        finally:
            self.process.kill()
            self.process.join()
            self.said.close()


def forked(
    serve: Callable[[int, tuple[T, ...]], None], words: tuple[T, ...]
) -> tuple[BaseProcess, IO[str]]:
    """Start a copy of this process that serves, and return it with what it says.

    Args:
        serve: Gets where to write that, and the words.
        words: What is to be served.
    """
    reading, writing = os.pipe()
    process = get_context("fork").Process(target=serve, args=(writing, words), daemon=True)
    process.start()
    os.close(writing)
    return process, os.fdopen(reading)


def _serve(writing: int, words: tuple[str, ...]) -> None:
    from robot.cli.main import run

    signal.signal(signal.SIGINT, signal.default_int_handler)
    with os.fdopen(writing, "w") as out:
        sys.stdout = out
        raise SystemExit(run(["sim", "serve", *words]))


def read_places(said: IO[str]) -> tuple[str, str, str]:
    """Return where servos, force unit and IMU are; the last is empty where there is none."""
    port = said.readline().split()[2]
    unit = said.readline().split()[2]
    name, _, place = said.readline().partition(" ")
    return port, unit, place.strip() if name == "imu" else ""
