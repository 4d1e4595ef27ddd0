"""``import bigant``: few names, nothing loaded before it is used, and the answers of the commands."""

import gc
import json
import runpy
import shutil
import subprocess
import sys
import typing
from pathlib import Path

import numpy as np
import pytest

import bigant
from model.systems.disk import disk
from model.values.tick import Mode
from record.log.blocks.read import read_log
from robot.cli.main import run
from tests.test_layers import ROOT

SECONDS, FREQUENCY_HZ, SEED = 1.5, 0.3, 3
LATER_S = 12.5  # how much later the clock of the shafts is


@pytest.fixture(scope="module")
def walked() -> bigant.Log:
    return bigant.walk(cycles=SECONDS * FREQUENCY_HZ, frequency_hz=FREQUENCY_HZ, seed=SEED)


@pytest.fixture(scope="module")
def estimated(walked: bigant.Log) -> bigant.Odometry:
    return bigant.odometry(walked)


def test_it_has_about_a_dozen_names_and_each_is_there_for_editors_too() -> None:
    names = [name for name in dir(bigant) if name[0].islower()]
    assert len(names) <= 12
    for name in dir(bigant):
        value = getattr(bigant, name)
        assert value.__name__ == name
        assert value.__doc__
    source = (ROOT / "bigant" / "__init__.py").read_text(encoding="utf-8")
    for name in dir(bigant):
        assert f" import {name} as {name}\n" in source or name == "NameConflict"
    with pytest.raises(AttributeError, match=r"it has BigantError, .*walk"):
        bigant.drive  # type: ignore[attr-defined] # noqa: B018


def test_every_argument_has_a_type_and_only_what_is_asked_for_has_to_be_given() -> None:
    for name in (one for one in dir(bigant) if one[0].islower()):
        function = getattr(bigant, name)
        hints = typing.get_type_hints(function)
        assert "return" in hints, name
        assert "progress" not in hints or function.__kwdefaults__["progress"] is not None


HEAVY = {
    "argparse",
    "asyncio",
    "dataclasses",
    "inspect",
    "json",
    "logging",
    "multiprocessing",
    "subprocess",
}


def test_the_import_loads_nothing_before_it_is_used() -> None:
    code = "import sys; before = set(sys.modules); import bigant; print(*set(sys.modules) - before)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    loaded = set(done.stdout.split())
    beyond_python = {name for name in loaded if name.split(".")[0] not in sys.stdlib_module_names}
    assert beyond_python == {"bigant", "bigant.name_conflict"}
    # of Python's own, nothing that takes longer than all the rest together
    assert not HEAVY & loaded


@pytest.mark.soak
def test_a_walk_is_the_one_of_the_command(walked: bigant.Log, tmp_path: Path) -> None:
    out = tmp_path / "drive.mcap"
    cycles = str(SECONDS * FREQUENCY_HZ)
    words = ["--cycles", cycles, "--frequency-hz", str(FREQUENCY_HZ), "--seed", str(SEED)]
    assert run(["drive", "--virtual-time", *words, "--log", str(out)]) == 0
    other = read_log(out)
    for name in ("angle_rad", "force_n", "estimate_pose", "truth_position_W"):
        np.testing.assert_array_equal(getattr(walked, name), getattr(other, name))
    assert walked.walking.sum() == (other.mode == Mode.WALK.value).sum()
    assert walked.robot.name == "BigANT"
    assert "tripod on virtual" in repr(walked)


def test_a_log_that_is_not_saved_goes_with_its_last_holder(tmp_path: Path) -> None:
    log = bigant.walk(cycles=0.05, frequency_hz=FREQUENCY_HZ)
    folder, kept = log.path.parent, tmp_path / "kept.mcap"
    assert log.save(kept).path == kept
    with pytest.raises(FileExistsError, match="there already"):
        log.save(kept)
    del log
    gc.collect()
    assert not folder.exists()
    assert len(bigant.read_log(str(kept)).t_s) > 0


def test_a_table_has_the_columns_of_the_export(walked: bigant.Log) -> None:
    table = walked.table("joints", "estimate")
    assert table.num_rows == len(walked.t_s)
    values = table["shaft_ML_rad"].to_numpy()
    np.testing.assert_array_equal(values, walked.angle_rad[:, walked.names.index("ML")])
    with pytest.raises(bigant.BigantError, match="joints"):
        walked.table("elbows")


def test_a_table_without_pyarrow_says_what_to_install(
    walked: bigant.Log, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(bigant.BigantError, match=r"needs pyarrow; install it with: .*arrow"):
        walked.table("joints")


def test_a_table_of_a_lab_becomes_a_log_with_notes(walked: bigant.Log, tmp_path: Path) -> None:
    trial = bigant.walk_trial(cycles=0.2, frequency_hz=FREQUENCY_HZ)
    names = [f"their_{leg}" for leg in trial.header.joints]
    table = tmp_path / "lab.csv"
    rows = [
        ",".join(map(repr, [t, *np.degrees(angles).tolist()]))
        for t, angles in zip((1e3 * trial.time_s).tolist(), trial.shaft_rad, strict=True)
    ]
    table.write_text("\n".join([",".join(["ms", *names]), *rows]))
    lines = ["[columns]", 'time_s = { from = "ms", unit = "ms" }'] + [
        f'shaft_{leg}_rad = {{ from = "{name}", unit = "deg" }}'
        for leg, name in zip(trial.header.joints, names, strict=True)
    ]
    columns = tmp_path / "map.toml"
    columns.write_text("\n".join(lines))
    log = bigant.import_table(table, columns)
    np.testing.assert_allclose(log.angle_rad, trial.shaft_rad, atol=1e-12)
    assert f"{len(trial.time_s)} kept" in log.notes[0]
    assert log.notes[0] in repr(log)
    kept = bigant.import_table(table, columns, tmp_path / "lab.mcap")
    assert (kept.path, kept.notes) == (tmp_path / "lab.mcap", log.notes)
    with pytest.raises(bigant.BigantError, match=r"must end in \.mcap"):
        bigant.import_table(table, columns, tmp_path / "lab.csv")


@pytest.fixture(scope="module")
def lab(walked: bigant.Log, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The walk as a ROS 2 bag, and as a table of shafts beside one of motion capture on another clock."""
    folder = tmp_path_factory.mktemp("lab")
    example = runpy.run_path(str(ROOT / "examples" / "lab_data.py"))
    example["write_bag"](walked, folder / "bag")
    shutil.copy(ROOT / "examples" / "lab_bag.toml", folder)
    (folder / "bigant.toml").write_text(walked.robot.text, encoding="utf-8")
    shafts = {f"shaft_{leg}_rad": walked.angle_rad[:, k] for k, leg in enumerate(walked.names)}
    places = dict(zip(("body_x_m", "body_y_m", "body_z_m"), walked.truth_position_W.T, strict=True))
    for name, t_s, columns in (
        ("run.csv", walked.t_s, shafts),
        ("run_mocap.csv", walked.t_s - LATER_S, places),
    ):
        header = ",".join(("time_s", *columns))
        table = np.column_stack([t_s, *columns.values()])
        np.savetxt(folder / name, table, "%.9g", ",", header=header, comments="")
    (folder / "clocks.toml").write_text(
        '[trial]\nrobot = "bigant.toml"\n[file.mocap]\n'
        'path = "{name}_mocap.csv"\n'  # noqa: RUF027 - the map's own brace
        f'clock = {{ by = "offset", seconds = {LATER_S} }}\n'
    )
    return folder


def test_a_bag_becomes_the_log_that_the_command_makes(walked: bigant.Log, lab: Path) -> None:
    log = bigant.import_table(lab / "bag", lab / "lab_bag.toml")
    np.testing.assert_allclose(log.angle_rad, walked.angle_rad, atol=1e-12)
    assert any("sensor_msgs/msg/JointState" in line for line in log.notes)
    out = lab / "command.mcap"
    words = ["import", str(lab / "bag"), "--map", str(lab / "lab_bag.toml"), "--out", str(out)]
    assert run(words) == 0
    other = read_log(out)
    for name in ("t_s", "angle_rad", "truth_position_W", "estimate_pose"):
        np.testing.assert_array_equal(getattr(log, name), getattr(other, name))
    assert np.isfinite(log.estimate_pose).all()


def test_topics_of_a_bag_are_named_as_in_the_command(lab: Path) -> None:
    log = bigant.import_table(lab / "bag", topics={"joints": "/joint_commands"})
    (read,) = (line for line in log.notes if line.startswith("read") and "/joint_commands" in line)
    assert "shaft_hl_shaft_rad" in read
    with pytest.raises(bigant.BigantError, match="is none of joints=, commands=, pose="):
        bigant.import_table(lab / "bag", topics={"shafts": "/joint_states"})
    with pytest.raises(bigant.BigantError, match="/no_such"):
        bigant.import_table(lab / "bag", topics={"joints": "/no_such"})


def test_other_files_of_a_run_come_by_the_map_with_their_clocks(
    walked: bigant.Log, lab: Path
) -> None:
    log = bigant.import_table(lab / "run.csv", lab / "clocks.toml")
    inner = slice(1, -1)  # the first and the last may lie outside of the other file by a rounding
    np.testing.assert_allclose(
        log.truth_position_W[inner], walked.truth_position_W[inner], atol=1e-6
    )
    assert any(line.startswith("clock") and "run_mocap.csv" in line for line in log.notes)
    assert bigant.odometry(log).truth is not None


def test_odometry_is_that_of_the_command(
    walked: bigant.Log,
    estimated: bigant.Odometry,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    assert run(["odom", str(walked.path), "--compare", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    np.testing.assert_allclose(estimated.displacement, printed["way"], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(estimated.displacement_sd, printed["way_sd"], rtol=1e-12)
    ends = {one["name"]: one["end_percent"] for one in printed["ways"]}
    assert {name: one.end_percent for name, one in estimated.errors.items()} == pytest.approx(ends)
    assert estimated.pose.shape == (len(estimated.t_s), 3)
    assert estimated.covariance.shape == (len(estimated.t_s), 3, 3)
    assert estimated.force_B.shape == (len(estimated.t_s), 6, 3)
    assert set(estimated.health) == {"ok"}
    assert estimated.truth is not None
    assert "open loop, naive" in repr(estimated)
    estimated.save(tmp_path / "walk.tum")
    assert (tmp_path / "walk.truth.tum").is_file()
    with pytest.raises(bigant.BigantError, match="must end in"):
        estimated.save(tmp_path / "walk.txt")


@pytest.mark.soak
def test_another_robot_is_believed(walked: bigant.Log, estimated: bigant.Odometry) -> None:
    robot = bigant.load_robot(str(ROOT / "config" / "bigant.toml"))
    same = bigant.odometry(walked.path, robot, law=robot.estimator.settings.law.value)
    np.testing.assert_array_equal(same.pose, estimated.pose)
    assert not np.array_equal(bigant.odometry(walked, forces=False).pose, estimated.pose)
    eight = bigant.load_robot(ROOT / "examples" / "octopod.toml")
    with pytest.raises(bigant.BigantError, match="has 8 legs, the log 6"):
        bigant.odometry(walked, eight)


def test_the_model_alone_walks_a_gait_a_log_and_feet(walked: bigant.Log) -> None:
    gait = bigant.predict("tripod", cycles=1.0)
    assert gait.solutions.valid.all()
    weight_n = bigant.load_robot().parameters.body.mass * 9.80665
    np.testing.assert_allclose(gait.solutions.load_n.sum(axis=1), weight_n)
    # the plant slips a little differently
    of_log = bigant.predict(walked)
    true_m = np.ptp(walked.truth_position_W[walked.walking, 0])
    assert of_log.poses[-1, 0] == pytest.approx(true_m, rel=0.1)
    feet = bigant.predict(gait.system.feet)
    np.testing.assert_allclose(feet.velocity_B, gait.velocity_B, atol=1e-12)
    viscous = bigant.predict(gait.system.feet, law="viscous", rate_hz=50.0)
    assert viscous.system.step_s == pytest.approx(0.02)
    assert bigant.predict(disk(5)).system.legs == 5
    assert "m forward" in repr(gait)
    with pytest.raises(bigant.BigantError, match="gallop"):
        bigant.predict("gallop")


def test_a_gait_turns_every_shaft_once_a_cycle() -> None:
    samples = bigant.sample_gait("metachronal")
    np.testing.assert_allclose(samples.angle_rad[-1] - samples.angle_rad[0], 2 * np.pi)
    slope = np.gradient(samples.angle_rad, samples.phase, axis=0) * samples.frequency_hz
    np.testing.assert_allclose(slope[5:-5], samples.rate_rad_s[5:-5], atol=0.05)
    assert samples.stance.mean() == pytest.approx(2 / 3, abs=0.01)
    assert bigant.sample_gait("tripod", phase=np.array([0.0, 0.25])).angle_rad.shape == (2, 6)


def test_pictures_have_axes_and_show_in_a_notebook(
    walked: bigant.Log, estimated: bigant.Odometry, tmp_path: Path
) -> None:
    picture = bigant.plot(walked, "Trajectory", "Shafts")
    assert list(picture.axes) == ["Trajectory", "Shafts"]
    picture.axes["Trajectory"][0].set_title("a title of mine")
    assert picture._repr_html_().count("data:image/png;base64,") == 2
    files = picture.save(tmp_path / "walk.png")
    assert [file.name for file in files] == ["walk-trajectory.png", "walk-shafts.png"]
    assert list(bigant.plot(estimated).figures) == ["Odometry"]
    assert list(bigant.plot(bigant.sample_gait()).figures) == ["Gait"]
    assert list(bigant.plot(bigant.predict(cycles=0.5)).figures) == ["Prediction"]
    with pytest.raises(ValueError, match="Trajectory, Body velocity"):
        bigant.plot(walked, "trajectory")
    with pytest.raises(TypeError, match="plot draws Log, Odometry"):
        bigant.plot(7)  # type: ignore[arg-type]


@pytest.mark.soak
@pytest.mark.long
def test_a_worn_spring_is_named_from_trials_in_memory(tmp_path: Path) -> None:
    worn = bigant.walk_trial(cycles=3.0, effects=["leg_stiffness@MR:ratio=0.69"])
    healthy = [bigant.walk_trial(cycles=3.0, seed=seed) for seed in (1, 2, 3)]
    shares: list[float] = []
    report = bigant.diagnose(worn, healthy, progress=lambda words, share: shares.append(share))
    assert shares[-1] == 1.0
    assert report.verdict == "explained"
    assert [one.words.split(" (")[0] for one in report.causes] == ["leg_stiffness at MR"]
    assert report.probabilities["leg_stiffness MR"] > 0.9
    ratio, error = report.parameters["leg_stiffness MR"]["ratio"]
    assert abs(ratio - 0.69) < 3 * error < 0.15
    assert repr(report).startswith("EXPLAINED\nThe simulator lacks leg_stiffness at MR")
    assert "(run 1); baseline from references" in repr(report)
    report.save(tmp_path / "gap.json")
    assert json.loads((tmp_path / "gap.json").read_text())["references"] == 3
    report.save(tmp_path / "gap.html")
    with pytest.raises(ValueError, match="html"):
        report.save(tmp_path / "gap.txt")
    assert bigant.plot(report).figures


def test_runs_of_different_machines_are_refused(walked: bigant.Log) -> None:
    octopod = bigant.load_robot(ROOT / "examples" / "octopod.toml")
    other = bigant.walk_trial(octopod, cycles=0.05, frequency_hz=FREQUENCY_HZ)
    with pytest.raises(bigant.BigantError, match="another machine"):
        bigant.diagnose(walked, [other])


def test_a_mistake_is_an_error_with_its_sentence(tmp_path: Path) -> None:
    with pytest.raises(bigant.BigantError, match=r"cannot be read|no such|opened"):
        bigant.read_log(tmp_path / "absent.mcap")
    with pytest.raises(bigant.BigantError, match=r"no effect|elbow"):
        bigant.walk(effects=["elbow@MR:ratio=1"])
    with pytest.raises(bigant.BigantError, match="gallop"):
        bigant.walk(gait="gallop")
