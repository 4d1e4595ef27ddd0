"""Mutated files through the commands: no traceback, no hang, no memory eaten, an exit code of ours.

``python -m benchmarks.fuzz.files --files 5000`` makes one good file of each kind with the commands
themselves, damages it (bytes, lines, numbers, nesting, cut, empty), and runs a command on it in a process
of its own. A case is bad if it prints a traceback, dies of a signal, ends with a code that is not ours,
computes for longer than 30 s (or takes 120 s on a busy machine), or needs more than 1 GB.
``--case N`` runs one again and prints its output.
"""

import argparse
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.fuzz.damage import damaged

LONGEST_S = 30.0  # of processor time ...
LONGEST_WALL_S = 120.0  # ... and on the clock of a busy machine
MOST_BYTES = 1_000_000_000
CODES = frozenset({0, 1, 2, 3, 4})
ALONE = ("gap", "diagnose", "--alone", "FILE")


@dataclass(frozen=True, slots=True)
class Target:
    """A command and the file of it that is damaged.

    Attributes:
        file: Name of the good file.
        words: Arguments; FILE stands for the damaged file, OUT for a new one.
        weight: How often it is drawn: a slow command less.
    """

    file: str
    words: tuple[str, ...]
    weight: float = 1.0

    def command(self, file: str, out: str) -> list[str]:
        """Return the arguments with the names of the damaged file and of the new one."""
        return [file if word == "FILE" else word.replace("OUT", out) for word in self.words]


@dataclass(frozen=True, slots=True)
class Ending:
    """How one run ended.

    Attributes:
        code: Exit code; negative for a signal.
        seconds: Processor time [s].
        peak_bytes: Largest memory.
        output: What it printed.
    """

    code: int
    seconds: float
    peak_bytes: int
    output: str

    @property
    def last(self) -> str:
        """The last line that it printed."""
        return (self.output.strip().splitlines() or [""])[-1]

    @property
    def bad(self) -> str:
        """What must not be, in words; empty if it is well."""
        if "Traceback (most recent call last)" in self.output:
            return "traceback"
        if self.seconds > LONGEST_S:
            return "hang"
        if self.code not in CODES:
            return f"exit code {self.code}"
        if self.peak_bytes > MOST_BYTES:
            return "memory"
        if self.code and not self.output.strip():
            return "no word"
        return ""


LISTEN = ("drive", "--virtual-time", "--readonly", "--duration", "0.3", "--log", "none")
DRIVE = ("drive", "--virtual-time", "--duration", "0.3", "--log", "none")
QUICK = ("--seconds", "1", "--fast", "--out", "a.csv")
TARGETS = (
    Target("robot.toml", (*LISTEN, "--robot", "FILE"), 3.0),
    Target("robot.toml", (*DRIVE, "--robot", "FILE"), 0.2),
    Target("robot.toml", ("check", "--robot", "FILE"), 0.3),
    Target("robot.toml", ("robot", "export", "--robot", "FILE", "--mjcf", "OUT.xml")),
    Target("robot.toml", ("model", "run", "bigant", "--robot", "FILE", "--cycles", "1", "--json")),
    Target("robot.toml", ("odom", "walk.mcap", "--robot", "FILE", "--json")),
    Target("robot.toml", ("replay", "walk.mcap", "--robot", "FILE", "--json")),
    Target("robot.toml", ("sim", "run", "--robot", "FILE", *QUICK), 0.3),
    Target("servo.toml", (*LISTEN, "--scenario", "FILE"), 2.0),
    Target("servo.toml", (*DRIVE, "--scenario", "FILE"), 0.2),
    Target("force.toml", (*LISTEN, "--scenario", "FILE")),
    Target("calibration.toml", (*LISTEN, "--calibration", "FILE"), 2.0),
    Target("campaign.toml", ("campaign", "make", "FILE", "--out", "OUT", "--jobs", "1"), 0.5),
    Target("walk.mcap", ("log", "info", "FILE"), 2.0),
    Target("walk.mcap", ("log", "info", "FILE", "--json")),
    Target("walk.mcap", ("log", "repair", "FILE", "--out", "OUT.mcap"), 2.0),
    Target("walk.mcap", ("log", "trim", "FILE", "--from", "0.5", "--to", "1", "--out", "OUT.mcap")),
    Target("walk.mcap", ("log", "merge", "walk.mcap", "FILE", "--out", "OUT.mcap")),
    Target("walk.mcap", ("log", "export", "FILE", "--format", "trial", "--out", "OUT.parquet")),
    Target("walk.mcap", ("log", "export", "FILE", "--format", "csv", "--out", "OUT.csv")),
    Target("walk.mcap", ("log", "export", "FILE", "--format", "tum", "--out", "OUT.tum")),
    Target("walk.mcap", ("show", "FILE", "--json"), 2.0),
    Target("walk.mcap", ("show", "FILE", "--out", "OUT.html"), 0.5),
    Target("walk.mcap", ("replay", "FILE", "--json"), 2.0),
    Target("bytes.mcap", ("replay", "FILE", "--bus", "--json"), 2.0),
    Target("walk.mcap", ("replay", "FILE", "--drive", "--virtual-time", "--log", "OUT.mcap"), 0.05),
    Target("walk.mcap", ("odom", "FILE", "--json"), 2.0),
    Target("walk.mcap", ("odom", "FILE", "--compare", "--out", "OUT.tum"), 1.0),
    Target("walk.mcap", ("sim", "render", "FILE", "--out", "OUT.png"), 0.5),
    Target("walk.mcap", ("view", "FILE", "--save", "OUT.mcap"), 0.5),
    Target("walk.mcap", ("force", "calibrate", "FILE", "--out", "OUT.toml"), 0.5),
    Target("walk.mcap", ("model", "sensitivity", "FILE", "--json"), 0.3),
    Target("trial.parquet", ("import", "FILE", "--out", "OUT.mcap"), 2.0),
    Target("trial.toml", ("import", "FILE", "--out", "OUT.mcap"), 2.0),
    Target("table.csv", ("import", "FILE", "--map", "map.toml", "--out", "OUT.mcap"), 2.0),
    Target("map.toml", ("import", "table.csv", "--map", "FILE", "--out", "OUT.mcap"), 2.0),
    Target("trial.toml", (*ALONE, "--effect", "friction_level", "--json"), 0.3),
    Target("trial.parquet", (*ALONE, "--effect", "friction_level", "--json"), 0.3),
    Target("diagnosis.json", ("gap", "apply", "FILE", "--out", "OUT.toml", "--anyway")),
    Target("diagnosis.json", ("gap", "next", "FILE", "--json"), 0.3),
    Target("effects.py", ("gap", "effects", "--effects", "FILE"), 0.2),
    Target("servos.toml", ("servo", "restore", "FILE", "--port", "/nowhere", "--yes")),
)  # fmt: skip


def make_good_files(folder: Path, repository: Path) -> None:
    """Make one good file of each kind in a folder, by the commands that make them."""

    def bigant(*words: str) -> None:
        command = [sys.executable, "-m", "bigant", *words]
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)

    shutil.copy(repository / "config" / "bigant.toml", folder / "robot.toml")
    shutil.copy(repository / "config" / "bigant.toml", folder / "bigant.toml")
    shutil.copy(repository / "examples" / "faults_servo.toml", folder / "servo.toml")
    shutil.copy(repository / "examples" / "faults_force.toml", folder / "force.toml")
    shutil.copy(repository / "examples" / "worn_crank.py", folder / "effects.py")
    walk = ("drive", "--virtual-time", "--duration", "1.5", "--robot", "robot.toml")
    for name, more in (("walk", ()), ("bytes", ("--record-bytes",))):
        bigant(*walk, "--log", f"{name}_whole.mcap", *more)
        bigant("log", "trim", f"{name}_whole.mcap", "--to", "3", "--out", f"{name}.mcap")
    bigant(
        "force", "calibrate", "--hardware", "virtual", "--rounds", "1", "--out", "calibration.toml"
    )
    bigant("log", "export", "walk.mcap", "--format", "trial", "--out", "trial.parquet")
    bigant("log", "export", "walk.mcap", "--format", "trial", "--out", "table.csv")
    (folder / "map.toml").write_text(_column_map(folder / "table.csv"), encoding="utf-8")
    (folder / "table.toml").unlink()
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    _back_up(folder)
    sim = ("sim", "run", "--gait", "tripod", "--fast", "--seconds", "10")
    bigant(*sim, "--effect", "foot_friction@ML:ratio=0.5", "--out", "worn.parquet")
    bigant(*sim, "--seed", "2", "--out", "healthy.parquet")
    words = ("gap", "diagnose", "worn.parquet", "--reference", "healthy.parquet")
    subprocess.run(
        [sys.executable, "-m", "bigant", *words, "--json", "diagnosis.json"],
        cwd=folder,
        check=False,  # what it finds is of no interest here
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


CAMPAIGN = """\
[campaign]
seed = 1
seconds = 1.0
robots = ["bigant.toml"]
[conditions]
gaits = ["tripod"]
frequencies_hz = [0.15]
steer = [0.0]
[references]
count = 1
[cases]
controls = 1
effects = ["com_offset"]
severities = [[0.7, 1.0]]
repeats = 1
pairs = 0
outside = 0
"""


def _column_map(table: Path) -> str:
    """Return a map that takes every column of a table under its own name."""
    head = table.read_text(encoding="utf-8").split("\n", 1)[0]
    names = [name.strip('"') for name in head.split(",")]
    robot = '[trial]\nrobot = "robot.toml"\ngait = "tripod"\n'
    return "[columns]\n" + "".join(f'{name} = "{name}"\n' for name in names) + robot


def _back_up(folder: Path) -> None:
    """Back up the servos of a served virtual robot."""
    command = [sys.executable, "-u", "-m", "bigant"]
    serve = subprocess.Popen(
        [*command, "sim", "serve", "--no-force-unit"], cwd=folder, stdout=subprocess.PIPE, text=True
    )
    try:
        assert serve.stdout is not None
        port = next(m[0] for m in (re.search(r"/dev/pts/\d+", line) for line in serve.stdout) if m)
        words = ["servo", "backup", "--port", port, "--baud", "1000000", "--out", "servos.toml"]
        subprocess.run([*command, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    finally:
        serve.terminate()
        serve.communicate()


def prepare() -> None:
    """Import what commands import, so that a child of this process begins at once."""
    import importlib

    for name in PRELOADED:
        importlib.import_module(name)


PRELOADED = (
    "robot.cli.main", "robot.drive.drive", "robot.report.show", "robot.replay.command",
    "robot.odometry.command", "robot.virtual.open", "gap.diagnosis.diagnose", "record.log.reader",
    "matplotlib.figure", "scipy.optimize", "duckdb", "mujoco",
)  # fmt: skip


def run_one(words: Sequence[str], folder: Path) -> Ending:
    """Run a command in a child of this process."""
    output = folder / "output.txt"
    began = time.monotonic()
    child = os.fork()
    if not child:
        _be_the_command(words, folder, output)
    while True:
        pid, status, usage = os.wait4(child, os.WNOHANG)
        if pid:
            break
        if time.monotonic() - began > LONGEST_WALL_S:
            os.kill(child, signal.SIGKILL)
        time.sleep(0.005)
    seconds = usage.ru_utime + usage.ru_stime
    code = os.waitstatus_to_exitcode(status)
    text = output.read_text(encoding="utf-8", errors="replace")
    return Ending(code, seconds, usage.ru_maxrss * 1024, text)


def _be_the_command(words: Sequence[str], folder: Path, output: Path) -> None:
    """Become the command; does not return."""
    code = 70
    try:
        os.chdir(folder)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        descriptor = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.dup2(descriptor, 1)
        os.dup2(descriptor, 2)
        from robot.cli.main import run

        try:
            code = run(words)
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
    except Exception:  # noqa: BLE001  # what the command lets through is what we look for
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def run_case(case: int, seed: int, folder: Path) -> tuple[Target, Ending]:
    """Damage a file as the case's number says and run its command."""
    source = random.Random(f"{seed} {case}")
    weights = [target.weight for target in TARGETS]
    target = source.choices(TARGETS, weights)[0]
    good = folder / target.file
    bad = folder / f"damaged_{case}{good.suffix}"
    bad.write_bytes(damaged(good.read_bytes(), source))
    beside = good.with_suffix(".toml")
    if good.suffix == ".parquet" and beside.exists():
        shutil.copy(beside, bad.with_suffix(".toml"))
    if target.file == "trial.toml":
        shutil.copy(folder / "trial.parquet", bad.with_suffix(".parquet"))
    ending = run_one(target.command(bad.name, f"out_{case}"), folder)
    for left in [
        *folder.glob(f"out_{case}*"),
        *folder.glob(f"damaged_{case}*"),
        *folder.glob("a.*"),
    ]:
        shutil.rmtree(left) if left.is_dir() else left.unlink()
    return target, ending


def main() -> None:
    """Run the cases and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", type=int, help="run this one again and print what it said")
    parser.add_argument("--good", action="store_true", help="run each command on its good file")
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    options = parser.parse_args()
    repository = Path(__file__).resolve().parents[2]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_good_files(folder, repository)
        prepare()
        if options.good:
            for number, target in enumerate(TARGETS):
                words = target.command(target.file, f"out_{number}")
                ending = run_one(words, folder)
                print(
                    f"{ending.code} {ending.seconds:.1f} s {ending.peak_bytes / 1e6:.0f} MB "
                    f"{' '.join(words)}: {ending.bad} {ending.last[:120]}",
                    flush=True,
                )
            return
        if options.case is not None:
            target, ending = run_case(options.case, options.seed, folder)
            print(target, ending.code, f"{ending.seconds:.1f} s", ending.output, sep="\n")
            return
        _run_all(options.first, options.files, options.seed, folder)


def _run_all(first: int, files: int, seed: int, folder: Path) -> None:
    codes: Counter[int] = Counter()
    slowest, largest, bad = 0.0, 0, 0
    for case in range(first, first + files):
        target, ending = run_case(case, seed, folder)
        codes[ending.code] += 1
        slowest, largest = max(slowest, ending.seconds), max(largest, ending.peak_bytes)
        if ending.bad:
            bad += 1
            print(f"case {case}: {ending.bad}: {' '.join(target.words)}: {ending.last}", flush=True)
        if case % 250 == 249:
            print(f"{case + 1} files, {bad} bad", flush=True)
    print(f"{files} files, {bad} bad; exit codes {dict(sorted(codes.items()))}; "
          f"slowest {slowest:.1f} s, most memory {largest / 1e6:.0f} MB")  # fmt: skip


if __name__ == "__main__":
    main()
