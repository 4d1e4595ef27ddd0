"""Scenarios as a person uses them: ``drive --scenario``, ``sim serve --scenario``, ``sim faults``."""

import json
import socket
from pathlib import Path

import pytest
import serial

from drivers.ati.packets import UnitCommand, build_command
from drivers.dynamixel.frames import build_status
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from sim_hw.faults.kinds import KINDS
from tests.robot.cli.test_cli import ROOT, bigant
from tests.robot.sim_serve import ForkedSim
from tests.walk_logs import SHORT

FORCE_EXAMPLE = str(ROOT / "examples" / "faults_force.toml")
BOTH = """
seed = 5
begins = "torque"
[[fault]]
kind = "bit_flip"
start_s = 0.5
rate = 0.01
[[fault]]
kind = "saturation"
transducer = 5
[[fault]]
kind = "packet_loss"
rate = 0.1
"""


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    path = tmp_path / "both.toml"
    path.write_text(BOTH, encoding="utf-8")
    return path


def test_a_drive_in_virtual_time_meets_the_faults_the_same_way_twice(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = [tmp_path / "1.mcap", tmp_path / "2.mcap"]
    robot = tmp_path / "robot.toml"
    text = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    robot.write_text(f"{text}\n[estimator]\nenabled = false\n", encoding="utf-8")
    words = ["drive", "--virtual-time", "--robot", str(robot), "--scenario", str(scenario)]
    for log in logs:
        assert bigant(*words, "--log", str(log), *SHORT) == ExitCode.OK
    printed = capsys.readouterr().out
    for kind in ("FORCE_SATURATED in", "FORCE_GAP in", "SERVO_SILENT in"):
        assert kind in printed.splitlines()[-2]
    assert logs[0].read_bytes() == logs[1].read_bytes()


def test_a_drive_in_real_time_meets_the_faults(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A cable that can be pulled is a port with a name of its own, and from the start it is out."""
    path = tmp_path / "unplugged.toml"
    path.write_text('[[fault]]\nkind = "unplug"\n', encoding="utf-8")
    assert bigant("drive", "--scenario", str(path), "--log", "none") == ExitCode.HARDWARE
    error = capsys.readouterr().err.strip()
    assert "/servo_bus" in error
    # on a busy machine it says before that it is starting the virtual robot
    assert [line.startswith("bigant drive: ") for line in error.splitlines()].count(True) == 1


def test_served_devices_have_the_faults(tmp_path: Path) -> None:
    """Asked with bare bytes: what comes does not depend on how busy the computer is."""
    path = tmp_path / "twice.toml"
    text = '[servo]\nfirmware = 46\n[[fault]]\nkind = "duplicated_reply"\n'
    path.write_text(text + '[[fault]]\nkind = "duplicate_packet"\n', encoding="utf-8")
    sim = ForkedSim("--scenario", str(path))
    try:
        with serial.Serial(sim.port, 1_000_000, timeout=20.0) as port:
            port.write(bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E"))
            heard = port.read(28)
        assert heard == 2 * build_status(1, 0, bytes.fromhex("41 01 2E"))
        host, udp_port, _ = sim.unit.split(":")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as unit:
            unit.settimeout(20.0)
            unit.sendto(build_command(UnitCommand.START, 2), (host, int(udp_port)))
            first, again, second = (unit.recv(2048) for _ in range(3))
        assert first == again
        assert int.from_bytes(second[4:8], "big") == int.from_bytes(first[4:8], "big") + 1
    finally:
        sim.close()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["drive", "--hardware", "/dev/none", "--scenario", FORCE_EXAMPLE], "needs --hardware virtual"),
        (["drive", "--scenario", "/none.toml"], "/none.toml: the scenario cannot be read"),
        (["drive", "--virtual-time", "--scenario", "/dev/null/x"], "the scenario cannot be read"),
        (["sim", "serve", "--scenario", "/none.toml"], "/none.toml: the scenario cannot be read"),
    ],
)  # fmt: skip
def test_wrong_use_is_one_clear_line(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bigant(*words) == ExitCode.USAGE
    error = capsys.readouterr().err.strip()
    assert said in error
    assert len(error.splitlines()) == 1


def test_the_faults_are_listed_with_units(capsys: pytest.CaptureFixture[str]) -> None:
    assert bigant("sim", "faults") == ExitCode.OK
    printed = capsys.readouterr().out
    assert "  late_reply *: The reply arrives late" in printed
    assert "delay_s [s]" in printed
    assert "acts on force unit: each datagram" in printed
    assert max(len(line) for line in printed.splitlines()) <= 100
    assert bigant("sim", "faults", "--json") == ExitCode.OK
    listed = json.loads(capsys.readouterr().out)
    assert [fault["kind"] for fault in listed["faults"]] == list(KINDS)
    assert [table["name"] for table in listed["tables"]] == [
        "",
        "servo",
        "force_unit",
        "adapter",
        "imu",
    ]
