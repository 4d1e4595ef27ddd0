"""The odom command on a log of the virtual robot, its files as others read them, and wrong input."""

import json
import shutil
import subprocess
from dataclasses import fields, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.stats import chi2

from model.errors import RecordError
from model.estimator.settings import EstimatorSettings
from model.estimator.smoother import smooth
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.tick import Mode
from record.exact_values import encode_values
from record.log.reader import read_stamped_ticks, read_ticks
from record.log.tum import TumFile
from robot.cli import main as cli
from robot.config.robot_file import load_robot, parse_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import json_text
from robot.odometry.compare import compare_methods, stride_of, walking_part
from robot.odometry.estimates import EstimateSeries
from robot.odometry.files import write_mcap
from robot.odometry.metrics import chi_squared_quantile, in_band, nees, relative_error
from robot.odometry.table import as_json, table
from robot.odometry.track import START_SD, TrackedLog, track, track_log
from robot.odometry.tune import read_walk, tune, whiteness
from robot.requests.recorded import OdomRequest
from tests.soaked import THOROUGH, soaked

CONFIG = load_robot()
HEAVY = "[effects.payload.all]\nmass_kg = 1.0\nx_m = 0.1\n"
WEIGHT_N = CONFIG.parameters.body.mass * STANDARD_GRAVITY


@pytest.fixture(scope="module")
def slipping(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cycle of the slipping gait, as a file."""
    path = tmp_path_factory.mktemp("odom") / "slipping.mcap"
    words = "drive --gait metachronal --cycles 1 --frequency-hz 0.15 --seed 5 --virtual-time --log"
    assert cli.run([*words.split(), str(path)]) == ExitCode.OK
    return path


@pytest.fixture(scope="module")
def walk(slipping: Path) -> TrackedLog:
    """What the estimator says of it."""
    return track_log(slipping)


@pytest.fixture
def log(cycle_walk: Path) -> Path:
    """A short walk by the real command, as a file."""
    return cycle_walk


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


def test_nees_and_its_band_by_drawing() -> None:
    draw = np.random.default_rng(0)
    root = np.array([[1.0, 0, 0], [0.5, 2.0, 0], [0.1, 0.2, 0.3]])
    error = draw.normal(size=(4000, 3)) @ root.T
    found = nees(error, np.broadcast_to(root @ root.T, (4000, 3, 3)))
    assert found.mean() == pytest.approx(3, abs=0.15)
    assert in_band(found, 3) == pytest.approx(0.95, abs=0.015)


def test_quantiles_of_chi_squared_are_those_of_scipy() -> None:
    freedom = np.array([1.0, 2.0, 3.0, 17.0, 600.0])
    for share in (0.025, 0.39, 0.975):
        expected = chi2.ppf(share, freedom)
        np.testing.assert_array_equal(chi_squared_quantile(share, freedom), expected)


def test_the_estimator_beats_what_it_is_compared_with(walk: TrackedLog) -> None:
    found = compare_methods(walk, stride_m=stride_of(walk.log))
    mine, naive = found.errors[0], found.errors[1]
    assert [e.name for e in found.errors] == [
        "estimator", "open loop, naive", "distance a stride", "rigid stance",
    ]  # fmt: skip
    assert (mine.velocity_rmse < 0.7 * naive.velocity_rmse).all()
    assert mine.end_percent < 10 < naive.end_percent
    lines = "\n".join(table(found))
    assert "rigid stance" in lines
    assert "NEES" in lines
    found_json = json.loads(json_text(as_json(found)))
    assert found_json["ways"][0]["name"] == "estimator"


def test_without_truth_and_forces_it_still_estimates(slipping: Path) -> None:
    deaf = track_log(slipping, OdomRequest(no_forces=True))
    assert all(np.isnan(e.force_age_s) for e in deaf.track.estimates)
    nowhere = np.full_like(deaf.log.truth_position_W, np.nan)
    found = compare_methods(replace(deaf, log=replace(deaf.log, truth_position_W=nowhere)))
    assert found.truth is None
    assert found.errors == ()
    assert np.isfinite(found.track.pose).all()
    assert found.track.force_B[-1, :, 2].sum() == pytest.approx(WEIGHT_N)
    assert "no truth" in "\n".join(table(found))


def test_it_says_what_the_loop_s_own_said_to_the_last_bit(slipping: Path, walk: TrackedLog) -> None:
    recorded = [tick.estimate for tick in read_ticks(slipping)]
    assert len(recorded) == len(walk.track.estimates) > 1000
    for own, theirs in zip(walk.track.estimates, recorded, strict=True):
        assert theirs is not None
        none = np.empty((0, 3))
        if encode_values(replace(own, companion_pose=none)) == encode_values(
            replace(theirs, companion_pose=none)
        ):
            continue
        for field in fields(own):
            if field.name == "companion_pose":  # not in a log
                continue
            one, other = getattr(own, field.name), getattr(theirs, field.name)
            np.testing.assert_array_equal(one, other, err_msg=field.name)


@pytest.mark.soak
def test_the_robot_file_s_own_settings_count(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They did not once: with any [estimator] the answer was that of the defaults."""

    def answer(*words: str) -> dict[str, Any]:
        assert cli.run(["odom", str(log), "--json", *words]) == ExitCode.OK
        found: dict[str, Any] = json.loads(capsys.readouterr().out)
        return {key: value for key, value in found.items() if key != "step_us"}

    robot = tmp_path / "viscous.toml"
    robot.write_text(f'{CONFIG.text}\n[estimator]\nlaw = "viscous"\n', encoding="utf-8")
    usual, file, option = answer(), answer("--robot", str(robot)), answer("--law", "viscous")
    assert file == option != usual
    assert answer("--robot", str(robot), "--law", "coulomb") == usual


def test_the_covariance_of_a_way_begins_with_it(walk: TrackedLog) -> None:
    run = walk.track.part(walking_part(walk.log))
    before = run.column("pose_covariance")
    sd = np.sqrt(np.diagonal(run.displacement_covariance, axis1=1, axis2=2))
    np.testing.assert_allclose(sd[0], START_SD, rtol=1e-6)
    assert (sd[-1] < np.sqrt(np.diagonal(before[-1]))).all()
    assert (np.linalg.eigvalsh(run.displacement_covariance) > 0).all()


def test_a_pose_that_is_known_better_than_the_first_leaves_the_way_as_uncertain_as_it_was(
    walk: TrackedLog,
) -> None:
    """The difference of the covariances was below nothing then, and its root not a number."""
    run = walk.track.part(walking_part(walk.log))
    estimates, half = list(run.estimates), len(run.t_s) // 2
    learned = [
        replace(one, pose_covariance=0.5 * estimates[0].pose_covariance) for one in estimates
    ]
    series = EstimateSeries.of([*estimates[:half], *learned[half:]])
    known = replace(run, estimates=series).displacement_covariance
    assert (np.linalg.eigvalsh(known) > 0).all()
    assert (np.diff(np.trace(known[:, :2, :2], axis1=1, axis2=2)) >= 0).all()
    np.testing.assert_array_equal(
        known[half:], np.broadcast_to(known[half - 1], known[half:].shape)
    )


def test_a_log_without_walking_is_refused(walk: TrackedLog) -> None:
    with pytest.raises(RecordError, match="no walking"):
        walking_part(replace(walk.log, mode=np.full_like(walk.log.mode, Mode.HOLD.value)))


def test_the_trajectory_is_that_of_the_recorded_estimates(log: Path, tmp_path: Path) -> None:
    """One writer, one time base: its lines stand in those of the log's own export."""
    assert cli.run(["odom", str(log), "--out", str(tmp_path / "a.tum")]) == ExitCode.OK
    words = ["log", "export", str(log), "--format", "tum", "--out", str(tmp_path / "b")]
    assert cli.run(words) == ExitCode.OK
    mine = (tmp_path / "a.tum").read_text().splitlines()
    assert len(mine) > 100
    assert set(mine) <= set((tmp_path / "b_estimate.tum").read_text().splitlines())
    one, true = (np.loadtxt(tmp_path / name)[0] for name in ("a.tum", "a.truth.tum"))
    np.testing.assert_allclose(one, true, atol=2e-9, err_msg="both begin at one place")


def test_a_place_that_cannot_be_written_is_said_with_the_option(tmp_path: Path) -> None:
    with pytest.raises(RecordError, match="--out"), TumFile(tmp_path / "no" / "a.tum"):
        pass


def test_mcap_holds_pose_twist_and_covariance(walk: TrackedLog, tmp_path: Path) -> None:
    path, run = tmp_path / "a.mcap", walk.track.part(walking_part(walk.log))
    write_mcap(path, run)
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = list(reader.iter_decoded_messages())
    assert [m[2].log_time for m in found] == run.unix_ns.tolist()
    odometry, last = found[-1][3], run.estimates[-1]
    assert odometry.pose.pose.position.x == run.pose[-1, 0]
    assert odometry.pose.covariance[35] == last.pose_covariance[2, 2]
    assert odometry.pose.covariance[5] == last.pose_covariance[0, 2]
    assert odometry.twist.twist.angular.z == run.velocity_B[-1, 2]
    assert odometry.twist.covariance[7] == last.twist_covariance[1, 1]
    assert odometry.child_frame_id == "base_link"


@pytest.mark.soak
def test_tuning_raises_the_likelihood(slipping: Path) -> None:
    walk = read_walk(slipping, OdomRequest())
    some = walk._replace(ticks=walk.ticks[:150])
    start = EstimatorSettings(force_share_sd=0.5, load_sd=0.2)
    told: list[float] = []
    found = tune([some], start, told.append)
    before, after = whiteness([some], start), whiteness([some], found)
    assert after.log_likelihood > before.log_likelihood + 10
    assert abs(after.nis_over_dof - 1) < abs(before.nis_over_dof - 1)
    assert told[-1] <= 1.0


def test_what_tuning_found_is_judged_by_the_same_command(
    log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("robot.odometry.tune.EVALUATIONS", 8)
    monkeypatch.setattr("robot.odometry.tune.LONGEST_S", 1.0)
    robot = tmp_path / "tuned.toml"
    words = ["odom", "tune", str(log), "--law", "viscous", "--out", str(robot), "--json"]
    assert cli.run(words) == ExitCode.OK
    found = json.loads(capsys.readouterr().out)["settings"]
    settings = load_robot(robot).estimator.settings
    assert {name: getattr(settings, name) for name in found} == found
    assert found != {name: getattr(EstimatorSettings(), name) for name in found}
    assert settings.law is FrictionLaw.VISCOUS
    assert settings.sway
    assert cli.run(["odom", str(log), "--compare", "--robot", str(robot)]) == ExitCode.OK


@pytest.mark.soak
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
    found = json.loads(capsys.readouterr().out)
    assert "open loop, fitted" in [way["name"] for way in found["ways"]]
    assert found["stride_from"] == f"{log.name}, as given with --fitted"
    smooth = tmp_path / "s.tum"
    assert cli.run(["odom", str(log), "--smooth", "--out", str(smooth)]) == ExitCode.OK
    one, other = np.loadtxt(tmp_path / "a.tum"), np.loadtxt(smooth)
    assert one.shape == other.shape
    np.testing.assert_allclose(one[-1], other[-1], atol=1e-9)
    assert np.abs(one - other).max() > 1e-6


@pytest.mark.parametrize(
    "words",
    soaked(("", '[estimator]\nlaw = "viscous"', HEAVY), lambda words: not words, repr, THOROUGH),
)
def test_smoothing_begins_from_the_states_of_the_same_filter(
    words: str, log: Path, tmp_path: Path
) -> None:
    """With the settings and effects of the robot file: what --smooth keeps is what the filter reported."""
    robot = tmp_path / "own.toml"
    robot.write_text(f"{CONFIG.text}\n{words}\n", encoding="utf-8")
    plain = track_log(log, OdomRequest(robot=robot)).track
    kept = track_log(log, OdomRequest(robot=robot, smooth=True)).track
    usual = track_log(log).track
    np.testing.assert_array_equal(kept.pose, plain.pose)
    np.testing.assert_array_equal(np.array([s.mean[:3] for s in kept.states]), plain.pose)
    covariance = np.array([s.covariance[:3, :3] for s in kept.states])
    apart = np.array([s.companions.pose_covariance for s in kept.states])
    np.testing.assert_array_equal(covariance + apart, plain.column("pose_covariance"))
    assert bool(words) == bool((usual.pose != plain.pose).any())
    mean, spread = smooth(kept.states)
    np.testing.assert_array_equal(mean[-1, :3], plain.pose[-1])
    assert np.isfinite(mean).all()
    assert (spread[:-1, 0, 0] <= covariance[:-1, 0, 0] + 1e-12).all()


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


def test_effects_of_the_robot_file_are_taken_into_account(
    slipping: Path, walk: TrackedLog, tmp_path: Path
) -> None:
    items = list(islice(read_stamped_ticks(slipping), 500))
    span = slice(0, len(items))
    bias = np.zeros((6, 3))
    bias[1] = [0.5, -0.5, -3.0]
    off = [
        replace(i, tick=replace(i.tick, forces=replace(f, force_n=f.force_n + bias)))
        for i in items
        for f in (i.tick.forces,)
    ]
    table_of = "[effects.force_bias.ML]\nx_n = 0.5\ny_n = -0.5\nz_n = -3.0\n"
    undone, plain = track(off, parse_robot(f"{CONFIG.text}\n{table_of}")), walk.track.part(span)
    assert np.allclose(undone.pose, plain.pose, atol=1e-5)
    stiffness, usual = (run.column("stiffness") for run in (undone, plain))
    assert np.allclose(stiffness, usual, rtol=1e-3)
    heavy = tmp_path / "heavy.toml"
    heavy.write_text(f"{CONFIG.text}\n{HEAVY}")
    loaded = replace(walk, config=load_robot(heavy))
    total = np.nansum(compare_methods(loaded).motions[1].force_B[..., 2], axis=1)
    assert np.median(total) == pytest.approx(WEIGHT_N + 9.80665, rel=1e-3)
