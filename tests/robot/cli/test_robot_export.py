"""URDF and MJCF of the robot file: MuJoCo loads them, and their feet are where the linkage puts them."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from robot.cli.main import run as command
from robot.config.robot_file import load_robot
from robot.config.xml import coupler_angles, mjcf_text, urdf_text
from sim_hw.plant.four_bar import foot_path
from sim_hw.plant.parameters import PlantParameters

ROBOT = load_robot().parameters
PLANT = PlantParameters.nominal(ROBOT)


def feet(angle: float) -> np.ndarray:
    x, z, _, _ = foot_path(PLANT, np.full(6, angle))
    return ROBOT.legs.shaft_position + np.stack([x, 0 * x, z], axis=1)


@pytest.mark.parametrize("angle", [-1.0, 0.0, 2.5])
def test_feet_of_the_urdf_are_where_the_linkage_puts_them(angle: float) -> None:
    model = mujoco.MjModel.from_xml_string(urdf_text("r", ROBOT))
    data = mujoco.MjData(model)
    crank, coupler = coupler_angles(ROBOT, angle)
    for leg in ROBOT.legs.names:
        data.joint(f"{leg}_shaft_joint").qpos[0] = angle
        data.joint(f"{leg}_coupler_joint").qpos[0] = coupler - crank
    mujoco.mj_kinematics(model, data)
    found = np.array([data.body(f"{leg}_foot").xpos for leg in ROBOT.legs.names])
    assert found == pytest.approx(feet(angle), abs=1e-6)
    assert model.body_mass.sum() == pytest.approx(ROBOT.body.mass)


def test_the_mjcf_closes_its_loops_while_the_shafts_turn() -> None:
    model = mujoco.MjModel.from_xml_string(mjcf_text("r", ROBOT))
    model.opt.gravity[:] = 0
    data = mujoco.MjData(model)
    data.qpos[2] = 1.0
    for step in range(4000):
        data.ctrl[:] = 1.5 * step / 4000
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    angle = float(data.joint("ML_shaft").qpos[0])
    assert angle > 1.2
    turn = data.body("torso").xmat.reshape(3, 3)
    at = np.array([data.site(f"{leg}_foot").xpos for leg in ROBOT.legs.names])
    assert (at - data.body("torso").xpos) @ turn == pytest.approx(feet(angle), abs=1e-3)


def test_the_command_writes_both(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = [str(tmp_path / "r.urdf"), str(tmp_path / "r.xml")]
    assert command(["robot", "export", "--urdf", out[0], "--mjcf", out[1]]) == 0
    assert capsys.readouterr().out.count("MuJoCo loads it") == 2
    assert command(["robot", "export"]) == 2
    assert command(["robot", "export", "--urdf", str(tmp_path / "no" / "r.urdf")]) == 4
