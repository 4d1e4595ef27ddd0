"""URDF and MJCF of the robot file: MuJoCo loads them, and their feet are where the linkage puts them."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from model.kinematics.crank import crank_pose
from model.values.parameters import CrankParameters, FourBarParameters
from robot.cli.main import run as command
from robot.config.four_bar_xml import coupler_angles
from robot.config.robot_file import load_robot
from robot.config.xml import mjcf_text, urdf_text
from robot.config.xml_elements import LINK_RADIUS
from sim_hw.plant.leg_path import foot_path
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
    assert isinstance(ROBOT.leg, FourBarParameters)
    crank, coupler = coupler_angles(ROBOT.leg, angle)
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


@pytest.mark.parametrize("leg", [CrankParameters(0.11, 0.0), CrankParameters(0.11, 0.05)])
@pytest.mark.parametrize("angle", [-1.0, 0.0, 2.5])
def test_toes_of_cranks_are_at_their_length(leg: CrankParameters, angle: float) -> None:
    robot = replace(ROBOT, leg=leg)
    toe = ROBOT.legs.shaft_position - leg.length * np.array([np.sin(angle), 0.0, np.cos(angle)])
    urdf = mujoco.MjModel.from_xml_string(urdf_text("r", robot))
    data = mujoco.MjData(urdf)
    for name in robot.legs.names:
        data.joint(f"{name}_shaft_joint").qpos[0] = angle
    mujoco.mj_kinematics(urdf, data)
    found = np.array([data.body(f"{name}_foot").xpos for name in robot.legs.names])
    assert found == pytest.approx(toe, abs=1e-6)
    mjcf = mujoco.MjModel.from_xml_string(mjcf_text("r", robot))
    for model in (urdf, mjcf):
        assert model.body_mass.sum() == pytest.approx(robot.body.mass)
    data = mujoco.MjData(mjcf)
    for name in robot.legs.names:
        data.joint(f"{name}_shaft").qpos[0] = angle
    mujoco.mj_kinematics(mjcf, data)
    found = np.array([data.site(f"{name}_foot").xpos for name in robot.legs.names])
    assert found - data.body("torso").xpos == pytest.approx(toe, abs=1e-6)


def test_the_lowest_point_of_a_round_leg_is_the_models_foot() -> None:
    """MuJoCo's own distance from the ground to the leg's geoms, against the kinematics."""
    leg = CrankParameters(0.11, 0.05)
    model = mujoco.MjModel.from_xml_string(mjcf_text("r", replace(ROBOT, leg=leg)))
    data, ground = mujoco.MjData(model), model.geom("ground").id
    ends = np.zeros(6)
    touching = [
        geom
        for geom in range(model.ngeom)
        if model.geom_bodyid[geom] == model.body("ML_leg").id and model.geom_conaffinity[geom]
    ]
    for angle in np.linspace(-1.3, 1.3, 27):
        data.joint("ML_shaft").qpos[0] = angle
        mujoco.mj_kinematics(model, data)
        shaft = data.body("ML_leg").xpos[2]
        distances = [mujoco.mj_geomDistance(model, data, ground, g, 1.0, ends) for g in touching]
        # bars are chords of the half circle, so that between corners they are a little short of it; the
        # toe is rounded
        rounded = LINK_RADIUS * (1 - np.cos(angle)) if angle > 0 else 0.0
        assert min(distances) - shaft == pytest.approx(
            crank_pose(leg, np.array(angle)).foot[1] - rounded, abs=3e-4
        )


def test_the_command_writes_both(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = [str(tmp_path / "r.urdf"), str(tmp_path / "r.xml")]
    assert command(["robot", "export", "--urdf", out[0], "--mjcf", out[1]]) == 0
    assert capsys.readouterr().out.count("MuJoCo loads it") == 2
    assert command(["robot", "export"]) == 2
    assert command(["robot", "export", "--urdf", str(tmp_path / "no" / "r.urdf")]) == 4
