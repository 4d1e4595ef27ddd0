"""A long log: its size, and the time and peak memory that each command takes for it.

Ticks of a virtual walk, repeated under new times. Run it with ``python -m benchmarks log_size`` (six
minutes of ticks) or ``python -m benchmarks.log_size 360000`` (an hour); more words choose the commands that
hold one of them (``360000 tum cut import``). Memory is the peak resident size of a process of its own for
each command.
"""

import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

from model.values.tick import Tick
from record.log.writer import LogWriter
from robot.config.robot_file import load_robot
from robot.control.controller import Controller
from robot.run.loop import run
from robot.run.operator import Interrupts, Script, ScriptedOperator
from robot.virtual.open import open_in_memory

PERIOD_NS = 10_000_000
DEFAULT_TICKS = 36_000
# Linux counts the peak of the process that forks to its child, so a small one stands between.
LAUNCHER = """
import os, subprocess, sys
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, usage = os.wait4(child.pid, 0)
print(os.waitstatus_to_exitcode(status), usage.ru_maxrss)
"""
COMMANDS = (
    ("log", "info", "LOG"),
    ("show", "LOG", "--out", "DIR/show.html"),
    ("odom", "LOG"),
    ("log", "export", "LOG", "--format", "trial", "--out", "DIR/trial.parquet"),
    ("log", "export", "LOG", "--format", "parquet", "--out", "DIR/table.parquet"),
    ("log", "export", "LOG", "--format", "csv", "--out", "DIR/table.csv"),
    ("log", "export", "LOG", "--format", "tum", "--out", "DIR/path"),
    ("import", "DIR/trial.parquet", "--out", "DIR/again.parquet"),
    ("log", "export", "LOG", "--format", "trial", "--out", "DIR/trial.csv"),
    ("import", "DIR/trial.csv", "--out", "DIR/again.csv"),
    ("import", "DIR/trial.parquet", "--out", "DIR/again.mcap"),
    ("log", "trim", "LOG", "--to", "60", "--out", "DIR/cut.mcap"),
    ("log", "trim", "LOG", "--from", "1", "--out", "DIR/rest.mcap"),
    ("log", "repair", "LOG", "--out", "DIR/repaired.mcap"),
)


class Collector:
    """A sink that keeps ticks."""

    error = None

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def write(self, tick: Tick) -> None:
        self.ticks.append(tick)


def walked_ticks() -> list[Tick]:
    """Return the ticks of a short virtual walk."""
    config = load_robot()
    rig = open_in_memory(config)
    controller = Controller(config, rig.calibrations, armed=True)
    script = Script("tripod", 0.2, 0.0, cycles=1.0, duration_s=None)
    sink = Collector()
    run(rig, controller, ScriptedOperator(script, Interrupts()), sink, None)
    return sink.ticks


def write_long_log(path: Path, count: int, ticks: list[Tick]) -> None:
    """Write ``count`` ticks: the same walk over and over."""
    config = load_robot()
    writer = LogWriter(
        path,
        names=config.parameters.legs.names,
        config_text=config.text,
        metadata={"robot": config.name, "gait": "tripod", "hardware": "repeated"},
        start_ns=PERIOD_NS,
        start_unix_ns=1_767_225_600_000_000_000,
    )
    for index in range(count):
        tick = ticks[index % len(ticks)]
        writer.write(replace(tick, t_ns=(index + 1) * PERIOD_NS, index=index))
    writer.close()
    if writer.error is not None:
        raise writer.error


def measure(words: tuple[str, ...]) -> tuple[int, float, float]:
    """Run a command; return exit code, wall time [s] and peak resident memory [MB]."""
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", LAUNCHER, sys.executable, "-m", "bigant", *words],
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        cwd=Path(__file__).resolve().parents[1],
    )
    code, peak_kb = map(int, done.stdout.split())
    return code, time.perf_counter() - began, peak_kb / 1e3


def main(count: int = DEFAULT_TICKS, chosen: tuple[str, ...] = ()) -> None:
    """Write a long log and time every command on it."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "long.mcap"
        ticks = walked_ticks()
        began = time.perf_counter()
        write_long_log(log, count, ticks)
        seconds = time.perf_counter() - began
        mine = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
        size = log.stat().st_size
        print(f"{count} ticks, {count / 100:.0f} s at 100 Hz: {size / 1e6:.1f} MB, "
              f"{size / count:.0f} bytes a tick; written in {seconds:.0f} s ({mine:.0f} MB)")  # fmt: skip
        for words in COMMANDS:
            if chosen and not set(chosen) & set(words):
                continue
            filled = tuple(w.replace("LOG", str(log)).replace("DIR", folder) for w in words)
            code, wall_s, peak_mb = measure(filled)
            print(f"{wall_s:8.1f} s  {peak_mb:6.0f} MB  exit {code}  {' '.join(words)}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT_TICKS, tuple(sys.argv[2:]))
