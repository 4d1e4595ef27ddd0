"""The calibration file: written, read, named by a robot file or the command line, and applied."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.ati.calibration import Calibration
from drivers.ati.foot_forces import ForceScales
from drivers.ati.setup import check_serials
from model.errors import ConfigError, ForceStreamError
from model.values.force_calibration import ForceCalibration
from model.values.readings import ForceRecord
from robot.config.calibration import (
    format_calibration,
    parse_calibration,
    read_calibration,
    write_calibration,
)
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE

LEGS = ("HL", "ML", "FL", "HR", "MR", "FR")
UNIT = Calibration(1, "FT1", "", "", 1e6, 1e6, mult_on=True, max_rating=(1.0,) * 6)


def made(seed: int = 0) -> ForceCalibration:
    random = np.random.default_rng(seed)
    unloaded = random.normal(size=(6, 6, 5))
    unloaded[4] = np.nan  # MR was not calibrated
    correction = 0.1 * random.normal(size=(6, 6, 6))
    correction[4] = 0.0
    error = np.abs(random.normal(size=(6, 6)))
    error[4] = np.nan
    serials = ("FT1", "FT2", "", "FT4", "", "FT6")
    return ForceCalibration(
        LEGS,
        serials,
        unloaded,
        correction,
        error,
        "in-situ",
        "2026-11-21",
        ("a.mcap", 'b "2".mcap'),
    )


def test_a_file_is_read_back_exactly(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    written = made()
    write_calibration(path, written)
    read = read_calibration(path, LEGS)
    for name in ("unloaded", "correction", "standard_error"):
        assert np.array_equal(getattr(read, name), getattr(written, name), equal_nan=True), name
    for name in ("legs", "serials", "method", "date", "logs"):
        assert getattr(read, name) == getattr(written, name), name
    assert "# MR: not calibrated" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("format = 1", "format = 2", "format: must be from 1 to 1"),
        ('method = "in-situ"', 'method = "guess"', "method: must be one of bias, in-situ"),
        ('"HL", "ML"', '"ML", "HL"', "not this robot's legs"),
        ("harmonics = 2", "harmonics = 1", "unloaded[0]: must have 3 entries"),
        ("correction = [", "corection = [", "correction: is missing"),
        ("[sensor.", "[sensors.", "sensors: is not a known key"),
        ("date = ", "date = = ", "is not valid TOML"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(old: str, new: str, said: str) -> None:
    text = format_calibration(made())
    assert old in text
    with pytest.raises(ConfigError) as caught:
        parse_calibration(text.replace(old, new), LEGS)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_robot_file_names_it_relative_to_itself(tmp_path: Path) -> None:
    text = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
    robot = tmp_path / "robot.toml"
    robot.write_text(
        text.replace("[force_sensor]", '[force_sensor]\ncalibration = "c.toml"'), encoding="utf-8"
    )
    with pytest.raises(ConfigError, match=r"c\.toml: the calibration file cannot be read"):
        load_robot(robot)
    write_calibration(tmp_path / "c.toml", made(1))
    found = load_robot(robot).force_sensor.calibration
    assert found is not None
    assert np.array_equal(found.correction, made(1).correction)
    write_calibration(tmp_path / "other.toml", made(2))
    instead = load_robot(robot, tmp_path / "other.toml").force_sensor.calibration
    assert instead is not None
    assert np.array_equal(instead.correction, made(2).correction)


def test_a_robot_file_without_one_loads_as_before() -> None:
    config = load_robot()
    assert config.calibration_file == ""
    assert config.force_sensor.calibration is None


def record(counts: np.ndarray) -> ForceRecord:
    yes, no = np.ones(6, dtype=bool), np.zeros(6, dtype=bool)
    return ForceRecord(5, 0, 1, np.zeros(2, dtype=np.int64), 7, 0x3F, counts, yes, no)


def test_forces_are_the_corrected_wrenches_turned_into_the_body() -> None:
    """One leg by hand: reading, less what it reads in the air at this angle, times I + D, turned."""
    calibration = made()
    yaw = np.full(6, np.pi / 2)
    settings = replace(load_robot().force_sensor, calibration=calibration, yaw_rad=yaw)
    random = np.random.default_rng(3)
    counts = random.integers(-(10**7), 10**7, (6, 6))
    angle = random.uniform(-9, 9, 6)
    forces = ForceScales((UNIT,) * 6, settings).forces(record(counts), angle)
    q = angle[2]
    in_air = calibration.unloaded[2] @ [1, np.cos(q), np.sin(q), np.cos(2 * q), np.sin(2 * q)]
    wrench = (np.eye(6) + calibration.correction[2]) @ (counts[2] * 1e-6 - in_air)
    assert forces.force_n[2] == pytest.approx([-wrench[1], wrench[0], wrench[2]])
    assert forces.valid.tolist() == [True, True, True, True, False, True], "MR has none"
    angle[0] = np.nan
    unknown = ForceScales((UNIT,) * 6, settings).forces(record(counts), angle)
    assert unknown.valid.tolist() == [False, True, True, True, False, True]
    assert np.isnan(unknown.force_n[0]).all()


def test_a_calibration_of_another_transducer_is_refused() -> None:
    settings = replace(load_robot().force_sensor, calibration=made())
    check_serials((UNIT, None, None, None, None, None), settings)
    with pytest.raises(ForceStreamError, match="of transducer 'FT2' on leg ML, but 'FT1' is there"):
        check_serials((UNIT, UNIT, None, None, None, None), settings)
