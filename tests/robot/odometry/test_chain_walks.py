"""Robots whose legs have several joints, from a lab's table to odometry; MuJoCo walks, with its truth."""

import re
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from model.errors import ConfigError
from model.motion.se2 import seen_from
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from record.log.blocks.read import read_log
from record.log.reader import LogContents, read_stamped_ticks
from record.trial.trial import read_trial
from robot.cli import main as cli
from robot.config.robot_file import load_robot, parse_robot
from robot.console.exit_codes import ExitCode
from robot.control.controller import Controller
from robot.odometry.metrics import path_length
from robot.odometry.track import TrackedLog, track_log
from robot.replay.ticks import replay_log
from robot.report.ground_truth import true_pose
from robot.report.scene import legs_of
from robot.requests.recorded import OdomRequest
from robot.view.numbers import numbers_of
from robot.view.screen import screen_lines
from tests.robot.browser import without_scripts
from tests.soaked import soaked

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
JOINTS = {"hexapod18": 18, "quadruped12": 12}


@pytest.fixture(scope="module", params=soaked(JOINTS, lambda name: name == "hexapod18"))
def imported(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four cycles of a walk as the log that the import makes of a lab's table."""
    name: str = request.param
    table = tmp_path_factory.mktemp(name) / f"{name}.csv"
    walk: Any = runpy.run_path(str(EXAMPLES / "chain_walk.py"))["walk"]
    walk(name, table, 4.0, 5.0, 0)
    log = table.with_suffix(".mcap")
    words = ["import", str(table), "--map", str(table.with_suffix(".map.toml")), "--out", str(log)]
    assert cli.run(words) == ExitCode.OK
    return log


@pytest.fixture(scope="module")
def beginning(imported: Path) -> Path:
    """Its first two seconds."""
    cut = imported.with_name(f"{imported.stem}_beginning.mcap")
    assert cli.run(["log", "trim", str(imported), "--to", "2", "--out", str(cut)]) == ExitCode.OK
    return cut


def test_the_example_runs_beside_its_own_robot_files(tmp_path: Path) -> None:
    """As ``bigant examples --out`` lays them out, with the table written where they are."""
    for name in ("chain_walk.py", "hexapod18.toml", "hexapod18.xml"):
        (tmp_path / name).write_bytes((EXAMPLES / name).read_bytes())
    walk: Any = runpy.run_path(str(tmp_path / "chain_walk.py"))["walk"]
    walk("hexapod18", tmp_path / "chain.csv", 0.5, 0.0, 0)
    for name in ("hexapod18.toml", "hexapod18.xml"):
        assert (tmp_path / name).read_bytes() == (EXAMPLES / name).read_bytes()
    assert (tmp_path / "chain.map.toml").exists()


@pytest.fixture(scope="module")
def tracked(imported: Path) -> TrackedLog:
    return track_log(imported)


def smooth_length(pose: FloatArray) -> float:
    """Length of a path without the noise of its markers."""
    window = np.ones(25) / 25
    xy = np.column_stack([np.convolve(column, window, "valid") for column in pose[:, :2].T])
    return float(path_length(xy)[-1])


def test_odometry_ends_within_five_per_cent_of_the_path(tracked: TrackedLog) -> None:
    pose, truth = tracked.track.pose, true_pose(tracked.log)
    off = seen_from(pose[0], pose[-1]) - seen_from(truth[0], truth[-1])
    assert smooth_length(truth) > 0.2
    assert np.hypot(*off[:2]) < 0.05 * smooth_length(truth)


def test_a_log_names_its_joints_and_its_legs(imported: Path, tracked: TrackedLog) -> None:
    names = tracked.config.parameters.names
    assert len(names.joints) == JOINTS[imported.stem]
    assert (tracked.log.names, tracked.log.joints) == (names.legs, names.joints)
    assert tracked.log.angle_rad.shape[1] == len(names.joints)
    assert tracked.log.force_n.shape[1:] == (len(names.legs), 3)
    contents = LogContents()
    first = next(read_stamped_ticks(imported, contents))
    assert contents.machine(first.tick) == names


def test_a_log_needs_neither_its_robot_file_nor_the_model(beginning: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone.mcap"
    alone.write_bytes(beginning.read_bytes())
    text = read_log(alone).config_text
    assert "[leg.chain]" in text
    assert parse_robot(text).parameters.names.joints == track_log(alone).log.joints


def test_a_trial_goes_to_a_table_and_back(imported: Path, tmp_path: Path) -> None:
    out = tmp_path / "again.parquet"
    assert (
        cli.run(["log", "export", str(imported), "--format", "trial", "--out", str(out)])
        == ExitCode.OK
    )
    trial, log = read_trial(out), read_log(imported)
    assert (trial.joints, trial.legs) == (log.joints, log.names)
    assert np.array_equal(trial.shaft_rad, log.angle_rad)
    assert np.array_equal(trial.command_rad, log.sent_angle_rad)


@pytest.mark.soak
def test_pages_and_pictures_are_made(imported: Path, tmp_path: Path) -> None:
    for words in (
        ["show", str(imported), "--out", str(tmp_path / "show.html")],
        ["odom", str(imported), "--compare", "--out", str(tmp_path / "odom.html")],
        ["view", str(imported), "--save", str(tmp_path / "view.mcap"), "--headless"],
    ):
        assert cli.run(words) == ExitCode.OK, words
    assert "nan" not in without_scripts((tmp_path / "odom.html").read_text(encoding="utf-8"))


def test_legs_are_drawn_from_joint_to_joint_to_the_foot(
    tracked: TrackedLog, imported: Path
) -> None:
    tick = next(read_stamped_ticks(imported)).tick
    legs = legs_of(tick, tracked.config.parameters)
    assert [leg.name for leg in legs] == list(tracked.log.names)
    for leg in legs:
        (strip,) = leg.links
        assert strip.points.shape == (4, 3)
        assert np.array_equal(strip.points[-1], leg.feet[0].place)


def test_a_screen_has_rows_of_joints_and_of_legs(imported: Path, tracked: TrackedLog) -> None:
    tick, names = next(read_stamped_ticks(imported)).tick, tracked.config.parameters.names
    lines = screen_lines(tick, names, 0.0, 0, 0)
    for name in (*names.joints, *names.legs):
        assert sum(line.split()[:1] == [name] for line in lines) == 1, name
    topics = dict(numbers_of(tick, names))
    assert {f"/servo/{joint}" for joint in names.joints} <= topics.keys()
    assert {f"/force/{leg}" for leg in names.legs} <= topics.keys()


def test_what_needs_servos_refuses_in_a_sentence(imported: Path) -> None:
    name = EXAMPLES / f"{imported.stem}.toml"
    with pytest.raises(
        ConfigError, match=r"leg\.kind: is chain, and legs of several joints are not"
    ):
        load_robot(name)
    config = load_robot(name, driven=False)
    with pytest.raises(ConfigError, match="are not driven"):
        Controller(config, (None,) * len(config.parameters.legs.names), armed=False)
    for words in (
        ["drive", "--hardware", "virtual"],
        ["check"],
        ["sim", "serve"],
    ):
        assert cli.run([*words, "--robot", str(name)]) == ExitCode.USAGE, words
    assert cli.run(["replay", str(imported), "--drive", "--virtual-time"]) == ExitCode.LOG


def test_a_replay_gives_the_estimates_of_the_import_in_every_bit(
    imported: Path, beginning: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replayed = replay_log(imported, scale=0.0)
    assert replayed.equal
    assert replayed.equal_bits == replayed.ticks == len(read_log(imported).t_s)
    assert {field.stage for field in replayed.fields} == {"estimate"}
    assert not replayed.complete
    assert cli.run(["replay", str(beginning)]) == ExitCode.OK
    said = capsys.readouterr().out
    assert (
        "no controller made this log: the estimator is replayed, commands are not compared" in said
    )
    # --robot takes legs that are not driven, too
    robot = str(EXAMPLES / f"{imported.stem}.toml")
    assert cli.run(["replay", str(beginning), "--robot", robot]) == ExitCode.OK


def test_another_friction_shows_in_the_replay_of_a_chain(beginning: Path) -> None:
    text = read_log(beginning).config_text
    slippery, count = re.subn(r"mu = \[0\.\d+", "mu = [0.31", text)
    assert count == 1
    replayed = replay_log(beginning, config=parse_robot(slippery))
    assert not replayed.equal
    assert replayed.first is not None
    assert replayed.first.stage == "estimate"


def test_another_robot_s_file_is_refused(imported: Path) -> None:
    other = next(name for name in JOINTS if name != imported.stem)
    words = ["odom", str(imported), "--robot", str(EXAMPLES / f"{other}.toml")]
    assert cli.run(words) == ExitCode.USAGE


def test_measured_forces_are_the_ground_s_and_the_import_says_what_they_show(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "hexapod18.csv"
    walk: Any = runpy.run_path(str(EXAMPLES / "chain_walk.py"))["walk"]
    walk("hexapod18", table, 2.0, 0.0, 0, forces=True)
    log = table.with_suffix(".mcap")
    words = ["import", str(table), "--map", str(table.with_suffix(".map.toml")), "--out", str(log)]
    assert cli.run(words) == ExitCode.OK
    assert "forces        yes: of LF, LM, LH, RF, RM, RH" in capsys.readouterr().out
    tracked = track_log(log)
    weight_n = tracked.config.parameters.body.mass * STANDARD_GRAVITY
    carried = np.median(tracked.log.force_n[..., 2].sum(axis=1))
    assert carried == pytest.approx(weight_n, rel=0.02)
    # loads by the model from joint angles alone are those that MuJoCo's contacts carry
    alone = track_log(log, OdomRequest(no_forces=True)).track.force_B[100:, :, 2]
    off = alone - tracked.log.force_n[100:, :, 2]
    assert np.sqrt(np.mean(off**2)) < 0.08 * weight_n


def test_a_table_imported_without_its_robot_says_how_to_name_it(
    imported: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = imported.with_suffix(".map.toml").read_text(encoding="utf-8")
    column_map, table, log = (tmp_path / f"bare.{kind}" for kind in ("map.toml", "csv", "mcap"))
    column_map.write_text(given.split("[trial]")[0], encoding="utf-8")
    table.write_bytes(imported.with_suffix(".csv").read_bytes())
    words = ["import", str(table), "--map", str(column_map)]
    assert cli.run([*words, "--out", str(log)]) == ExitCode.OK
    robot = EXAMPLES / f"{imported.stem}.toml"
    assert cli.run(["odom", str(log), "--robot", str(robot)]) == ExitCode.USAGE
    assert "name it in the map, [trial] robot" in capsys.readouterr().err
