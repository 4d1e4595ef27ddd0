"""Odometry of a lab's own table: angles and poses, no speeds and no forces; and what ends badly."""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model.values.arrays import FloatArray
from record.log.from_trial import write_trial_log
from record.trial.trial import read_trial
from robot.cli import main as cli
from robot.config.robot_file import load_robot, parse_robot
from robot.console.exit_codes import ExitCode
from robot.report.ground_truth import true_pose, true_velocity
from robot.virtual.walk import walk_in_memory

CONFIG = load_robot()
PLAIN = parse_robot(f"{CONFIG.text}\n[estimator]\nenabled = false\n")  # its own is not looked at
PLACE = ("body_x_m", "body_y_m", "body_z_m")
ANGLES = ("body_roll_rad", "body_pitch_rad", "body_yaw_rad")


@pytest.fixture(scope="module")
def table(usual_pace: None) -> Mapping[str, FloatArray]:
    """What a lab writes down of a walk of a cycle, 50 times a second: time, commands, angles, poses."""
    log = walk_in_memory(PLAIN, "tripod", cycles=1, seed=3, progress=lambda _: None)
    turns = Rotation.from_quat(log.truth_quaternion_xyzw).as_euler("ZYX")[:, ::-1]
    columns = {"time_s": log.t_s}
    for k, leg in enumerate(log.names):
        columns[f"command_{leg}_rad"] = log.sent_angle_rad[:, k]
        columns[f"shaft_{leg}_rad"] = log.angle_rad[:, k]
    columns |= dict(zip(PLACE, log.truth_position_W.T, strict=True))
    columns |= dict(zip(ANGLES, turns.T, strict=True))
    return {name: values[::2] for name, values in columns.items()}


@pytest.fixture(scope="module")
def few_rows(table: Mapping[str, FloatArray]) -> Mapping[str, FloatArray]:
    """Its first four seconds: enough for what is said of any log."""
    return {name: values[:200] for name, values in table.items()}


def written(folder: Path, table: Mapping[str, FloatArray], gait: str = "tripod") -> Path:
    path = folder / "run.csv"
    np.savetxt(path, np.column_stack([*table.values()]), delimiter=",", header=",".join(table),
               comments="", fmt="%.9g")  # fmt: skip
    (folder / "bigant.toml").write_text(CONFIG.text, encoding="utf-8")
    words = f'[trial]\nrobot = "bigant.toml"\ngait = "{gait}"\n'
    (folder / "run.toml").write_text(words, encoding="utf-8")
    return path


def brought_in(folder: Path, table: Mapping[str, FloatArray]) -> Path:
    log = folder / "run.mcap"
    assert cli.run(["import", str(written(folder, table)), "--out", str(log)]) == ExitCode.OK
    return log


def compared(log: Path, capsys: pytest.CaptureFixture[str], code: int = ExitCode.OK) -> Any:
    capsys.readouterr()
    assert cli.run(["odom", str(log), "--compare", "--json"]) == code
    return json.loads(capsys.readouterr().out)


@pytest.mark.usefixtures("words_only")
def test_angles_and_poses_alone_give_odometry_judged_by_the_poses(
    table: Mapping[str, FloatArray], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = brought_in(tmp_path, table)
    assert "not measured; worked out from angles" in capsys.readouterr().out
    assert cli.run(["odom", str(log), "--compare"]) == ExitCode.OK
    shown = capsys.readouterr().out
    assert "ok 100.0 %" in shown
    (stride,) = [line for line in shown.splitlines() if line.startswith("distance a stride:")]
    assert stride.endswith(
        "calibrated on this log's own ground truth, so its end error is not independent"
    )
    assert shown.count("calibrated") == 1
    assert "nan" not in shown
    mine = compared(log, capsys)["ways"][0]
    assert mine["name"] == "estimator"
    assert mine["end_percent"] < 5
    assert cli.run(["show", str(log)]) == ExitCode.OK
    shown = capsys.readouterr().out
    assert "(true, walking)" in shown
    assert "1.00 cycles" in shown
    assert "nan" not in shown
    # what nobody measured, and no loop or model of ours made, has no row
    assert "tripod, imported data" in shown
    assert not re.search(r"(^|\s)- (mm|C|mrad)", shown)
    for row in ("hottest servo", "loop", "predicted velocity", "drift of dead reckoning"):
        assert row not in shown
    assert "drift of the estimator" in shown


@pytest.mark.soak
def test_what_was_worked_out_stands_in_the_log_s_header(
    table: Mapping[str, FloatArray], tmp_path: Path
) -> None:
    log, back = brought_in(tmp_path, table), tmp_path / "back" / "run.parquet"
    back.parent.mkdir()
    words = ["log", "export", str(log), "--format", "trial", "--out", str(back)]
    assert cli.run(words) == ExitCode.OK
    (derived,) = read_trial(back).header.derived
    assert "shaft_HL_rad_s" in derived
    assert "slope over 0.1 s" in derived


@pytest.mark.soak
def test_places_without_an_attitude_are_ground_truth_too(
    table: Mapping[str, FloatArray], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The heading is that with which the path fits best; what needs the true one is not known."""
    turned = dict(table)
    c, s = np.cos(2.0), np.sin(2.0)
    x, y = table["body_x_m"], table["body_y_m"]
    turned["body_x_m"], turned["body_y_m"] = c * x - s * y + 3, s * x + c * y - 1
    places = {name: values for name, values in turned.items() if name not in ANGLES}
    mine = compared(brought_in(tmp_path, places), capsys)["ways"][0]
    assert mine["end_percent"] < 5
    assert mine["yaw_deg_m"] is None
    assert mine["velocity_rmse"] == [None] * 3


def test_nothing_to_compare_with_is_a_bad_verdict(
    few_rows: Mapping[str, FloatArray], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shafts = {name: values for name, values in few_rows.items() if not name.startswith("body_")}
    log = brought_in(tmp_path, shafts)
    assert cli.run(["odom", str(log)]) == ExitCode.OK
    capsys.readouterr()
    assert cli.run(["odom", str(log), "--compare"]) == ExitCode.VERDICT_FAILED
    said = capsys.readouterr().err
    assert "nothing to compare" in said
    assert "body_x_m" in said


def test_a_log_without_a_robot_file_is_not_taken_for_a_bigant_in_silence(
    few_rows: Mapping[str, FloatArray], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, few_rows)
    legs = json.dumps(CONFIG.parameters.legs.names)
    (tmp_path / "run.toml").write_text(f"[trial]\nlegs = {legs}\n", encoding="utf-8")
    log = tmp_path / "run.mcap"
    assert cli.run(["import", str(path), "--out", str(log)]) == ExitCode.OK
    words = "holds no robot file: taken for a BigANT"
    for more, said in ((["--robot", str(tmp_path / "bigant.toml")], False), ([], True)):
        capsys.readouterr()
        assert cli.run(["odom", str(log), *more]) == ExitCode.OK
        assert (words in capsys.readouterr().err) is said


def test_an_estimator_that_was_lost_most_of_the_time_is_a_bad_verdict(
    few_rows: Mapping[str, FloatArray], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    broken = {
        name: np.where(np.arange(len(values)) < 50, values, np.nan)
        if name.startswith("shaft_")
        else values
        for name, values in few_rows.items()
    }
    log = brought_in(tmp_path, broken)
    capsys.readouterr()
    assert cli.run(["odom", str(log)]) == ExitCode.VERDICT_FAILED
    assert "the estimator was lost in" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("left", "words"),
    [
        ("shaft_", "no shaft speeds (shaft_J_rad_s); import its table again"),
        ("command_", "no shaft angles, and odometry needs them"),
    ],
)
def test_a_log_without_what_odometry_needs_names_it_and_what_to_do(
    left: str,
    words: str,
    few_rows: Mapping[str, FloatArray],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Such as one that an earlier version imported, which kept no speeds."""
    some = {name: v for name, v in few_rows.items() if name.startswith((left, "time", "body"))}
    write_trial_log(read_trial(written(tmp_path, some)), tmp_path / "old.mcap")
    assert cli.run(["odom", str(tmp_path / "old.mcap")]) == ExitCode.LOG
    assert words in capsys.readouterr().err


@pytest.mark.soak
def test_velocities_that_were_not_recorded_are_the_slope_of_the_poses() -> None:
    log = walk_in_memory(CONFIG, "metachronal", cycles=0.5, seed=1, progress=lambda _: None)
    poses = replace(log, truth_velocity_B=np.full_like(log.truth_velocity_B, np.nan))
    np.testing.assert_array_equal(true_velocity(log), log.truth_velocity_B)
    np.testing.assert_array_equal(true_pose(log), true_pose(poses))
    error = true_velocity(poses) - log.truth_velocity_B
    size = np.sqrt(np.mean(log.truth_velocity_B**2, axis=0))
    assert (np.sqrt(np.mean(error**2, axis=0)) < 0.2 * size + [0.0, 5e-4, 2e-3]).all()


def test_a_mocap_file_with_its_own_clock_is_aligned_by_the_motion_of_the_model(
    table: Mapping[str, FloatArray], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    later_s, rng = 47.11, np.random.default_rng(0)
    shafts = {name: values for name, values in table.items() if not name.startswith("body_")}
    written(tmp_path, shafts)
    poses = {"t": table["time_s"] - later_s} | {
        name: table[name] + rng.normal(0, 3e-4, len(table[name])) for name in (*PLACE, *ANGLES)
    }
    np.savetxt(tmp_path / "run_mocap.csv", np.column_stack([*poses.values()])[::2], delimiter=",",
               header=",".join(poses), comments="", fmt="%.9g")  # fmt: skip
    (tmp_path / "map.toml").write_text(
        '[trial]\nrobot = "bigant.toml"\ngait = "tripod"\n[file.mocap]\npath = "{name}_mocap.csv"\n'
        'columns.time_s = "t"\nclock.by = "correlation"\n'
    )
    words = ["import", str(tmp_path / "run.csv"), "--map", str(tmp_path / "map.toml")]
    assert cli.run([*words, "--out", str(tmp_path / "run.mcap")]) == ExitCode.OK
    said = capsys.readouterr().out
    offset, sd = (
        float(w) for w in said.split("run_mocap.csv: ")[1].split(" s by")[0].split(" +- ")
    )
    assert sd < 0.05
    assert abs(offset - later_s) < 3 * sd
    assert compared(tmp_path / "run.mcap", capsys)["ways"][0]["end_percent"] < 5
