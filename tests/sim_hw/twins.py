"""Twins with effects, and a plant held by the servos' position loop, for tests."""

import mujoco
import numpy as np

from model.values.arrays import FloatArray
from robot.config.robot_file import load_robot
from sim_hw.plant.leg_kernel import MOTOR_RATE
from sim_hw.plant.leg_path import foot_path
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.plant import Plant
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import apply_effects, parse_effect
from sim_hw.twin.sensing import SensorParameters
from sim_hw.twin.twin import Twin

ROBOT = load_robot().parameters
NOMINAL = PlantParameters.nominal(ROBOT)
WEIGHT = NOMINAL.mass * NOMINAL.gravity
ON = np.ones(6, dtype=bool)
GAIN = 4.89


def twin(*texts: str) -> Twin:
    """The nominal robot, no day's scatter, with effects."""
    plain = Twin(ROBOT.legs.names, NOMINAL, SensorParameters.healthy(6), seed=0)
    return apply_effects(plain, [parse_effect(text, EFFECTS) for text in texts], EFFECTS)


def plant(*texts: str) -> Plant:
    return Plant(twin(*texts).plant)


def hold(robot: Plant, seconds: float, goal: np.ndarray | float = 0.0) -> None:
    for _ in range(round(seconds / robot.dt_s)):
        robot.step(GAIN * (goal - robot.motor_angle_rad), ON)


def force_W(robot: Plant) -> FloatArray:  # noqa: N802 - frame suffix
    """The ground's force on each foot in the last step, world axes, (N, 3) [N]."""
    robot.refresh()
    force: FloatArray = robot.foot_force_B @ robot.torso_rotation.T
    return force


def energy_j(robot: Plant) -> float:
    """Kinetic, gravitational and spring energy, the motors' rotors included."""
    p, model, data = robot.parameters, robot.model, robot.data
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    mujoco.mj_energyVel(model, data)
    potential = p.gravity * float(model.body_mass @ data.xipos[:, 2])
    x, z, _, _ = foot_path(p, robot.shaft_angle_rad + p.drive.crank_offset)
    ends = np.stack([x, np.zeros(p.legs), z - p.leg_offset], axis=1)
    stretch = data.qpos[robot._foot_q] - ends
    stiffness = np.column_stack([p.side_stiffness, p.stiffness])
    springs = 0.5 * float((stiffness * stretch**2).sum())
    rotors = 0.5 * p.motors[0].armature * float((robot.leg_state[:, MOTOR_RATE] ** 2).sum())
    return float(data.energy[1]) + potential + springs + rotors


def sliding_ratio(robot: Plant, direction: tuple[float, float]) -> np.ndarray:
    """Traction over load of each foot while the body is dragged along a direction, (N,); NaN in the air."""
    hold(robot, 0.1)
    robot.push(np.array([*direction, 0.0]) * 0.9 * WEIGHT, np.zeros(3))
    hold(robot, 0.1)
    force = force_W(robot)
    robot.push(np.zeros(3), np.zeros(3))
    down = np.where(force[:, 2] > 1.0, force[:, 2], np.nan)
    assert np.isfinite(down).sum() >= 3
    return np.hypot(force[:, 0], force[:, 1]) / down
