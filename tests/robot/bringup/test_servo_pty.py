"""Every servo command through a real pseudo-terminal with a process at its other end."""

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from robot.cli import main as cli
from robot.console.exit_codes import ExitCode
from tests.robot.light_servos import LightServos
from tests.robot.sim_serve import ForkedSim, Sim

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def port() -> Iterator[str]:
    servos = LightServos()
    yield servos.port
    servos.close()


@pytest.fixture(autouse=True)
def few_ids(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scan waits for the last id of a hundred, 0.3 s, and not for those of all ids."""
    monkeypatch.setattr("drivers.dynamixel.scan.IDS", 100)


def servo(*words: str) -> int:
    return cli.run(["servo", *words])


def scan(port: str, *words: str) -> int:
    return cli.run(["devices", "--discover", "none", "--port", port, *words])


def test_scan(port: str, capsys: Capture) -> None:
    assert scan(port, "--baud", "1000000", "--json") == ExitCode.OK
    found = json.loads(capsys.readouterr().out)["servos"]
    assert [s["servo_id"] for s in found] == [1, 2, 3, 4, 5, 6]
    assert scan(port, "--baud", "57600") == ExitCode.VERDICT_FAILED


def test_scan_of_bigant_sim_serve(capsys: Capture) -> None:
    sim = ForkedSim("--no-force-unit", "--absent", "2")
    try:
        assert scan(sim.port, "--baud", "1000000", "--json") == ExitCode.OK
    finally:
        sim.close()
    found = json.loads(capsys.readouterr().out)["servos"]
    assert [s["servo_id"] for s in found] == [1, 3, 4, 5, 6]


def test_setup_talks_at_the_new_baud_rate(port: str, capsys: Capture) -> None:
    """The baud rate of the terminal itself is what the virtual servos hear at."""
    there = ["setup", "--port", port, "--id", "4", "--new-baud", "2000000"]
    assert servo(*there, "--baud", "1000000", "--yes") == ExitCode.OK
    assert "4 (2000000 baud)" in capsys.readouterr().out
    back = ["setup", "--port", port, "--id", "4", "--baud", "2000000", "--yes"]
    assert servo(*back) == ExitCode.OK
    assert "3 (1000000 baud)" in capsys.readouterr().out


@pytest.mark.soak
def test_backup_and_restore(port: str, tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "servos.toml"
    common = ["--port", port, "--baud", "1000000"]
    assert servo("backup", *common, "--out", str(path)) == ExitCode.OK
    path.write_text(path.read_text().replace("position_p_gain = 850", "position_p_gain = 800", 1))
    assert servo("restore", str(path), *common) == ExitCode.VERDICT_FAILED
    assert "position_p_gain  850    800" in capsys.readouterr().out
    assert servo("restore", str(path), *common, "--yes") == ExitCode.OK
    assert servo("restore", str(path), *common) == ExitCode.OK


def test_zero(port: str, capsys: Capture) -> None:
    assert servo("zero", "--port", port) == ExitCode.OK
    assert "servo_zero = [" in capsys.readouterr().out


def test_watch(port: str, capsys: Capture) -> None:
    assert servo("watch", "--port", port, "--seconds", "1") in {ExitCode.OK, ExitCode.HARDWARE}
    printed = capsys.readouterr().out
    assert "degC" in printed
    assert "round trip of complete reads" in printed


def test_reboot(port: str, capsys: Capture) -> None:
    assert servo("reboot", "--port", port, "--id", "all") == ExitCode.OK
    assert capsys.readouterr().out.count("torque off") == 6


@pytest.mark.soak
def test_a_background_job_that_ignores_sigint_can_still_be_stopped() -> None:
    # what a shell without job control does to the programs it starts with &
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        sim = Sim()
    finally:
        signal.signal(signal.SIGINT, before)
    sim.close()
    assert sim.process.returncode == 0
