"""Tables, trials and trajectories of a log, read back with other people's readers."""

import csv
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from scipy.spatial.transform import Rotation

from model.errors import ConfigError, RecordError
from model.values.tick import Tick
from record.log import export
from record.log.columns import GROUPS, check_groups
from record.log.export import export_table, export_trial, export_tum
from record.log.reader import LogContents
from record.log.writer import LogWriter
from record.trial.table_file import read_table
from record.trial.trial import read_trial
from tests.record.test_log import START_UNIX_NS, write_log
from tests.record.ticks import NAMES, PERIOD_NS, make_tick

HEXAPOD = f"name = 'x'\n[legs]\norder = {list(NAMES)}\n"


def write_walk(path: Path, count: int) -> list[Tick]:
    """Ticks whose truth is a pose; every fourth has none."""
    ticks = []
    for index in range(count):
        tick = make_tick(index)
        if tick.inputs.truth is not None:
            turn = Rotation.from_euler("ZYX", [0.3 * index, 0.1, -0.2]).as_quat()
            truth = replace(
                tick.inputs.truth, quaternion_xyzw=turn, position_W=np.array([0.1 * index, 1, 2])
            )
            tick = replace(tick, inputs=replace(tick.inputs, truth=truth))
        ticks.append(tick)
    writer = LogWriter(
        path, names=NAMES, config_text=HEXAPOD,
        metadata={"gait": "tripod", "robot": "BigANT", "frequency_hz": "0.25"},
        start_ns=ticks[0].t_ns, start_unix_ns=START_UNIX_NS,
    )  # fmt: skip
    for tick in ticks:
        writer.write(tick)
    writer.close()
    assert writer.error is None
    return ticks


def test_a_parquet_table_holds_every_group_to_the_last_bit(tmp_path: Path) -> None:
    path, out = tmp_path / "log.mcap", tmp_path / "table.parquet"
    ticks = write_log(path, 30)
    (written,) = export_table(path, out, tuple(GROUPS), LogContents())
    assert written.rows == 30
    table = pq.read_table(out)

    def column(name: str) -> np.ndarray:
        return np.asarray(table.column(name).to_pylist(), dtype=np.float64)

    np.testing.assert_allclose(column("time_s"), np.arange(30) / 100, atol=1e-12)
    assert table.column("unix_ns")[3].as_py() == START_UNIX_NS + 3 * PERIOD_NS
    np.testing.assert_array_equal(column("shaft_FR_rad"), [t.joints.angle_rad[5] for t in ticks])
    np.testing.assert_array_equal(column("wished_HL_rad"), [t.wished.angle_rad[0] for t in ticks])
    np.testing.assert_array_equal(column("command_HL_rad"), [t.sent.angle_rad[0] for t in ticks])
    np.testing.assert_array_equal(column("force_ML_z_n"), [t.forces.force_n[1, 2] for t in ticks])
    np.testing.assert_array_equal(
        column("predicted_slip_HR_y_m_s"), [t.contact.traction.slip_B[3, 1] for t in ticks]
    )
    np.testing.assert_array_equal(
        column("dead_reckoning_x_m"), [t.dead_reckoning.position_m[0] for t in ticks]
    )
    known = [t.estimate for t in ticks if t.estimate is not None]
    ran = [t.estimate is not None for t in ticks]
    assert known
    assert not all(ran)
    for name, values in {
        "estimate_x_m": [e.position_m[0] for e in known],
        "estimate_yaw_rate_rad_s": [e.velocity_B[2] for e in known],
        "estimate_covariance_x_yaw_m_rad": [e.pose_covariance[0, 2] for e in known],
        "estimate_covariance_vy_vy_m2_s2": [e.twist_covariance[1, 1] for e in known],
        "estimate_force_ML_z_n": [e.force_B[1, 2] for e in known],
        "estimate_force_sd_FR_y_n": [np.sqrt(e.force_covariance[5, 1, 1]) for e in known],
        "estimate_mu_HR": [e.mu[3] for e in known],
        "estimate_stiffness_HL_n_m": [e.stiffness[0] for e in known],
    }.items():
        found = column(name)
        np.testing.assert_array_equal(found[ran], values, err_msg=name)
        assert np.isnan(found[~np.array(ran)]).all(), name
    healths = ["" if t.estimate is None else t.estimate.health.value for t in ticks]
    assert table.column("estimate_health").to_pylist() == healths
    truth = [np.nan if t.inputs.truth is None else t.inputs.truth.position_W[2] for t in ticks]
    np.testing.assert_array_equal(column("body_z_m"), truth)
    assert table.column("mode").to_pylist() == [t.mode.name for t in ticks]
    assert "text 0 ä ü" in table.column("faults")[1].as_py()
    raw = [
        t.inputs.servos.position_ticks[2]
        if t.inputs.servos is not None and t.inputs.servos.valid[2] else np.nan
        for t in ticks
    ]  # fmt: skip
    np.testing.assert_array_equal(column("servo_position_ticks_FL"), raw)
    last = ticks[2].inputs.forces[-1]
    counts = last.counts[4, 1] if last.present[4] else np.nan
    np.testing.assert_array_equal(column("transducer_5_fy_counts")[2], counts)
    assert np.isnan(column("transducer_5_fy_counts")[3]), "no record in that tick"


def test_csv_and_parquet_hold_the_same_numbers(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    write_log(path, 25)
    for suffix in ("csv", "parquet"):
        export_table(path, tmp_path / f"t.{suffix}", ("joints", "truth", "loop"), LogContents())
    one, other = read_table(tmp_path / "t.csv"), read_table(tmp_path / "t.parquet")
    assert one.names == other.names
    for mine, theirs in zip(one.columns, other.columns, strict=True):
        if theirs.values.dtype.kind == "O":
            assert mine.values.tolist() == theirs.values.tolist()
        else:
            np.testing.assert_array_equal(mine.values.astype(float), theirs.values.astype(float))
    with (tmp_path / "t.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 25
    assert rows[3]["body_x_m"] == "", "missing is empty in CSV"
    assert "nan" not in (tmp_path / "t.csv").read_text(encoding="utf-8")


def test_groups_that_are_not_there_are_an_error() -> None:
    assert check_groups("joints, truth") == ("joints", "truth")
    assert check_groups("odometry, loop") == ("dead_reckoning", "estimate", "loop")
    for text in ("joint", "", ","):
        with pytest.raises(ConfigError, match="choose from joints, commands, forces"):
            check_groups(text)


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_a_log_as_a_trial(tmp_path: Path, suffix: str) -> None:
    path, out = tmp_path / "log.mcap", tmp_path / f"walk{suffix}"
    ticks = write_walk(path, 40)
    export_trial(path, out, LogContents())
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "bigant.toml", "log.mcap", f"walk{suffix}", "walk.toml",
    ]  # fmt: skip
    trial = read_trial(out)
    header = trial.header
    assert (header.gait, header.frequency_hz, header.sample_rate_hz) == ("tripod", 0.25, 100.0)
    assert (header.robot_file, header.robot_text) == ("bigant.toml", HEXAPOD)
    assert trial.joints == NAMES
    np.testing.assert_array_equal(trial.shaft_rad, [t.joints.angle_rad for t in ticks])
    np.testing.assert_array_equal(trial.command_rad, [t.sent.angle_rad for t in ticks])
    np.testing.assert_array_equal(trial.pwm, [t.joints.duty for t in ticks])
    np.testing.assert_array_equal(trial.force_n, [t.forces.force_n for t in ticks])
    assert np.isnan(trial.torque_nm).all(), "servos measure current, not torque"
    known = np.array([t.inputs.truth is not None for t in ticks])
    np.testing.assert_array_equal(np.isfinite(trial.body_position_m).all(axis=1), known)
    yaw = np.where(known, 0.3 * np.arange(40), np.nan)
    np.testing.assert_allclose(trial.body_angles_rad[:, 2], yaw, atol=1e-9, err_msg="unwrapped")
    np.testing.assert_allclose(trial.body_angles_rad[known, 0], -0.2, atol=1e-9)
    np.testing.assert_allclose(trial.body_angles_rad[known, 1], 0.1, atol=1e-9)
    truth = ticks[5].inputs.truth
    assert truth is not None
    back = trial.body_position_m[5] + Rotation.from_quat(truth.quaternion_xyzw).apply(
        np.array(trial.foot_m[5])
    )
    whole = np.isfinite(truth.foot_position_W).all(axis=1)
    assert whole.any()
    np.testing.assert_allclose(back[whole], truth.foot_position_W[whole], atol=1e-12)


def test_trajectories_follow_the_rules_of_evo(tmp_path: Path) -> None:
    """What evo's reader asks: eight columns, a blank between, no NaN, unit quaternions, time on."""
    path = tmp_path / "log.mcap"
    ticks = write_walk(path, 40)
    written = export_tum(path, tmp_path / "run.tum", LogContents())
    assert [(f.path.name, f.rows) for f in written] == [
        ("run_estimate.tum", 27),
        ("run_dead_reckoning.tum", 40),
        ("run_truth.tum", 30),
    ]
    for file in written:
        lines = file.path.read_text(encoding="ascii").splitlines()
        assert all(len(line.split(" ")) == 8 for line in lines)
        stamps = [line.split(" ")[0] for line in lines]
        nanoseconds = [int(s.replace(".", "")) for s in stamps]
        assert all(len(s.split(".")[1]) == 9 for s in stamps)
        assert nanoseconds == sorted(set(nanoseconds))
        assert nanoseconds[0] == START_UNIX_NS
        table = np.loadtxt(file.path)
        assert table.shape == (file.rows, 8)
        np.testing.assert_allclose(np.linalg.norm(table[:, 4:], axis=1), 1, atol=1e-8)
    own = np.loadtxt(tmp_path / "run_estimate.tum")
    places = [t.estimate.position_m for t in ticks if t.estimate is not None]
    np.testing.assert_allclose(own[:, 1:3], places, atol=1e-9)
    reckoned = np.loadtxt(tmp_path / "run_dead_reckoning.tum")
    np.testing.assert_allclose(
        reckoned[:, 1:3], [t.dead_reckoning.position_m for t in ticks], atol=1e-9
    )
    truth = np.loadtxt(tmp_path / "run_truth.tum")
    known = [t.inputs.truth for t in ticks if t.inputs.truth is not None]
    np.testing.assert_allclose(truth[:, 1:4], [t.position_W for t in known], atol=1e-9)
    np.testing.assert_allclose(truth[:, 4:], [t.quaternion_xyzw for t in known], atol=1e-9)


def test_an_export_of_nothing_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(RecordError, match="cannot be read as a log"):
        export_tum(path, tmp_path / "run", LogContents())
    with pytest.raises(RecordError, match="cannot be read as a log"):
        export_trial(path, tmp_path / "t.parquet", LogContents())
    with pytest.raises(RecordError, match="cannot be read as a log"):
        export_table(path, tmp_path / "t.csv", ("joints",), LogContents())
    assert [p.name for p in tmp_path.iterdir()] == ["log.mcap"]


@pytest.mark.parametrize("place", ["missing/t.csv", "file/t.csv"])
def test_a_place_that_cannot_be_written_is_an_error(tmp_path: Path, place: str) -> None:
    write_log(tmp_path / "log.mcap", 5)
    (tmp_path / "file").write_text("")
    with pytest.raises(RecordError, match=r"cannot be written: .*choose another --out"):
        export_table(tmp_path / "log.mcap", tmp_path / place, ("joints",), LogContents())


def peak_bytes(path: Path, out: Path) -> int:
    tracemalloc.start()
    try:
        export_table(path, out, ("joints", "loop"), LogContents())
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_does_not_grow_with_the_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nine blocks need what three do; benchmarks/log_size.py measures an hour."""
    monkeypatch.setattr(export, "BLOCK_TICKS", 50)
    ticks = [make_tick(i, legs=1) for i in range(20)]
    peaks = []
    for count in (150, 450):
        path = tmp_path / f"{count}.mcap"
        writer = LogWriter(
            path, names=("L",), config_text="", metadata={}, start_ns=0, start_unix_ns=0
        )
        for index in range(count):
            writer.write(replace(ticks[index % 20], t_ns=index * PERIOD_NS, index=index))
        writer.close()
        peaks.append(peak_bytes(path, tmp_path / "t.parquet"))
    assert peaks[1] < 1.3 * peaks[0]
