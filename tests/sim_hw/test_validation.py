"""The twin against physics and data sheets, without any model of ours."""

from dataclasses import replace

import numpy as np
import pytest

from sim_hw.plant.foot_surface import varies
from sim_hw.plant.leg_path import foot_path
from sim_hw.plant.motor import motor_row, turned
from sim_hw.plant.parameters import GroundParameters
from sim_hw.plant.plant import Plant
from tests.sim_hw.twins import GAIN, NOMINAL, ON, WEIGHT, hold, plant

OFF = ~ON
STAND_Z = float(foot_path(NOMINAL, np.zeros(6))[1].min())


def on_slope(slope_x: float, slope_y: float, mu: float) -> Plant:
    """Put down on a slope with torque on, and left for a second."""
    ground = GroundParameters(np.array([slope_x, slope_y]), np.full(6, np.inf))
    robot = Plant(replace(NOMINAL, ground=ground, mu=np.full(6, mu)))
    sag = WEIGHT / NOMINAL.stiffness.sum()
    robot.place(height_m=-STAND_Z - sag, angle_rad=np.zeros(6))
    hold(robot, 1.0)
    return robot


def tilt_from_ground(robot: Plant) -> float:
    """Angle between the body's up and the ground's normal [rad]."""
    robot.refresh()
    return float(np.arccos(np.clip(robot.torso_rotation[:, 2] @ robot._normal, -1, 1)))


def test_it_tips_at_the_angle_of_its_stance() -> None:
    """tan = half the width over the height of the centre of mass; springs that swing take some of it."""
    limit = 0.25 / -STAND_Z
    assert limit == pytest.approx(1.93, abs=0.05)
    assert tilt_from_ground(on_slope(0.0, 0.75 * limit, mu=5.0)) < 0.1
    assert tilt_from_ground(on_slope(0.0, 1.03 * limit, mu=5.0)) > 0.3


@pytest.mark.parametrize(("slope", "slides"), [(0.56, False), (0.64, True)])
def test_it_slides_down_a_slope_beyond_mu(slope: float, slides: bool) -> None:
    robot = on_slope(0.0, slope, mu=0.6)
    speed = float(np.linalg.norm(robot.data.qvel[:3]))
    assert (speed > 0.02) is slides


def test_a_slide_against_drag_reaches_its_terminal_speed() -> None:
    robot = plant("ground_slope:slope_x=0.2", "friction_level:ratio=0.1667", "drag:n_s_per_m=60")
    assert not varies(robot.parameters)
    hold(robot, 1.5)
    angle = np.arctan(0.2)
    # the damper takes the horizontal part of the speed
    force = WEIGHT * (np.sin(angle) - 0.1 * np.cos(angle))
    expected = force / (60 * np.cos(angle) ** 2)
    speed = float(np.linalg.norm(robot.data.qvel[:3]))
    assert speed == pytest.approx(expected, rel=0.05)


def test_it_falls_freely() -> None:
    robot = Plant(NOMINAL)
    robot.place(height_m=1.0, angle_rad=np.zeros(6))
    for _ in range(200):
        robot.step(np.zeros(6), OFF)
    robot.refresh()
    fallen = 1.0 - robot.data.xipos[:, 2] @ robot.model.body_mass / NOMINAL.mass
    assert fallen == pytest.approx(0.5 * NOMINAL.gravity * 0.2**2, rel=0.01)


@pytest.mark.parametrize("dry", [True, False])
def test_a_lifted_leg_falls_unless_dry_friction_holds_it(dry: bool) -> None:
    """Torque off, five feet on the ground: J a = weight of the foot times the slope of its path."""
    free = replace(NOMINAL.motors[0], stribeck=0.0, load=0.0, load_stribeck=0.0, viscous=0.0)
    robot = Plant(NOMINAL if dry else replace(NOMINAL, motors=(free,) * NOMINAL.legs))
    angle = np.array([0.0, 2.6, 0.0, 0.0, 0.0, 0.0])
    robot.place(height_m=-STAND_Z - WEIGHT / NOMINAL.stiffness.sum(), angle_rad=angle)
    driven = np.array([True, False, True, True, True, True])
    for _ in range(150):
        robot.step(GAIN * (angle - robot.shaft_angle_rad), driven)
    turn = robot.shaft_angle_rad[1] - 2.6
    if dry:
        assert turn == 0.0, "as an unpowered MX-106 does"
        return
    slope = foot_path(NOMINAL, angle)[3][1]
    expected = -NOMINAL.foot_mass * NOMINAL.gravity * slope / NOMINAL.motors[0].armature
    assert turn == pytest.approx(0.5 * expected * 0.15**2, rel=0.2)


def test_a_step_of_the_servo() -> None:
    """A shaft in the air follows a step in under 0.15 s and stops within its friction's dead band."""
    robot = Plant(replace(NOMINAL, gravity=1e-9))
    robot.place(height_m=2.0, angle_rad=np.zeros(6))
    path = []
    for _ in range(400):
        robot.step(GAIN * (0.2 - robot.shaft_angle_rad), ON)
        path.append(robot.shaft_angle_rad[0])
    rise = float(np.argmax(np.array(path) > 0.18)) * 1e-3
    assert 0.03 < rise < 0.15
    assert path[-1] == pytest.approx(0.2, abs=0.2 / 55.0 + 1e-3), "0.2 N m on 55 N m/rad"
    assert max(path) < 0.22


@pytest.mark.parametrize("load", [0.0, 1.0, 2.0])
def test_speed_under_load_is_near_the_data_sheets_line(load: float) -> None:
    """12 V: 4.71 rad/s without load, 8.4 N m at standstill; the identified motor has more friction."""
    motor = NOMINAL.motors[0]
    stall = motor.torque_constant * 12.0 * motor.duty_limit / motor.resistance
    emf, rate = motor.torque_constant**2 / motor.resistance, 0.0
    for _ in range(2000):
        rate = turned(motor_row(motor), rate, stall, emf, -load, 0.0, 2.5e-4)
    sheet = 4.71 * (1 - load / 8.4)
    assert rate == pytest.approx(sheet, rel=0.15)
