"""The example on C-legs without force sensors walks virtually; its log is shown, tracked and replayed."""

import re
from pathlib import Path

import numpy as np
import pytest

from model.errors import ConfigError, GapError
from model.kinematics.legs import leg_kinematics
from model.values.tick import Mode, Tick
from record.log.reader import LogContents, read_ticks
from robot.campaign.plan import read_scenario
from robot.cli.main import run as command
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.virtual.file_twin import file_twin
from robot.virtual.twin_rollout import twin_simulator
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


@pytest.mark.soak
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


def test_the_mujoco_robot_is_diagnosed_with_the_effects_of_its_legs() -> None:
    text = WHEEL.read_text(encoding="utf-8")
    offered = {effect.name for effect in twin_simulator(text).effects}
    assert offered.isdisjoint({"link_length", "foot_rolling"})
    assert "leg_stiffness" in offered
    with pytest.raises(GapError, match="cannot have link_length: a crank has no links"):
        twin_simulator(text, ("link_length",))


SCENARIO = """
[campaign]
seed = 1
seconds = 10.0
robots = ["{robot}"]
[conditions]
gaits = ["tripod"]
frequencies_hz = [0.2]
steer = [0.0]
[references]
count = 0
[cases]
controls = 0
effects = {effects}
severities = [[0.0, 0.3]]
repeats = 1
pairs = 0
outside = 0
"""


def test_a_campaign_draws_what_the_robot_can_have(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text(SCENARIO.format(robot=WHEEL, effects='["*"]'), encoding="utf-8")
    drawn = set(read_scenario(path).effects)
    assert drawn.isdisjoint({"link_length", "foot_rolling", "force_gain", "force_delay"})
    assert {"leg_stiffness", "pose_delay"} < drawn
    for effect, why in (("link_length", "no links"), ("force_gain", "no force sensors")):
        path.write_text(SCENARIO.format(robot=WHEEL, effects=f'["{effect}"]'), encoding="utf-8")
        with pytest.raises(ConfigError, match=f"{effect} cannot be: .*{why}"):
            read_scenario(path)
