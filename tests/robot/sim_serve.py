"""``bigant sim serve`` in a process: the pseudo-terminal and the sockets are real."""

import signal
import subprocess
import sys
from pathlib import Path

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
    """``bigant sim serve`` in a process."""

    def __init__(self, *words: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "bigant", "sim", "serve", *words],
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        assert self.process.stdout is not None
        self.port = self.process.stdout.readline().split()[2]
        self.unit = self.process.stdout.readline().split()[2]
        name, _, place = self.process.stdout.readline().partition(" ")
        self.imu = place.strip() if name == "imu" else ""

    def close(self) -> None:
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(20)
        finally:  # one that lives on would slow down every test after this one
            self.process.kill()
            self.process.wait()
            assert self.process.stdout is not None
            self.process.stdout.close()
