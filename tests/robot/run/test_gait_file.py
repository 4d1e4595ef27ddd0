"""Gaits of a robot file and of a Python file, walked: drive, replay, odometry, teleop, campaigns."""

import json
import re
import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model.errors import ConfigError, RecordError
from model.values.faults import StopReason
from model.values.tick import Intent, Mode, Tick
from record.log.blocks.read import read_log
from record.trial.trial import read_trial
from robot.campaign.plan import read_scenario
from robot.cli import main as cli
from robot.config.gait_file import read_gait_file, with_gait, with_plugin
from robot.config.robot_file import load_robot, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from robot.control.controller import Controller
from robot.replay.ticks import replay_log
from robot.run.gait_texts import GAIT_FILES_KEY, RECORDED, gaits_of_log
from robot.run.teleop import help_line
from robot.virtual.walk import walk_in_memory
from tests.robot.runs import CONFIG, STOP, Told, drive, wish
from tests.robot.scenarios import ONE, write_scenario

OWN = Path(__file__).resolve().parents[3] / "examples" / "own_gait.py"
TABLES = """
[gait.ripple]
kind = "phases"
frequency = 0.15
touchdown = [0.0, 0.3333, 0.6667, 0.5, 0.8333, 0.1667]
duty = 0.6667
stance_sweep = 1.6
[gait.wave]
kind = "phases"
frequency = 0.08
touchdown = [0.0, 0.1667, 0.3333, 0.5, 0.6667, 0.8333]
duty = 0.8333
stance_sweep = 1.6
blend = 0.02
"""
PLAIN = "\n[estimator]\nenabled = false\n"  # it is not looked at
MORE = parse_robot(CONFIG.text + TABLES + PLAIN)


def bigant(*words: object) -> int:
    return cli.run([str(word) for word in words])


@pytest.fixture(scope="module")
def walked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A third of a cycle of the gait file, as a log."""
    folder = tmp_path_factory.mktemp("walked")
    shutil.copy(OWN, folder / "own_gait.py")
    log = folder / "own.mcap"
    (folder / "plain.toml").write_text(CONFIG.text + PLAIN)
    words = ("--cycles", "0.35", "--virtual-time", "--robot", folder / "plain.toml", "--log", log)
    assert bigant("drive", "--gait", folder / "own_gait.py", *words) == ExitCode.OK
    return log


def test_a_log_keeps_the_gaits_text_and_its_name(walked: Path) -> None:
    log = read_log(walked)
    assert log.metadata["gait"] == "own_gait"
    (kept,) = gaits_of_log(log.metadata)
    assert (kept.name, kept.file, kept.text) == ("own_gait", "own_gait.py", OWN.read_text())
    walking = log.mode == Mode.WALK.value
    forward_m = float(np.sum(log.truth_velocity_B[walking, 0])) / CONFIG.loop.rate_hz
    assert forward_m > 0.02
    assert GAIT_FILES_KEY not in read_log(_golden()).metadata, (
        "a log without one says nothing of it"
    )


def _golden() -> Path:
    return Path(__file__).resolve().parents[2] / "replay" / "golden" / "tripod.mcap"


def test_nothing_of_a_log_is_run_unless_a_person_says_so(
    walked: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bigant("replay", walked) == ExitCode.LOG
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert "the run had the gait of a Python file, own_gait.py; its text is in the log" in error
    assert "--gait recorded" in error
    with pytest.raises(RecordError, match="--gait recorded"):
        replay_log(walked)


def test_the_text_can_be_read_before_it_is_run(
    walked: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bigant("log", "info", walked) == ExitCode.OK
    assert re.search(r"gait file +own_gait\.py, \d+ bytes", capsys.readouterr().out)
    assert bigant("log", "info", walked, "--json") == ExitCode.OK
    assert "class SmoothTripod" in capsys.readouterr().out


def test_robot_show_judges_a_gait_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert bigant("robot", "show", DEFAULT_ROBOT_FILE, "--gait", OWN) == ExitCode.OK
    assert "own_gait" in capsys.readouterr().out


def test_a_replay_runs_the_recorded_text_or_a_copy_of_it(walked: Path, tmp_path: Path) -> None:
    recorded = replay_log(walked, gait=RECORDED)
    assert recorded.equal
    assert recorded.equal_bits == recorded.ticks
    assert recorded.notes == ("the gait's text in the log was run: own_gait.py",)
    copied = replay_log(walked, gait=str(OWN))
    assert (copied.equal, copied.notes) == (True, ())
    other = tmp_path / "renamed.py"
    other.write_text(OWN.read_text().replace("BEND = 0.7", "BEND = 0.6"))
    changed = replay_log(walked, gait=str(other))
    assert not changed.equal
    assert changed.notes[0] == f"{other} is not the text that was walked"


@pytest.mark.soak
def test_a_run_with_a_gait_file_is_done_again(walked: Path, tmp_path: Path) -> None:
    words = ("replay", walked, "--drive", "--virtual-time", "--log", tmp_path / "again.mcap")
    assert bigant(*words) == ExitCode.LOG
    assert bigant(*words, "--gait", "recorded") == ExitCode.OK
    old, new = read_log(walked), read_log(tmp_path / "again.mcap")
    assert gaits_of_log(new.metadata)[0].text == OWN.read_text()
    assert old.sent_angle_rad == pytest.approx(new.sent_angle_rad, abs=1e-9, nan_ok=True)


def test_odometry_of_such_a_log_needs_no_gait(
    walked: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bigant("odom", walked, "--json") == ExitCode.OK
    assert json.loads(capsys.readouterr().out)
    assert bigant("show", walked, "--json") == ExitCode.OK
    assert json.loads(capsys.readouterr().out)["gait"] == "own_gait"


def test_a_gait_for_a_log_that_needs_none_is_a_mistake() -> None:
    with pytest.raises(ConfigError, match="--gait: this run had no gait of a Python file"):
        replay_log(_golden(), gait=str(OWN))


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("bad.py", "def make(legs):\n    return legs.number\n", "bad.py, line 2: AttributeError"),
        ("tripod.py", OWN.read_text(), "the robot has a gait 'tripod' already; rename the file"),
        ("my gait.py", OWN.read_text(), "must be named by letters, digits, _ and -"),
        ("fast.py", OWN.read_text().replace("= 0.12", "= 0.9"), "servo.max_speed allows 4 rad/s"),
        ("none.py", None, "the gait file cannot be read: No such file"),
    ],
)
def test_a_wrong_gait_file_is_one_line_and_exit_code_2(
    name: str, text: str | None, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    for command in (["drive", "--virtual-time"], ["sim", "run", "--out", tmp_path / "a.csv"]):
        assert bigant(*command, "--gait", tmp_path / name) == ExitCode.USAGE
        error = capsys.readouterr().err.strip()
        assert words in error
        assert len(error.splitlines()) == 1


def test_a_mistake_while_it_walks_ends_the_run_with_torque_off(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What no check can see: the file fails after thirty ticks."""
    asked = "        turn = 2 * np.pi * (phase"
    count = "        self.ticks = getattr(self, 'ticks', 0) + (phase.shape == (3,))\n"
    late = OWN.read_text().replace(asked, f"{count}        assert self.ticks < 30\n{asked}")
    line = late[: late.index("assert ")].count("\n") + 1
    (tmp_path / "late.py").write_text(late)
    log = tmp_path / "late.mcap"
    (tmp_path / "plain.toml").write_text(CONFIG.text + PLAIN)
    words = ("--cycles", "0.2", "--virtual-time", "--robot", tmp_path / "plain.toml", "--log", log)
    assert bigant("drive", "--gait", tmp_path / "late.py", *words) == ExitCode.USAGE
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert error.endswith(f"late.py, line {line}: AssertionError")
    walked = read_log(log)
    assert Mode(int(walked.mode[-1])) is Mode.WALK
    assert not walked.damage


@pytest.mark.soak
def test_all_gaits_follow_each_other_without_a_jump() -> None:
    """Slow, move leg by leg, speed up: from each gait to the next, the last from a Python file."""
    config = with_plugin(MORE, read_gait_file(OWN))
    order = ("ripple", "own_gait", "wave", "metachronal")
    ticks_of: Counter[str] = Counter()

    def tell(_t: float, tick: Tick | None) -> object:
        if tick is not None and tick.mode is Mode.WALK:
            ticks_of[tick.inputs.request.gait] += 1
        left = [name for name in order if ticks_of[name] < 120]
        return wish(Intent.WALK, left[0], 0.1) if left else STOP

    result, ticks, _ = drive(Told(tell), config=config)  # type: ignore[arg-type]
    assert result.reason is StopReason.OPERATOR
    assert result.torque_off
    walked = [t.inputs.request.gait for t in ticks if t.mode is Mode.WALK]
    assert list(dict.fromkeys(walked)) == list(order)
    sent = np.array([t.sent.angle_rad for t in ticks if t.sent.torque])
    assert np.abs(np.diff(sent, axis=0)).max() < 0.01 * CONFIG.limits.max_speed_rad_s
    assert not {fault.kind for tick in ticks for fault in tick.faults}
    roll_pitch = np.array([_tilt(t) for t in ticks])
    assert roll_pitch.max() < 0.15, "it never falls"


def _tilt(tick: Tick) -> float:
    """Angle of the body's upward axis to the vertical [rad]."""
    assert tick.inputs.truth is not None
    x, y, _, _ = tick.inputs.truth.quaternion_xyzw
    return float(np.arccos(np.clip(1 - 2 * (x**2 + y**2), -1, 1)))


def test_a_gait_that_takes_much_of_a_tick_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = "        turn = 2 * np.pi * (phase"
    wait = f"        time.sleep(0.003 * (phase.shape == (3,)))\n{asked}"
    slow = tmp_path / "slow.py"
    slow.write_text(
        OWN.read_text().replace(asked, wait).replace("import numpy", "import time\nimport numpy")
    )
    assert bigant("drive", "--gait", slow, "--hardware", "/dev/none") == ExitCode.HARDWARE
    assert re.search(r"warning: slow takes \d\.\d of 10 ms of each tick", capsys.readouterr().err)
    assert bigant("drive", "--gait", OWN, "--hardware", "/dev/none") == ExitCode.HARDWARE
    assert "warning" not in capsys.readouterr().err


def test_keys_and_help_name_the_gaits_of_the_robot() -> None:
    config = with_plugin(MORE, read_gait_file(OWN))
    line = help_line(Controller(config, (), armed=False).book)
    assert "1 tripod  2 metachronal  3 ripple  4 wave  5 own_gait  " in line


def test_a_robot_without_gaits_listens_and_does_not_walk(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "still.toml"
    file.write_text(CONFIG.text[: CONFIG.text.index("[gait.tripod]")])
    drive_it = ("drive", "--robot", file, "--virtual-time", "--log", tmp_path / "a.mcap")
    assert bigant(*drive_it) == ExitCode.USAGE
    assert "the robot file has no gait; add a table [gait.NAME]" in capsys.readouterr().err
    assert bigant(*drive_it, "--readonly", "--duration", "0.2") == ExitCode.OK
    assert replay_log(tmp_path / "a.mcap").equal


def test_the_default_gait_is_the_first_of_the_file(tmp_path: Path) -> None:
    text = CONFIG.text
    at, second = text.index("[gait.tripod]"), text.index("[gait.metachronal]")
    file = tmp_path / "other.toml"
    file.write_text(text[:at] + TABLES + text[at:second] + text[second:])
    out = tmp_path / "a.csv"
    assert bigant("sim", "run", "--robot", file, "--seconds", "0.2", "--fast", "--out", out) == 0
    assert read_trial(out).header.gait == "ripple"
    assert with_gait(load_robot(file), None)[1] == "ripple"


def test_a_walk_in_memory_takes_any_gait_or_says_which_there_are() -> None:
    log = walk_in_memory(MORE, "ripple", cycles=0.05, seed=1, progress=lambda _: None)
    assert log.metadata["gait"] == "ripple"
    with pytest.raises(ConfigError, match="which has tripod, metachronal, ripple, wave"):
        walk_in_memory(MORE, "gallop", cycles=1, seed=1, progress=lambda _: None)


@pytest.mark.soak
def test_a_campaign_with_a_gait_of_the_robot_and_one_of_a_file(tmp_path: Path) -> None:
    text = ONE.replace('gaits = ["tripod"]', 'gaits = ["ripple", "own_gait.py"]')
    scenario = write_scenario(tmp_path, text)
    (tmp_path / "bigant.toml").write_text(DEFAULT_ROBOT_FILE.read_text() + TABLES)
    shutil.copy(OWN, tmp_path / "own_gait.py")
    plans = read_scenario(scenario).plans
    assert [plan.gait for plan in plans] == ["ripple", "own_gait"]
    out = tmp_path / "out"
    assert bigant("campaign", "make", scenario, "--out", out, "--jobs", "1") == ExitCode.OK
    trials = [read_trial(path) for path in sorted(out.rglob("trial_*.parquet"))]
    assert {trial.header.gait for trial in trials} == {"ripple", "own_gait"}
    scenario.write_text(text.replace('"ripple"', '"riple"'))
    with pytest.raises(ConfigError, match=r"conditions\.gaits: .*did you mean 'ripple'"):
        read_scenario(scenario)


def test_the_text_in_a_damaged_log_is_refused() -> None:
    for text in ("[", '[{"name": "a"}]', "[3]"):
        with pytest.raises(RecordError, match="gait_files cannot be read"):
            gaits_of_log({GAIT_FILES_KEY: text})
    assert gaits_of_log({}) == ()


def test_a_robot_takes_a_gait_file_once() -> None:
    once = with_plugin(CONFIG, read_gait_file(OWN))
    assert with_plugin(once, read_gait_file(OWN)) is once
    other = replace(read_gait_file(OWN), text="")
    with pytest.raises(ConfigError, match="already"):
        with_plugin(once, other)
