"""A robot file without [force_sensor] and legs.transducer: nothing talks to a unit or claims to have."""

import re
from pathlib import Path

import numpy as np
import pytest

from model.errors import ConfigError
from robot.cli.main import run as command
from robot.config.robot_file import load_robot, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.run.force_unit import unit_settings, wanted_unit, why_no_unit
from robot.virtual.open import VirtualSettings, open_in_memory

NOMINAL = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
TABLE = NOMINAL[NOMINAL.index("[force_sensor]") : NOMINAL.index("[loop]")]
(TRANSDUCER,) = re.findall(r"^transducer.*\n", NOMINAL, re.MULTILINE)
WITHOUT_TABLE = NOMINAL.replace(TABLE, "")
WITHOUT = WITHOUT_TABLE.replace(TRANSDUCER, "")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "robot.toml"
    path.write_text(WITHOUT, encoding="utf-8")
    return path


def test_both_may_be_left_out() -> None:
    config = parse_robot(WITHOUT)
    assert not config.force_sensor.any
    assert config.force_sensor.names == config.parameters.legs.names
    np.testing.assert_array_equal(config.force_sensor.transducers, 0)
    assert parse_robot(NOMINAL).force_sensor.any


def test_a_unit_without_transducers_is_none_either() -> None:
    assert not parse_robot(NOMINAL.replace(TRANSDUCER, "")).force_sensor.any


def test_transducers_without_a_unit_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"force_sensor: is missing, and legs\.transducer"):
        parse_robot(WITHOUT_TABLE)


def test_a_calibration_of_sensors_that_are_not_there_is_refused(file: Path) -> None:
    with pytest.raises(ConfigError, match="the robot file has none"):
        load_robot(file, file.parent / "calibration.toml")


def test_no_unit_is_wanted_and_none_can_be_named() -> None:
    sensors = parse_robot(WITHOUT).force_sensor
    assert wanted_unit(None, sensors) is None
    assert wanted_unit("none", sensors) is None
    assert why_no_unit(sensors) == "no force sensors in the robot file"
    for text in (None, "192.168.0.9"):
        with pytest.raises(ConfigError, match="the robot file has no force sensors"):
            unit_settings(text, sensors)
    with pytest.raises(ConfigError, match="the robot file has no force sensors"):
        wanted_unit("192.168.0.9", sensors)
    with_sensors = parse_robot(NOMINAL).force_sensor
    assert wanted_unit(None, with_sensors) is with_sensors
    assert why_no_unit(with_sensors) == "left out with --force-unit none"


def test_a_virtual_robot_has_no_unit_either() -> None:
    rig = open_in_memory(parse_robot(WITHOUT), VirtualSettings(armed=False))
    try:
        assert rig.calibrations == (None,) * 6
        assert rig.read().forces == ()
    finally:
        rig.close()


@pytest.mark.parametrize(
    "words",
    [
        ["force", "watch", "--seconds", "1"],
        ["force", "bias"],
        ["force", "identify", "--hardware", "virtual"],
        ["force", "calibrate", "--hardware", "virtual"],
    ],
)
def test_commands_of_the_sensors_refuse_in_a_sentence(
    words: list[str],
    file: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(file.parent)
    assert command([*words, "--robot", str(file)]) == 2
    said = capsys.readouterr().err
    assert "the robot file has no force sensors" in said
    assert len(said.strip().splitlines()) == 1


def test_the_virtual_check_leaves_the_unit_out(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command(["check", "--robot", str(file)])
    said = capsys.readouterr().out
    assert re.search(r"^skip +force unit +no force sensors in the robot file$", said, re.MULTILINE)
    for probed in ("force units", "matrix (MULT)", "packet rate", "transducers", "battery light"):
        assert probed not in said
    # what can fail is the loop in real time, on a busy machine
    assert re.search(r"^\d+ passed, \d+ warned, \d+ failed, 1 skipped$", said, re.MULTILINE)
    assert not re.search(r"^fail +(?!loop)", said, re.MULTILINE)


@pytest.mark.usefixtures("words_only")
@pytest.mark.parametrize("step", ["10", "11"])
def test_the_first_day_skips_the_sensors(
    step: str, file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(file.parent / "day")
    words = ["bringup", "--robot", str(file), "--only", step, "--yes", "--folder", folder]
    assert command(words) == 0
    said = capsys.readouterr().out
    assert re.search(r"skip +force unit +no force sensors in the robot file", said)
    assert "  pass  " not in said
