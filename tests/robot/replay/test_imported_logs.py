"""A log that no controller made: the estimator is what is replayed, and what that compares is said."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model.errors import ConfigError, RecordError
from model.values.estimate import Estimate
from model.values.tick import Tick
from record.log.from_trial import write_trial_log
from record.log.reader import read_ticks
from record.trial.trial import Trial, read_trial
from robot.cli.main import run
from robot.config.robot_file import load_robot, parse_robot
from robot.console.exit_codes import ExitCode
from robot.control.tick_estimator import TickEstimator
from robot.odometry.track import track_log
from robot.replay.ticks import NOT_BY_A_CONTROLLER, replay_log
from robot.virtual.walk import walk_in_memory

CONFIG = load_robot()


@pytest.fixture(scope="module")
def trial(tmp_path_factory: pytest.TempPathFactory) -> Trial:
    """A lab's table of a fifth of a cycle: time, shafts with their speeds, places."""
    folder = tmp_path_factory.mktemp("lab")
    plain = parse_robot(f"{CONFIG.text}\n[estimator]\nenabled = false\n")
    log = walk_in_memory(plain, "tripod", cycles=0.2, seed=2, progress=lambda _: None)
    columns = {"time_s": log.t_s}
    for k, leg in enumerate(log.names):
        columns[f"command_{leg}_rad"] = log.sent_angle_rad[:, k]
        columns[f"shaft_{leg}_rad"] = log.angle_rad[:, k]
        columns[f"shaft_{leg}_rad_s"] = log.rate_rad_s[:, k]
        for part, axis in enumerate("xyz"):
            columns[f"force_{leg}_{axis}_n"] = log.force_n[:, k, part]
    columns |= dict(zip(("body_x_m", "body_y_m", "body_z_m"), log.truth_position_W.T, strict=True))
    table = np.column_stack([*columns.values()])[::4]
    np.savetxt(folder / "run.csv", table, "%.9g", ",", header=",".join(columns), comments="")
    (folder / "bigant.toml").write_text(CONFIG.text, encoding="utf-8")
    (folder / "run.toml").write_text('[trial]\nrobot = "bigant.toml"\n', encoding="utf-8")
    return read_trial(folder / "run.csv")


@pytest.fixture(scope="module")
def imported(trial: Trial, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nobody writes to it."""
    return written(trial, tmp_path_factory.mktemp("imported"))


def written(
    trial: Trial, folder: Path, change: Callable[[Tick, Estimate], Estimate] = lambda _, e: e
) -> Path:
    """The log of an import whose estimator went wrong in a way of its own."""
    estimator = TickEstimator(CONFIG)
    path = folder / "run.mcap"
    write_trial_log(trial, path, estimate=lambda tick: change(tick, estimator.step(tick.sensed)))
    return path


@pytest.mark.soak
def test_estimates_are_those_of_odom_and_replay_in_every_bit(imported: Path) -> None:
    poses = [t.estimate.pose for t in read_ticks(imported) if t.estimate is not None]
    assert np.array_equal(poses, track_log(imported).track.pose)
    replayed = replay_log(imported, scale=0.0)
    assert replayed.equal_bits == replayed.ticks == len(poses) > 50
    assert replayed.equal
    assert replayed.notes == (NOT_BY_A_CONTROLLER,)


def test_readings_of_an_imu_are_used_in_both(trial: Trial, imported: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    readings = np.column_stack(
        [0.02 + rng.normal(0, 0.005, len(trial.time_s)), *np.zeros((2, len(trial.time_s)))]
    )
    path = written(replace(trial, imu=readings), tmp_path)
    replayed = replay_log(path, scale=0.0)
    assert replayed.equal_bits == replayed.ticks
    yaw = [t.estimate.yaw_rad for t in read_ticks(path) if t.estimate is not None]
    other = [t.estimate.yaw_rad for t in read_ticks(imported) if t.estimate is not None]
    assert yaw[-1] != other[-1]


def test_the_estimate_that_differs_is_named(trial: Trial, tmp_path: Path) -> None:
    def off(tick: Tick, estimate: Estimate) -> Estimate:
        return replace(estimate, yaw_rad=estimate.yaw_rad + 1e-6 * (tick.index == 7))

    path = written(trial, tmp_path, off)
    replayed = replay_log(path)
    assert replayed.equal_bits == replayed.ticks - 1
    assert replayed.first is not None
    first = replayed.first
    assert (first.index, first.stage, first.name) == (7, "estimate", "yaw")
    assert run(["replay", str(path)]) == ExitCode.VERDICT_FAILED


def test_json_says_what_was_not_compared(
    imported: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["replay", str(imported), "--json"]) == ExitCode.OK
    result = json.loads(capsys.readouterr().out)
    assert (result["equal"], result["complete"]) == (True, False)
    assert {field["stage"] for field in result["fields"]} == {"estimate"}
    assert result["notes"] == [NOT_BY_A_CONTROLLER]


def test_another_robot_file_is_tried(imported: Path) -> None:
    heavy = parse_robot(CONFIG.text.replace("mass = 6.5 ", "mass = 6.6 "))
    assert not replay_log(imported, config=heavy).equal


def test_a_log_without_estimates_has_nothing_to_be_held_to(
    trial: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As imports were before they ran the estimator, or without a robot file."""
    write_trial_log(trial, tmp_path / "old.mcap")
    assert run(["replay", str(tmp_path / "old.mcap")]) == ExitCode.LOG
    said = capsys.readouterr().err
    assert "holds no estimate to compare with, and no controller made it" in said
    assert "import its table again" in said


def test_what_only_runs_of_ours_have_is_refused(imported: Path) -> None:
    with pytest.raises(ConfigError, match="no gait is run"):
        replay_log(imported, gait="recorded")
    assert run(["replay", str(imported), "--drive", "--virtual-time"]) == ExitCode.LOG
    assert run(["replay", str(imported), "--bus"]) == ExitCode.LOG


def test_a_log_from_its_middle_on_is_refused(imported: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    assert run(["log", "trim", str(imported), "--from", "1", "--out", str(cut)]) == ExitCode.OK
    with pytest.raises(RecordError, match="does not begin with tick 0"):
        replay_log(cut)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (CONFIG.text + "\n[estimator]\nenabled = false\n", "run.mcap: "),
        ("", "no robot file; add robot"),
        (CONFIG.text.replace('"HL"', '"LH"'), "by other names"),
    ],
)
def test_without_a_robot_to_believe_an_import_writes_no_estimate(
    text: str, words: str, trial: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = np.column_stack([trial.time_s, trial.shaft_rad, trial.shaft_rad_s])[:60]
    names = [f"shaft_{leg}_rad{end}" for end in ("", "_s") for leg in trial.legs]
    header = ",".join(("time_s", *names))
    np.savetxt(tmp_path / "run.csv", table, "%.9g", ",", header=header, comments="")
    (tmp_path / "robot.toml").write_text(text, encoding="utf-8")
    legs = f"legs = {json.dumps(trial.legs)}\n"
    robot = 'robot = "robot.toml"\n' if text else ""
    (tmp_path / "run.toml").write_text(f"[trial]\n{legs}{robot}", encoding="utf-8")
    out = tmp_path / "run.mcap"
    assert run(["import", str(tmp_path / "run.csv"), "--out", str(out)]) == ExitCode.OK
    said = capsys.readouterr().out
    assert words in said
    assert "with the estimate" not in said
    assert all(tick.estimate is None for tick in read_ticks(out))
    assert run(["replay", str(out)]) == ExitCode.LOG
    assert "holds no estimate to compare with" in capsys.readouterr().err
