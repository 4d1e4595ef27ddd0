"""An IMU in a lab's table and in a ROS 2 bag: units, quaternions, what is wrong; and back out again."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from scipy.spatial.transform import Rotation

from model.errors import RecordError
from model.values.readings import ImuRecord
from record.log.blocks.read import read_log
from record.log.from_trial import write_trial_log
from record.log.reader import read_ticks
from record.log.writer import LogWriter
from record.trial.table_file import TableColumn
from record.trial.table_writer import write_table
from record.trial.trial import IMU, Trial, read_trial
from robot.cli import main as cli
from robot.console.exit_codes import ExitCode
from tests.record.test_ros_bag import (
    PERIOD_NS,
    SAMPLES,
    START_NS,
    brought,
    head,
    joint_state,
    kind,
    point,
    writing,
)
from tests.record.ticks import NAMES, make_tick

T_S = 0.01 * np.arange(SAMPLES)
RATE, ROLL, PITCH = 0.3 * np.sin(T_S), 0.1 * np.cos(T_S), -0.05 * np.sin(2 * T_S)
LEGS = '[trial]\nlegs = ["L", "R"]\n'


def table(folder: Path, columns: dict[str, Any], name: str = "run.csv") -> Path:
    path = folder / name
    whole = {"t": T_S, "shaft_L_rad": T_S, "shaft_R_rad": 2 * T_S} | columns
    write_table(path, tuple(TableColumn(one, values) for one, values in whole.items()))
    return path


def imported(path: Path, words: str, folder: Path) -> tuple[Trial, Any]:
    return brought(path, f'{LEGS}[columns]\ntime_s = "t"\n{words}\n', folder)


def test_columns_in_other_units_and_signs(tmp_path: Path) -> None:
    path = table(tmp_path, {"gyro_z": -np.rad2deg(RATE), "r": np.rad2deg(ROLL), "p": PITCH})
    trial, report = imported(
        path,
        'imu_yaw_rate_rad_s = { from = "gyro_z", unit = "deg/s", sign = -1 }\n'
        'imu_roll_rad = { from = "r", unit = "deg" }\nimu_pitch_rad = "p"',
        tmp_path,
    )
    np.testing.assert_allclose(trial.imu, np.column_stack([RATE, ROLL, PITCH]), atol=1e-9)
    assert set(IMU) <= set(report.columns)


def test_without_an_imu_nobody_misses_it(tmp_path: Path) -> None:
    trial, report = imported(table(tmp_path, {}), "", tmp_path)
    assert np.isnan(trial.imu).all()
    assert not any(finding.column == "imu" for finding in report.findings)
    alone, report = imported(table(tmp_path, {"imu_yaw_rate_rad_s": RATE}), "", tmp_path)
    np.testing.assert_allclose(alone.imu[:, 0], RATE, atol=1e-12)
    (absent,) = [one for one in report.findings if one.column == "imu"]
    assert "imu_roll_rad, imu_pitch_rad" in absent.detail


def quaternion_columns(rows: Any) -> dict[str, Any]:
    return {f"imu_quaternion_{axis}": rows[:, k] for k, axis in enumerate("xyzw")}


def test_a_quaternion_becomes_roll_and_pitch_whatever_its_yaw(tmp_path: Path) -> None:
    turns = Rotation.from_euler("ZYX", np.column_stack([5 * T_S, PITCH, ROLL])).as_quat()
    turns[3] *= -1  # the same attitude
    turns[5] = 0.0  # none at all
    trial, report = imported(table(tmp_path, quaternion_columns(turns)), "", tmp_path)
    known = np.arange(SAMPLES) != 5
    np.testing.assert_allclose(trial.imu[known, 1], ROLL[known], atol=1e-9)
    np.testing.assert_allclose(trial.imu[known, 2], PITCH[known], atol=1e-9)
    assert np.isnan(trial.imu[5]).all()
    (finding,) = [one for one in report.findings if one.kind == "rotation"]
    assert (finding.column, finding.count) == ("imu", 1)


def test_a_quaternion_that_is_none_is_refused(tmp_path: Path) -> None:
    turns = np.tile([0.1, 0.2, 0.3, 0.1], (SAMPLES, 1))
    with pytest.raises(RecordError, match="imu's attitude is no quaternions of length 1"):
        imported(table(tmp_path, quaternion_columns(turns)), "", tmp_path)
    columns = quaternion_columns(np.tile([0.0, 0.0, 0.0, 1.0], (SAMPLES, 1)))
    with pytest.raises(RecordError, match="is there twice"):
        imported(table(tmp_path, {**columns, "imu_roll_rad": ROLL}), "", tmp_path)
    del columns["imu_quaternion_w"]
    with pytest.raises(RecordError, match="lacks imu_quaternion_w"):
        imported(table(tmp_path, columns), "", tmp_path)


def imu_message(ns: int, rate: float, turn: Any, *, orientation: bool) -> Any:
    unknown, missing = np.zeros(9), np.array([-1.0, *[0.0] * 8])
    return kind("sensor_msgs/msg/Imu")(
        head(ns),
        kind("geometry_msgs/msg/Quaternion")(*turn),
        unknown if orientation else missing,
        point(0.01, 0.02, rate, name="Vector3"),
        unknown,
        point(0.0, 0.0, 9.81, name="Vector3"),
        unknown,
    )


def bag(path: Path, *, orientation: bool = True, topics: tuple[str, ...] = ("/imu/data",)) -> Path:
    """Joints, and an IMU at twice their rate."""
    with writing(path) as writer:
        for k in range(2 * SAMPLES):
            ns = START_NS + k * PERIOD_NS // 2
            t_s = k * 0.005
            if k % 2 == 0:
                writer.put("/js", ns, joint_state(ns, ["L", "R"], [t_s, 2 * t_s]))
            turn = Rotation.from_euler("ZYX", (3 * t_s, -0.05 * t_s, 0.1 * t_s)).as_quat()
            for topic in topics:
                writer.put(topic, ns, imu_message(ns, 0.3 * t_s, turn, orientation=orientation))
    return path


def test_an_imu_of_a_bag_comes_in_on_the_joints_times(tmp_path: Path) -> None:
    trial, report = brought(bag(tmp_path / "bag"), LEGS, tmp_path)
    np.testing.assert_allclose(trial.imu, np.outer(T_S, [0.3, 0.1, -0.05]), atol=1e-6)
    read = next(one for one in report.findings if one.column == "/imu/data")
    assert "imu_yaw_rate_rad_s" in read.detail


def test_an_orientation_that_was_not_measured_stays_out(tmp_path: Path) -> None:
    trial, _ = brought(bag(tmp_path / "bag", orientation=False), LEGS, tmp_path)
    np.testing.assert_allclose(trial.imu[:, 0], 0.3 * T_S, atol=1e-6)
    assert np.isnan(trial.imu[:, 1:]).all()


def test_of_two_imus_none_is_taken_unless_one_is_named(tmp_path: Path) -> None:
    path = bag(tmp_path / "bag", topics=("/imu/front", "/imu/back"))
    trial, report = brought(path, LEGS, tmp_path)
    assert np.isnan(trial.imu).all()
    assert {"/imu/front", "/imu/back"} <= {f.column for f in report.findings if f.kind == "ignored"}
    named, _ = brought(path, f'{LEGS}[bag]\nimu = "/imu/back"\n', tmp_path)
    assert np.isfinite(named.imu).all()


def test_a_trial_with_an_imu_is_a_log_and_a_trial_again(tmp_path: Path) -> None:
    trial, _ = brought(bag(tmp_path / "bag"), LEGS, tmp_path)
    holes = trial.imu.copy()
    holes[7] = np.nan
    write_trial_log(replace(trial, imu=holes), tmp_path / "log.mcap")
    log = read_log(tmp_path / "log.mcap")
    np.testing.assert_array_equal(log.imu, holes)
    words = ["log", "export", str(tmp_path / "log.mcap"), "--format", "trial"]
    assert cli.run([*words, "--out", str(tmp_path / "again.csv")]) == ExitCode.OK
    np.testing.assert_allclose(read_trial(tmp_path / "again.csv").imu, holes, atol=1e-12)


def test_others_read_the_imu_of_a_log(tmp_path: Path) -> None:
    """rosbags is the oracle: stamps, rates, orientation; a log without an IMU has no such topic."""
    path = tmp_path / "log.mcap"
    readings = [
        (ImuRecord(1_000_000_000 + 5, 0.25, 0.1, -0.2), ImuRecord(1_000_000_007, -0.5, 0.0, 0.0)),
        (ImuRecord(1_010_000_000, 0.5, np.nan, np.nan),),
    ]
    for name, given in (("log", readings), ("none", [(), ()])):
        writer = LogWriter(
            tmp_path / f"{name}.mcap", names=NAMES, config_text="", metadata={},
            start_ns=1_000_000_000, start_unix_ns=START_NS,
        )  # fmt: skip
        for k, imu in enumerate(given):
            tick = make_tick(k)
            writer.write(replace(tick, inputs=replace(tick.inputs, imu=imu)))
        writer.close()
        assert writer.error is None
    with AnyReader([path]) as reader:
        connections = [one for one in reader.connections if one.topic == "/imu"]
        seen: list[Any] = [
            reader.deserialize(data, c.msgtype) for c, _, data in reader.messages(connections)
        ]
    assert [one.angular_velocity.z for one in seen] == [0.25, -0.5, 0.5]
    assert seen[0].header.stamp.nanosec == START_NS % 10**9 + 5
    turn = seen[0].orientation
    yaw, pitch, roll = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_euler("ZYX")
    assert (yaw, pitch, roll) == pytest.approx((0.0, -0.2, 0.1), abs=1e-12)
    assert seen[0].orientation_covariance[0] == 0
    assert seen[2].orientation_covariance[0] == -1
    assert seen[2].linear_acceleration_covariance[0] == -1
    with AnyReader([tmp_path / "none.mcap"]) as reader:
        assert "/imu" not in reader.topics
    assert next(tick.inputs.imu for tick in read_ticks(path)) == readings[0]
