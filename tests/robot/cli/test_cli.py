"""The command as a person types it, right and wrong: one clear line, an exit code, torque off."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from model.errors import BusError
from record.log.blocks.read import read_log
from robot.cli import main as cli
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from tests.robot.browser import without_scripts
from tests.robot.sim_serve import WATCHDOG_S, ForkedSim, Sim, patient_robot
from tests.walk_logs import SHORT

ROOT = Path(__file__).resolve().parents[3]


def bigant(*words: str) -> int:
    return cli.run([str(w) for w in words])


def test_a_drive_prints_distance_speed_and_slip_and_gives_the_same_bytes_each_time(
    short_walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    path = tmp_path / "new" / "walk.mcap"
    assert bigant("drive", "--virtual-time", "--log", str(path), *SHORT) == ExitCode.OK
    printed = capsys.readouterr().out
    for words in ("done (completed), torque off", "distance", "mean speed", "slip", str(path)):
        assert words in printed
    assert "\x1b" not in printed, "plain lines when the output is no terminal"
    assert path.read_bytes() == short_walk.read_bytes()


def test_another_seed_gives_other_bytes(tmp_path: Path) -> None:
    logs = []
    for name, seed in (("a", "0"), ("b", "0"), ("c", "1")):
        path = tmp_path / f"{name}.mcap"
        words = ["--readonly", "--duration", "0.1", "--seed", seed, "--log", str(path)]
        assert bigant("drive", "--virtual-time", *words) == ExitCode.OK
        logs.append(path.read_bytes())
    assert logs[0] == logs[1] != logs[2]


def test_show_prints_and_draws(short_walk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert bigant("show", str(short_walk)) == ExitCode.OK
    printed = capsys.readouterr().out
    assert "predicted velocity, RMSE" in printed
    page = short_walk.with_suffix(".html").read_text(encoding="utf-8")
    assert page.count("<figure class='plot'>") == 4
    assert page.count("<figure class='replay'>") == 1
    assert "Body velocity" in page
    still = without_scripts(page)  # moving pages: tests/robot/report/test_moving_pages.py
    assert "src=" not in still, "self-contained"
    assert "http" not in still.replace("http://www.w3.org", "").replace(
        "http://purl.org", ""
    ).replace("http://creativecommons.org", "").replace("https://matplotlib.org", "")


@pytest.mark.usefixtures("empty_pictures")
def test_show_writes_pictures(short_walk: Path, tmp_path: Path) -> None:
    assert bigant("show", str(short_walk), "--out", str(tmp_path / "p.png")) == ExitCode.OK
    names = sorted(p.name for p in tmp_path.iterdir())
    assert names == [
        "p-body-velocity.png",
        "p-foot-forces.png",
        "p-shafts.png",
        "p-trajectory.png",
    ]


def test_show_as_json(short_walk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert bigant("show", str(short_walk), "--json") == ExitCode.OK
    summary = json.loads(capsys.readouterr().out)
    assert summary["gait"] == "tripod"
    assert summary["truth"] is True
    assert len(summary["slip_percentiles_m_s"]) == 5


@pytest.mark.usefixtures("words_only")
def test_a_cut_log_is_still_shown(
    short_walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = tmp_path / "short.mcap"
    short.write_bytes(short_walk.read_bytes()[: short_walk.stat().st_size // 2])
    assert bigant("show", str(short)) == ExitCode.OK
    assert "cut or damaged" in capsys.readouterr().out


def test_odometry_of_a_damaged_log_says_what_is_missing(
    short_walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = bytearray(short_walk.read_bytes())
    assert bigant("odom", str(short_walk)) == ExitCode.OK
    assert "damaged" not in capsys.readouterr().err
    middle = slice(len(data) // 2, len(data) // 2 + 50)
    data[middle] = bytes(50)
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(data)
    bigant("odom", str(broken))
    said = capsys.readouterr().err
    assert "cut or damaged" in said
    assert "the estimate knows nothing of what is missing" in said


def test_readonly_listens_and_logs(tmp_path: Path) -> None:
    path = tmp_path / "listen.mcap"
    code = bigant("drive", "--virtual-time", "--readonly", "--duration", "0.5", "--log", str(path))
    assert code == ExitCode.OK
    log = read_log(path)
    assert np.isnan(log.sent_angle_rad).all()
    assert np.isfinite(log.angle_rad).all()
    assert log.metadata["armed"] == "false"


# Wrong input.


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["drive", "--hardware", "/dev/none"], 3, "there is no port /dev/none"),
        (["drive", "--hardware", "/dev/null"], 3, "/dev/null"),
        (["drive", "--robot", "/none.toml"], 2, "/none.toml: the robot file cannot be read"),
        (["drive", "--virtual-time", "--log", "/dev/full"], 4, "No space left on device"),
        (["drive", "--virtual-time", "--log", "/proc/no/log.mcap"], 4, "cannot be made"),
        (["drive", "--gait", "gallop"], 2, "no gait of this robot, which has tripod, metachronal"),
        (["sim", "run", "--gait", "tripd", "--out", "a.csv"], 2, "did you mean 'tripod'?"),
        (["model", "run", "bigant", "--gait", "hop"], 2, "no gait of this robot"),
        (["drive", "--frequency-hz", "2"], 2, "servo.max_speed allows 4 rad/s"),
        (["drive", "--readonly", "--armed"], 2, "exclude each other"),
        (["drive", "--virtual-time", "--hardware", "/dev/x"], 2, "real servos live in real time"),
        (["drive", "--teleop", "--virtual-time"], 2, "needs a terminal"),
        (["drive", "--hardware", "/dev/none", "--force-unit", "a:b:c"], 2, "must be HOST"),
        (["show", "/none.mcap"], 4, "cannot be read: No such file"),
        (["show", "/dev/null"], 4, "it is a device, not a file"),
        (["devices", "--port", "/dev/none", "--discover", "none"], 3, "there is no port"),
        (["devices", "--discover", "x:y"], 2, "must be ADDRESS"),
        (["sim", "serve", "--absent", "9"], 2, "9 is no servo of this robot"),
    ],
)
def test_wrong_input_is_one_clear_line(
    words: list[str], code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bigant(*words) == code
    error = capsys.readouterr().err.strip()
    assert said in error
    assert len(error.splitlines()) == 1
    assert "Traceback" not in error


@pytest.mark.parametrize(
    "words",
    [
        ["drive", "--steer", "2"],
        ["drive", "--cycles", "-1"],
        ["drive", "--cycles", "1", "--duration", "1"],
        ["drive", "--rate-hz", "1000"],
        ["walk"],
        [],
    ],
)
def test_wrong_usage_is_argparses_own_error(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        bigant(*words)
    assert caught.value.code == 2
    assert "usage: bigant" in capsys.readouterr().err


def test_ctrl_c_is_one_line_and_the_shells_own_code(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def press_ctrl_c(_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("robot.report.show.show_log", press_ctrl_c)
    assert bigant("show", "any.mcap") == 130
    assert capsys.readouterr().err.strip() == "bigant show: interrupted"


def test_version_says_what_is_at_work(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        bigant("--version")
    assert stopped.value.code == 0
    text = capsys.readouterr().out
    assert re.search(r"bigant \d+\.\d+.*Python 3\.", text)
    assert "model: compiled" in text


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        bigant("--help")
    assert caught.value.code == 0
    printed = capsys.readouterr().out
    for command in ("drive", "show", "devices", "sim", "model", "exit codes"):
        assert command in printed


def test_a_robot_file_with_a_mistake_names_the_key(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "robot.toml"
    text = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    path.write_text(text.replace("crank = 0.030", "crank = 0.3"), encoding="utf-8")
    assert bigant("drive", "--robot", str(path)) == ExitCode.USAGE
    assert "leg.crank: the linkage cannot turn" in capsys.readouterr().err


# Processes of their own: the pseudo-terminal, sockets and signals are real.


@pytest.mark.soak
def test_real_ports_are_only_listened_to_unless_armed(tmp_path: Path) -> None:
    sim = ForkedSim()
    try:
        log = tmp_path / "log.mcap"
        ports = ["--hardware", sim.port, "--force-unit", sim.unit]
        common = ["drive", *ports, "--robot", patient_robot(tmp_path), "--log", str(log)]
        assert bigant(*common, "--duration", "0.5") == ExitCode.OK
        assert np.isnan(read_log(log).sent_angle_rad).all()
        assert bigant(*common, "--armed", *SHORT) == ExitCode.OK
        assert np.isfinite(read_log(log).sent_angle_rad).any()
        assert not read_log(log).has_truth, "a real port knows no truth"
    finally:
        sim.close()


@pytest.mark.parametrize(
    ("words", "more", "said"),
    [
        (["--absent", "3"], [], "FL (id 3) does not answer"),
        (["--baud", "57600"], [], "no servo answers"),
        (["--no-force-unit"], ["--force-unit", "127.0.0.1:1:1"], "no force-torque unit answers"),
    ],
)
def test_hardware_that_is_not_as_it_should_be(
    words: list[str], more: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    sim = ForkedSim(*words)
    try:
        arguments = more or ["--force-unit", sim.unit]
        code = bigant("drive", "--hardware", sim.port, "--armed", "--log", "none", *arguments)
        assert code == ExitCode.HARDWARE
        assert said in capsys.readouterr().err
    finally:
        sim.close()


def test_devices_finds_the_servos(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("drivers.dynamixel.scan.IDS", 100)  # 0.3 s
    sim = ForkedSim()
    try:
        words = ["devices", "--port", sim.port, "--baud", "1000000", "--discover", "none"]
        assert bigant(*words, "--json") == ExitCode.OK
        found = json.loads(capsys.readouterr().out)
        assert [s["servo_id"] for s in found["servos"]] == [1, 2, 3, 4, 5, 6]
        assert bigant(*words) == ExitCode.OK
        assert "MX-106(2.0)" in capsys.readouterr().out
        code = bigant("devices", "--port", sim.port, "--baud", "57600", "--discover", "none")
        assert code == ExitCode.VERDICT_FAILED
    finally:
        sim.close()


def drive_process(*words: str, own_group: bool = False) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "bigant", "drive", "--log", "none", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        start_new_session=own_group,
    )


def read_until(process: "subprocess.Popen[str]", words: str) -> str:
    assert process.stdout is not None
    seen = ""
    for line in process.stdout:
        seen += line
        if words in line:
            return seen
    raise AssertionError(f"{words!r} never came:\n{seen}")


@pytest.mark.soak
def test_one_interrupt_stops_on_all_feet_and_two_cut_torque(tmp_path: Path) -> None:
    words = ("--cycles", "9", "--frequency-hz", "0.2", "--robot", patient_robot(tmp_path))
    process = drive_process(*words)
    read_until(process, "START")
    process.send_signal(signal.SIGINT)
    seen = read_until(process, "HOLD")
    assert "SETTLE" in seen
    rest, _ = process.communicate(timeout=60)
    assert "done (operator), torque off" in rest
    assert process.returncode == ExitCode.OK

    process = drive_process(*words)
    read_until(process, "START")
    process.send_signal(signal.SIGINT)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    rest, _ = process.communicate(timeout=60)
    assert "emergency" in rest
    assert "torque off" in rest
    assert process.returncode == ExitCode.HARDWARE


@pytest.mark.soak
def test_a_signal_to_the_whole_group_leaves_the_virtual_robot_until_it_has_stopped(
    tmp_path: Path,
) -> None:
    """As `timeout` and a closed terminal send it."""
    words = ("--cycles", "9", "--frequency-hz", "0.2", "--robot", patient_robot(tmp_path))
    process = drive_process(*words, own_group=True)
    read_until(process, "START")
    os.killpg(process.pid, signal.SIGTERM)
    rest, _ = process.communicate(timeout=120)
    assert "done (operator), torque off" in rest
    assert "link lost" not in rest
    assert process.returncode == ExitCode.OK


@pytest.mark.soak
def test_a_drive_walks_on_when_nobody_reads_it_any_more(tmp_path: Path) -> None:
    log = tmp_path / "run.mcap"
    words = ["--virtual-time", "--readonly", "--duration", "3", "--log", str(log)]
    process = subprocess.Popen(
        [sys.executable, "-m", "bigant", "drive", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    assert process.stdout.readline()
    process.stdout.close()  # as `| head -1` does
    complaint = process.stderr.read()
    process.stderr.close()
    assert process.wait(timeout=120) == ExitCode.OK
    assert f"completed, torque off; log: {log}" in complaint
    assert len(read_log(log).t_s) > 290


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_one_line() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "bigant", "gap", "effects"],
            stdout=full, stderr=subprocess.PIPE, text=True, cwd=ROOT, check=False,
        )  # fmt: skip
    assert done.returncode == ExitCode.LOG
    assert done.stderr.strip() == "bigant gap effects: No space left on device"


@pytest.mark.soak
def test_when_the_host_dies_the_servos_stop_by_themselves(tmp_path: Path) -> None:
    """Kill -9 in mid-stride: the device process lives on, its watchdogs have tripped."""
    from drivers.clock import MonotonicClock
    from drivers.dynamixel.catalog import MX_106
    from drivers.dynamixel.port import BusPort
    from drivers.dynamixel.requests import ServoRequests

    sim = Sim()
    try:
        process = drive_process("--hardware", sim.port, "--force-unit", sim.unit, "--armed",
                                "--frequency-hz", "0.2", "--robot", patient_robot(tmp_path))  # fmt: skip
        read_until(process, "WALK")
        process.kill()
        process.communicate()
        port = BusPort(sim.port, 1_000_000, MonotonicClock())
        packets = ServoRequests(port)
        for _ in range(50):
            try:
                port.openPort()
                break
            except BusError:  # the dead process's lock goes with it, in its own time
                time.sleep(0.1)

        def answers_of(register: str, size: int) -> list[bytes | None]:
            """What each servo answers; one that answers too late, on a busy machine, is asked again."""
            address, answers = MX_106.table[register].address, list[bytes | None]()
            for servo in range(1, 7):
                asked = (packets.read(servo, address, size).data for _ in range(50))
                answers.append(next((data for data in asked if data is not None), None))
            return answers

        time.sleep(2 * WATCHDOG_S)  # they may be slow themselves
        answers = answers_of("bus_watchdog", 1)
        here, later = answers_of("present_position", 4), answers_of("present_position", 4)
        port.closePort()
        assert answers == [b"\xff"] * 6, "every watchdog has tripped"
        assert here == later, "and nothing moves any more"
    finally:
        sim.close()
