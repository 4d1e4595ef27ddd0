"""The odom command on a log of the virtual robot, its files as others read them, and wrong input."""

import json
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from model.errors import RecordError
from model.estimator.settings import EstimatorSettings
from model.motion.se2 import seen_from
from model.values.arrays import FloatArray
from model.values.tick import Mode
from record.log.recording import Recording
from robot.cli import main as cli
from robot.config.robot_file import load_robot, parse_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import json_text
from robot.odometry.compare import compare_ways, stride_of, walking_part
from robot.odometry.files import write_mcap, write_tum
from robot.odometry.metrics import in_band, nees, relative_error, rmse
from robot.odometry.table import as_json, table
from robot.odometry.track import feet_of, inputs_of, weight_of
from robot.odometry.tune import TuningWalk, tune, whiteness
from robot.virtual.walk import walk_in_memory

CONFIG = load_robot()


@pytest.fixture(scope="module")
def walk() -> Recording:
    """A cycle and a half of the slipping gait."""
    return walk_in_memory(CONFIG, "metachronal", cycles=1.5, seed=5, progress=lambda _: None)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short walk by the real command, as a file."""
    path = tmp_path_factory.mktemp("odom") / "walk.mcap"
    made = cli.run(
        ["drive", "--gait", "tripod", "--duration", "4", "--virtual-time", "--log", str(path)]
    )
    assert made == ExitCode.OK
    return path


def straight(count: int = 400) -> FloatArray:
    pose = np.zeros((count, 3))
    pose[:, 0] = 0.005 * np.arange(count)
    pose[:, 1] = 0.05 * np.sin(pose[:, 0])
    return pose


def test_relative_error_of_a_scale_error_is_that_error() -> None:
    truth = straight()
    assert relative_error(1.05 * truth, truth, 0.5) == pytest.approx(5, rel=0.03)
    assert relative_error(truth, truth, 0.5) == 0
    assert np.isnan(relative_error(truth, truth, 10.0))


def test_a_pose_seen_from_itself_is_the_origin() -> None:
    pose = np.array([[1.0, 2.0, 0.3], [0.0, -1.0, 2.0]])
    np.testing.assert_allclose(seen_from(pose, pose), 0, atol=1e-15)
    ahead = seen_from(np.array([[0, 0, np.pi / 2]]), np.array([[0, 1.0, np.pi / 2]]))
    np.testing.assert_allclose(ahead, [[1, 0, 0]], atol=1e-15)


def test_nees_and_its_band_by_drawing() -> None:
    draw = np.random.default_rng(0)
    root = np.array([[1.0, 0, 0], [0.5, 2.0, 0], [0.1, 0.2, 0.3]])
    error = draw.normal(size=(4000, 3)) @ root.T
    found = nees(error, np.broadcast_to(root @ root.T, (4000, 3, 3)))
    assert found.mean() == pytest.approx(3, abs=0.15)
    assert in_band(found, 3) == pytest.approx(0.95, abs=0.015)


def test_rmse_leaves_out_what_is_not_known() -> None:
    np.testing.assert_allclose(rmse(np.array([[3.0, np.nan], [4.0, np.nan]]))[0], np.sqrt(12.5))
    assert np.isnan(rmse(np.full((2, 2), np.nan))).all()


def test_the_estimator_beats_what_it_is_compared_with(walk: Recording) -> None:
    found = compare_ways(walk, CONFIG, EstimatorSettings(), stride_m=stride_of(walk))
    mine, naive = found.errors[0], found.errors[1]
    assert [e.name for e in found.errors] == [
        "estimator", "open loop, naive", "distance a stride", "rigid stance",
    ]  # fmt: skip
    assert (mine.velocity_rmse < 0.7 * naive.velocity_rmse).all()
    assert mine.end_percent < 10 < naive.end_percent
    lines = "\n".join(table(found, walk.names, everything=True))
    assert "rigid stance" in lines
    assert "NEES" in lines
    assert json.loads(json_text(as_json(found, walk.names)))["ways"][0]["name"] == "estimator"


def test_without_truth_and_forces_it_still_estimates(walk: Recording) -> None:
    blind = replace(
        walk,
        force_n=np.full_like(walk.force_n, np.nan),
        truth_position_W=np.full_like(walk.truth_position_W, np.nan),
    )
    found = compare_ways(blind, CONFIG, EstimatorSettings())
    assert found.truth is None
    assert found.errors == ()
    assert np.isfinite(found.track.pose).all()
    assert found.track.force_B[-1, :, 2].sum() == pytest.approx(weight_of(CONFIG))
    assert "no truth" in "\n".join(table(found, walk.names, everything=True))


def test_forces_held_between_records_are_one_record(walk: Recording) -> None:
    held = walk.force_n.copy()
    held[1::2] = held[: len(held) - len(held) % 2 : 2] if len(held) % 2 == 0 else held[:-1:2]
    inputs = inputs_of(replace(walk, force_n=held), feet_of(walk, CONFIG), 100, 110)
    times = [known.forces.t_ns for known in inputs if known.forces is not None]
    assert len(set(times)) == 5


def test_a_log_without_walking_is_refused(walk: Recording) -> None:
    with pytest.raises(RecordError, match="no walking"):
        walking_part(replace(walk, mode=np.full_like(walk.mode, Mode.HOLD.value)))


def test_tum_lines_are_what_others_expect(tmp_path: Path) -> None:
    path = tmp_path / "a.tum"
    write_tum(path, np.array([0.5]), np.array([[1.0, 2.0, np.pi]]))
    assert path.read_text() == (
        "0.500000000 1.000000000 2.000000000 0.000000000 0.000000000 0.000000000 1.000000000 "
        "0.000000000\n"
    )
    with pytest.raises(RecordError, match="--out"):
        write_tum(tmp_path / "no" / "a.tum", np.array([0.5]), np.zeros((1, 3)))


def test_mcap_holds_pose_twist_and_covariance(walk: Recording, tmp_path: Path) -> None:
    found = compare_ways(walk, CONFIG, EstimatorSettings())
    path = tmp_path / "a.mcap"
    write_mcap(path, found.track)
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        messages = [m[3] for m in reader.iter_decoded_messages()]
    assert len(messages) == len(found.track.t_s)
    last, run = messages[-1], found.track
    assert last.pose.pose.position.x == run.pose[-1, 0]
    assert last.pose.covariance[35] == run.pose_covariance[-1, 2, 2]
    assert last.pose.covariance[5] == run.pose_covariance[-1, 0, 2]
    assert last.twist.twist.angular.z == run.velocity_B[-1, 2]
    assert last.twist.covariance[7] == run.twist_covariance[-1, 1, 1]
    assert last.child_frame_id == "base_link"


def test_tuning_raises_the_likelihood(walk: Recording) -> None:
    first, _ = walking_part(walk)
    feet = feet_of(walk, CONFIG)
    some = TuningWalk(
        tuple(inputs_of(walk, feet, first, first + 150)),
        CONFIG.parameters.contact,
        weight_of(CONFIG),
    )
    start = EstimatorSettings(force_share_sd=0.5, load_sd=0.2)
    told: list[float] = []
    found = tune([some], start, told.append)
    before, after = whiteness([some], start), whiteness([some], found)
    assert after.log_likelihood > before.log_likelihood + 10
    assert abs(after.nis_over_dof - 1) < abs(before.nis_over_dof - 1)
    assert told[-1] <= 1.0


def test_the_command_compares_and_writes(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("a.tum", "a.mcap", "a.png"):
        assert (
            cli.run(["odom", str(log), "--compare", "--out", str(tmp_path / name)]) == ExitCode.OK
        )
        assert (tmp_path / name).stat().st_size > 1000
    shown = capsys.readouterr().out
    assert "open loop, naive" in shown
    assert (tmp_path / "a.truth.tum").exists()
    assert cli.run(["odom", str(log), "--compare", "--fitted", str(log), "--json"]) == ExitCode.OK
    names = [way["name"] for way in json.loads(capsys.readouterr().out)["ways"]]
    assert "open loop, fitted" in names
    smooth = tmp_path / "s.tum"
    assert cli.run(["odom", str(log), "--smooth", "--out", str(smooth)]) == ExitCode.OK
    one, other = np.loadtxt(tmp_path / "a.tum"), np.loadtxt(smooth)
    assert one.shape == other.shape
    np.testing.assert_allclose(one[-1], other[-1], atol=1e-9)
    assert np.abs(one - other).max() > 1e-6


def test_evo_reads_the_trajectory(log: Path, tmp_path: Path) -> None:
    evo = shutil.which("evo_rpe")
    if evo is None:
        pytest.skip("evo is not installed (pip install -e '.[eval]')")
    out = tmp_path / "a.tum"
    assert cli.run(["odom", str(log), "--out", str(out)]) == ExitCode.OK
    answer = subprocess.run(
        [evo, "tum", str(tmp_path / "a.truth.tum"), str(out), "--delta", "0.05", "--delta_unit",
         "m", "--all_pairs", "--pairs_from_reference"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert answer.returncode == 0, answer.stderr
    assert "rmse" in answer.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--out", "a.csv"], ".tum, .mcap, .png or .html"),
        (["--fitted", "b.mcap"], "add it"),
        (["--smooth"], "--out FILE.tum"),
        (["second.mcap"], "give one log"),
    ],
)
def test_wrong_input_gives_one_line(
    log: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["odom", str(log), *arguments]) != ExitCode.OK
    said = capsys.readouterr().err.strip()
    assert words in said
    assert "\n" not in said


def test_tune_without_a_log_and_an_absent_log_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["odom", "tune"]) != ExitCode.OK
    assert "at least one" in capsys.readouterr().err
    assert cli.run(["odom", str(tmp_path / "none.mcap")]) != ExitCode.OK
    assert "cannot be read" in capsys.readouterr().err


def test_effects_of_the_robot_file_are_taken_into_account(walk: Recording) -> None:
    plain = compare_ways(walk, CONFIG, EstimatorSettings())
    bias = np.zeros((6, 3))
    bias[1] = [0.5, -0.5, -3.0]
    off = replace(walk, force_n=walk.force_n + bias)
    table_of = "[effects.force_bias.ML]\nx_n = 0.5\ny_n = -0.5\nz_n = -3.0\n"
    undone = compare_ways(off, parse_robot(f"{CONFIG.text}\n{table_of}"), EstimatorSettings())
    assert np.allclose(undone.track.pose, plain.track.pose, atol=1e-5)
    assert np.allclose(undone.track.stiffness, plain.track.stiffness, rtol=1e-3)
    loaded = "[effects.payload.all]\nmass_kg = 1.0\nx_m = 0.1\n"
    heavy = compare_ways(walk, parse_robot(f"{CONFIG.text}\n{loaded}"), EstimatorSettings())
    total = np.nansum(heavy.ways[1].force_B[..., 2], axis=1)
    assert np.median(total) == pytest.approx(weight_of(CONFIG) + 9.80665, rel=1e-3)
