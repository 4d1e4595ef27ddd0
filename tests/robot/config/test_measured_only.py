"""A robot that is only measured: its file says nothing of servos, sensors, gaits and the loop."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tomlkit

from model.errors import ConfigError
from robot.cli import main as cli
from robot.config.robot_file import load_robot, parse_robot
from robot.config.undriven import DRIVING_TABLES
from robot.control.controller import Controller
from robot.gap_report.abilities import odometry_ability
from robot.virtual.twin_run import make_twin, plan_of, walk_fast

KEPT = ("name", "body", "legs", "leg", "contact")


def measured_only() -> str:
    """The nominal robot's file with what a diagnosis needs, and nothing else."""
    whole = tomlkit.parse(load_robot().text)
    document = {key: whole[key] for key in KEPT}
    document["legs"] = {key: whole["legs"][key] for key in ("order", "shaft_position")}
    return tomlkit.dumps(document)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "lab.toml"
    path.write_text(measured_only())
    return path


def test_it_is_read_with_the_same_model_and_without_a_servo() -> None:
    config, whole = parse_robot(measured_only()), load_robot()
    assert not config.driven
    assert whole.driven
    assert config.parameters.gaits == ()
    assert np.isnan(config.parameters.servo.max_speed)
    assert config.parameters.body.mass == whole.parameters.body.mass
    shafts = config.parameters.legs.shaft_position
    np.testing.assert_array_equal(shafts, whole.parameters.legs.shaft_position)


def test_it_is_not_driven_and_says_what_to_add(file: Path) -> None:
    with pytest.raises(ConfigError, match=r"servo: is missing: this robot is measured and not"):
        load_robot(file)
    with pytest.raises(ConfigError, match=r"to drive it, add \[servo\], \[servo_bus\]"):
        Controller(load_robot(file, driven=False), (), armed=False)


@pytest.mark.parametrize("table", sorted(DRIVING_TABLES))
def test_a_table_of_what_drives_it_makes_the_rest_missing(table: str) -> None:
    """A forgotten table is an error that names it, and no robot without servos."""
    with pytest.raises(ConfigError, match="is missing"):
        parse_robot(f"{measured_only()}\n[{table}]\n")


def test_it_is_shown_standing(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["robot", "show", str(file)]) == 0
    shown = capsys.readouterr().out
    assert "131 mm below the shafts; a turn takes them over 101 mm and up by 34 mm" in shown
    assert "standing" in shown
    assert "force sensors  none" in shown


def test_what_it_measured_has_an_odometry() -> None:
    config = load_robot()
    walk = walk_fast(
        config, make_twin(config, (), 1), plan_of(config, "tripod", None, 4.0, 0.0), lambda _: None
    )
    header = replace(walk.header, robot_file="lab.toml", robot_text=measured_only())
    assert odometry_ability(replace(walk, header=header)).answered
