"""The example on C-legs without force sensors walks virtually; its log is shown, tracked and replayed."""

import re
from pathlib import Path

import numpy as np
import pytest

from model.kinematics.legs import leg_kinematics
from model.values.tick import Mode, Tick
from record.log.reader import LogContents, read_ticks
from robot.cli.main import run as command
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.virtual.file_twin import file_twin
from sim_hw.plant.parameters import CrankLegs, PlantParameters
from sim_hw.plant.plant import Plant

WHEEL = Path(__file__).resolve().parents[3] / "examples" / "wheel_hexapod.toml"


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("wheel") / "walk.mcap"
    words = ["--robot", str(WHEEL), "--virtual-time", "--cycles", "2", "--log", str(path)]
    assert command(["drive", *words]) == ExitCode.OK
    return path


@pytest.fixture(scope="module")
def ticks(log: Path) -> list[Tick]:
    return [tick for tick in read_ticks(log, LogContents()) if tick.mode is Mode.WALK]


def test_it_walks_as_far_as_its_legs_roll(ticks: list[Tick]) -> None:
    """Without slip the body goes what the matter of the standing feet goes back."""
    config = load_robot(WHEEL)
    kinematics = leg_kinematics(config.parameters)
    t_s = np.array([tick.joints.t_ns for tick in ticks]) * 1e-9
    angle = np.array([tick.joints.angle_rad for tick in ticks])
    feet = kinematics.feet(angle, np.gradient(angle, t_s, axis=0))
    truth = [tick.inputs.truth for tick in ticks]
    load = np.array([one.foot_force_B[:, 2] for one in truth if one is not None])
    back = -(feet.velocity_m_s[..., 0] * load).sum(axis=1) / load.sum(axis=1)
    true = np.array([one.position_W[0] for one in truth if one is not None])
    assert true[-1] - true[0] > 0.25
    assert np.trapezoid(back, t_s) == pytest.approx(true[-1] - true[0], rel=0.03)


def test_no_tick_has_a_force_and_none_is_missed(ticks: list[Tick]) -> None:
    assert not any(tick.forces.valid.any() for tick in ticks)
    assert not any(tick.faults for tick in ticks)


def test_odometry_ends_within_five_percent_of_the_path(
    log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(["odom", str(log), "--compare"]) == ExitCode.OK
    said = capsys.readouterr().out
    (row,) = re.findall(r"^estimator .*$", said, re.MULTILINE)
    head = next(line for line in said.splitlines() if "RPE 0.25 m" in line)
    end = float(row[: head.index("end") + len("end")].split()[-1])
    assert end < 5.0


def test_show_says_that_there_are_no_sensors(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["show", str(log), "--out", str(log.with_suffix(".html"))]) == ExitCode.OK
    assert re.search(r"^foot forces +no force sensors$", capsys.readouterr().out, re.MULTILINE)


def test_a_replay_repeats_it(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["replay", str(log)]) == ExitCode.OK
    assert "equal" in capsys.readouterr().out


def test_its_plant_stands_on_its_toes() -> None:
    config = load_robot(WHEEL)
    twin = file_twin(config, 0)
    parameters = PlantParameters.nominal(config.parameters) if twin is None else twin.plant
    assert isinstance(parameters.leg, CrankLegs)
    plant = Plant(parameters)
    weight = parameters.mass * parameters.gravity
    assert plant.foot_force_B[:, 2].sum() == pytest.approx(weight, rel=1e-3)
    sag = weight / parameters.stiffness.sum()
    np.testing.assert_allclose(plant.feet_B[:, 2], -parameters.leg.length + sag, atol=2e-4)


def test_effects_that_cranks_cannot_have_are_refused_by_the_twin(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["sim", "run", "--robot", str(WHEEL), "--fast", "--out", str(tmp_path / "x.parquet")]
    assert command([*words, "--effect", "link_length@ML:crank_m=0.004"]) == ExitCode.USAGE
    assert "cranks and have no links" in capsys.readouterr().err
    assert command([*words, "--effect", "foot_rolling:radius_m=0.01"]) == ExitCode.USAGE
    assert "roll already" in capsys.readouterr().err
