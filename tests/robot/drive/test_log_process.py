"""A process beside a run in virtual time: the same log to the byte; what fails there is said."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from record.log.blocks.read import read_log
from record.log.mcap_file import McapFile
from robot.cli import main as cli
from robot.console import processes
from robot.console.exit_codes import ExitCode
from robot.drive import log_process
from robot.drive.log_process import BesideRun, LogProcess, worth_a_process
from robot.run import loop
from tests.robot.runs import CONFIG
from tests.soaked import soaked
from tests.walk_logs import SHORT

MAGIC = b"\x89MCAP0\r\n"


def drive(path: Path, *words: str) -> int:
    return cli.run(["drive", "--virtual-time", "--log", str(path), *SHORT, *words])


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run is long enough, and there are cores enough."""
    monkeypatch.setattr(log_process, "WORTH_S", 0.0)
    monkeypatch.setattr(log_process, "cores", lambda: 2)


@pytest.mark.parametrize("words", soaked([(), ("--record-bytes",)], bool))
def test_log_and_lines_are_those_of_one_process(
    words: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(loop, "STATE_PERIOD_S", 1)
    monkeypatch.setattr(log_process, "WORTH_S", 0.0)
    said, begun = [], []

    def begin(beside: BesideRun) -> LogProcess:
        begun.append(beside)
        return LogProcess(beside)

    monkeypatch.setattr("robot.drive.drive.LogProcess", begin)
    for folder, count in (("alone", 1), ("beside", 2)):
        monkeypatch.setattr(log_process, "cores", lambda count=count: count)
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        assert drive(Path("walk.mcap"), *words) == ExitCode.OK
        said.append(capfd.readouterr().out)
    assert len(begun) == 1, "only the second run has a process beside it"
    alone, other = (tmp_path / name / "walk.mcap" for name in ("alone", "beside"))
    assert alone.read_bytes() == other.read_bytes()
    assert said[0] == said[1]
    assert "WALK" in said[0], "the view shows the run"
    log = read_log(other)
    assert len(log.estimate_health) == len(log.t_s)


@pytest.mark.usefixtures("beside")
def test_a_log_that_cannot_be_opened_says_so_before_the_robot_moves(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("no folder")
    assert drive(tmp_path / "file" / "walk.mcap") == ExitCode.LOG
    printed = capfd.readouterr()
    assert "cannot be made" in printed.err
    assert "WALK" not in printed.out


@pytest.mark.usefixtures("beside")
def test_a_disk_that_fills_up_brings_the_robot_to_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    flush, times = McapFile.flush, [0]

    def full(self: McapFile) -> None:
        times[0] += 1
        if times[0] > 3:
            raise OSError(28, "No space left on device")
        flush(self)

    monkeypatch.setattr(McapFile, "flush", full)
    monkeypatch.setattr(log_process, "BLOCK_TICKS", 1)
    path = tmp_path / "walk.mcap"
    assert drive(path, "--duration", "20") != ExitCode.OK
    printed = capfd.readouterr()
    assert "stopped (log failed)" in printed.err
    assert "No space left on device" in printed.err
    assert "torque off" in printed.err
    assert "stopping: LOG_FAILED" in printed.out, "the view shows how it comes to rest"
    assert path.stat().st_size > 0


@pytest.mark.usefixtures("beside")
@pytest.mark.parametrize("dies", [True, False])
def test_a_process_that_ends_early_is_told(
    dies: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def end(_scribe: object, _item: object) -> None:
        if dies:
            os.kill(os.getpid(), signal.SIGKILL)
        raise KeyError("a mistake of ours")

    monkeypatch.setattr("robot.drive.log_process._Scribe.take", end)
    assert drive(tmp_path / "walk.mcap") != ExitCode.OK
    printed = capfd.readouterr().err
    assert ("has ended" if dies else "a mistake of ours") in printed
    assert "repair" in printed or "report it" in printed


def test_a_short_run_one_core_or_no_estimator_need_no_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(log_process, "cores", lambda: 2)
    assert worth_a_process(CONFIG, None)
    assert worth_a_process(CONFIG, log_process.WORTH_S)
    assert not worth_a_process(CONFIG, 0.5 * log_process.WORTH_S)
    off = replace(CONFIG, estimator=replace(CONFIG.estimator, enabled=False))
    assert not worth_a_process(off, None)
    monkeypatch.setattr(log_process, "cores", lambda: 1)
    assert not worth_a_process(CONFIG, None)


@pytest.mark.soak
def test_a_run_that_is_killed_leaves_a_whole_log(tmp_path: Path) -> None:
    if processes.cores() < 2:
        pytest.skip("one core: no process beside the run")
    path = tmp_path / "walk.mcap"
    words = ["drive", "--virtual-time", "--log", str(path), "--cycles", "1000"]
    run = subprocess.Popen(
        [sys.executable, "-m", "bigant", *words],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    while not path.exists() or path.stat().st_size < 1_000_000:
        assert run.poll() is None
        time.sleep(0.05)
    run.kill()
    run.wait()
    for _ in range(2000):
        if path.read_bytes().endswith(MAGIC):
            break
        time.sleep(0.05)
    assert path.read_bytes().endswith(MAGIC), "finished by the process that writes it"
    assert len(read_log(path).t_s) > 100
