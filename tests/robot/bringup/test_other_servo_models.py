"""Servo commands on a bus of several models: scan, setup, backup and restore go by the model of each."""

from pathlib import Path

import numpy as np
import pytest

from drivers.dynamixel.catalog import MODEL_BY_NAME
from drivers.dynamixel.condition import ServoCondition
from model.errors import ConfigError
from robot.bringup.mapping.motion import current_words, largest
from robot.bringup.preflight.finding import CheckVerdict
from robot.bringup.preflight.servos import condition_findings
from robot.bringup.servo.backup import load_backup
from robot.bringup.servo.setup import wanted_of
from robot.config.robot_file import parse_robot
from robot.console.exit_codes import ExitCode
from tests.robot.other_servos import MIXED, MIXED_MODELS, XL430, other_robot
from tests.robot.servo_bench import Bench

Capture = pytest.CaptureFixture[str]
MODELS = tuple(MODEL_BY_NAME[name] for name in MIXED_MODELS)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch, models=MODELS)


@pytest.fixture
def robot(tmp_path: Path) -> str:
    path = tmp_path / "mixed.toml"
    path.write_text(other_robot(*MIXED), encoding="utf-8")
    return str(path)


def test_a_scan_names_each_model(bench: Bench, capsys: Capture) -> None:
    bench.servo(2).table.set("model_number", 9999)
    assert bench.devices("--baud", "1000000") == ExitCode.OK
    lines = [line for line in capsys.readouterr().out.splitlines() if "firmware" in line]
    names = [*MIXED_MODELS[:2], "model 9999", *MIXED_MODELS[3:]]
    assert all(name in line for name, line in zip(names, lines, strict=True))


def test_setup_wants_of_each_what_its_model_can(bench: Bench, robot: str, capsys: Capture) -> None:
    bench.servo(0).table.set("current_limit", 100)
    bench.servo(3).table.set("velocity_limit", 10)
    assert bench.command("setup", "--yes", "--robot", robot) == ExitCode.OK
    out = capsys.readouterr().out
    assert bench.servo(0).table.get("current_limit") == 1193
    assert "1193 (3.21 A)" in out
    assert bench.servo(3).table.get("velocity_limit") == 306
    assert bench.command("setup", "--robot", robot) == ExitCode.OK
    assert capsys.readouterr().out.count("as wanted") == 6


def test_what_is_wanted_lies_within_the_table_of_every_model() -> None:
    config = parse_robot(other_robot(*XL430))
    for model in MODEL_BY_NAME.values():
        for one in wanted_of(config, 1_000_000, model):
            register = model.table[one.name]
            assert register.minimum <= one.value <= register.maximum, (model.name, one.name)
            assert one.lowest <= one.value <= one.highest, (model.name, one.name)


def test_setup_of_another_model_than_the_robot_file_says(bench: Bench, capsys: Capture) -> None:
    assert bench.command("setup", "--yes", "--id", "1") == ExitCode.HARDWARE
    assert (
        "HL (id 1) is an XM430-W350 and the robot file says MX-106(2.0)" in capsys.readouterr().err
    )
    bench.servo(1).table.set("model_number", 9999)
    assert bench.command("setup", "--yes", "--id", "2") == ExitCode.HARDWARE
    assert "ML (id 2) is model 9999, which is not known here" in capsys.readouterr().err


def test_a_backup_of_several_models_goes_back_to_each(
    bench: Bench, tmp_path: Path, capsys: Capture
) -> None:
    path = tmp_path / "servos.toml"
    assert bench.command("backup", "--out", str(path)) == ExitCode.OK
    assert "6 servos (ids 1, 2, 3, 4, 5, 6)" in capsys.readouterr().out
    backup = load_backup(path)
    assert [image.model for image in backup.servos] == [model.number for model in MODELS]
    assert ["current_limit" in image.values for image in backup.servos] == [True] * 3 + [False] + [
        True
    ] * 2
    bench.servo(3).table.set("moving_threshold", 99)
    assert bench.command("restore", str(path), "--yes") == ExitCode.OK
    assert bench.servo(3).table.get("moving_threshold") == 10


def test_a_backup_of_another_model_is_refused_by_name(
    bench: Bench, tmp_path: Path, capsys: Capture
) -> None:
    path = tmp_path / "servos.toml"
    assert bench.command("backup", "--out", str(path)) == ExitCode.OK
    capsys.readouterr()
    bench.servo(3).table.set("model_number", 1060)
    assert bench.command("restore", str(path), "--yes") == ExitCode.HARDWARE
    said = capsys.readouterr().err
    assert "id 4 is XL430-W250 and the backup is of XC430-W240; nothing has been written" in said
    path.write_text(path.read_text().replace("model = 1080", "model = 9999"))
    with pytest.raises(ConfigError, match="is model 9999, which is not known here"):
        load_backup(path)
    path.write_text(path.read_text().replace("model = 9999", "model = 1020"))
    with pytest.raises(ConfigError, match="min_voltage_limit: must be from 95 to 160, not 60"):
        load_backup(path)


def test_a_servo_that_is_not_known_is_left_out_of_a_backup(
    bench: Bench, tmp_path: Path, capsys: Capture
) -> None:
    bench.servo(2).table.set("model_number", 9999)
    path = tmp_path / "servos.toml"
    assert bench.command("backup", "--out", str(path)) == ExitCode.OK
    assert "id 3: model 9999, left out: its registers are not known" in capsys.readouterr().out
    assert len(load_backup(path).servos) == 5


def test_the_check_judges_each_leg_by_its_model() -> None:
    config = parse_robot(other_robot(*MIXED))
    models = dict(zip(config.servo_bus.names, config.servo_bus.models, strict=True))
    sound = [
        ServoCondition(leg, number, model.number, 45, 4, 0, 0, 0x34, False, 0, 12.0, 30.0)
        for number, (leg, model) in enumerate(models.items(), start=1)
    ]
    found = {one.name: one for one in condition_findings(sound, config.limits, models)}
    assert found["model"].verdict is CheckVerdict.PASS
    assert "no limit on current is judged: an XC430-W240 measures none" in found["model"].found
    assert found["firmware"].verdict is CheckVerdict.PASS


def test_a_current_that_is_not_measured_has_no_largest_value() -> None:
    none = np.full((3, 2), np.nan)
    assert np.isnan(largest(none))
    assert current_words(largest(none)) == "current not measured"
    none[1, 0] = -0.25
    assert current_words(largest(none)) == "at most 0.25 A"
