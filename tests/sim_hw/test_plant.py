"""The plant: weight, friction, linkage, energy, servo; checked against physics, not against the model."""

from dataclasses import replace

import numpy as np
import pytest

from model.errors import ConfigError
from robot.config.robot_file import load_robot
from sim_hw.plant.leg_path import foot_path
from sim_hw.plant.motor import friction_budget, motor_row, warmed
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.plant import Plant
from tests.sim_hw.twins import energy_j, force_W

NOMINAL = PlantParameters.nominal(load_robot().parameters)
WEIGHT = NOMINAL.mass * NOMINAL.gravity
ON, OFF = np.ones(6, dtype=bool), np.zeros(6, dtype=bool)
GAIN = 4.89  # duty per radian: the MX-106's default position gain


def hold(plant: Plant, seconds: float, goal: np.ndarray | float = 0.0) -> None:
    for _ in range(round(seconds / plant.dt_s)):
        plant.step(GAIN * (goal - plant.shaft_angle_rad), ON)


def test_it_weighs_what_the_robot_weighs() -> None:
    plant = Plant(NOMINAL)
    hold(plant, 3.0)
    assert plant.model.body_mass.sum() == pytest.approx(NOMINAL.mass)
    force = plant.truth(0).foot_force_B
    assert force[:, 2].sum() == pytest.approx(WEIGHT, rel=1e-4)
    assert np.abs(force[:, :2].sum(axis=0)).max() < 1e-3 * WEIGHT
    assert plant.truth(0).contact.all()


def _stiff(n_per_m: float) -> PlantParameters:
    robot = load_robot().parameters
    contact = replace(robot.contact, stiffness=np.full(6, n_per_m))
    return PlantParameters.nominal(replace(robot, contact=contact))


@pytest.mark.parametrize("n_per_m", [1e4, 2e4, 1.1e5])
def test_stiff_legs_stand_still(n_per_m: float) -> None:
    """From 15 kN/m on they used to tremble by 10 mm/s, because physics could not follow them sideways."""
    plant = Plant(_stiff(n_per_m))
    hold(plant, 2.0)
    assert plant.truth(0).foot_force_B[:, 2].sum() == pytest.approx(WEIGHT, rel=1e-4)
    assert np.abs(plant.truth(0).velocity_B).max() < 1e-4


def test_legs_stiffer_than_physics_can_follow_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"1e\+06 N/m is more than .* give at most 1\.7e\+05 N/m"):
        _stiff(1e6)


def test_moments_balance_about_the_centre_of_mass() -> None:
    plant = Plant(NOMINAL)
    hold(plant, 3.0)
    truth = plant.truth(0)
    lever = truth.foot_position_W - truth.position_W
    moment = np.cross(lever, force_W(plant)).sum(axis=0)
    assert np.abs(moment).max() < 2e-3 * WEIGHT * 0.25


@pytest.mark.parametrize("driven", [ON, OFF], ids=["torque on", "torque off"])
def test_a_standing_robot_does_not_creep(driven: np.ndarray) -> None:
    plant = Plant(NOMINAL)
    for _ in range(1000):
        plant.step(-GAIN * plant.shaft_angle_rad, driven)
    before = plant.truth(0).position_W
    for _ in range(10_000):
        plant.step(-GAIN * plant.shaft_angle_rad, driven)
    assert np.abs(plant.truth(0).position_W - before).max() < 1e-5


def test_sliding_traction_is_mu_n() -> None:
    plant = Plant(NOMINAL)
    hold(plant, 0.3)
    plant.push(np.array([0.0, 1.3 * 0.6 * WEIGHT, 0.0]), np.zeros(3))
    for _ in range(120):
        plant.step(-GAIN * plant.shaft_angle_rad, ON)
        truth = plant.truth(0)
        sliding = truth.contact & (truth.foot_velocity_W[:, 1] > 0.01)
    force = force_W(plant)[sliding]
    assert sliding.sum() >= 3
    ratio = np.hypot(force[:, 0], force[:, 1]) / force[:, 2]
    assert ratio == pytest.approx(np.full(sliding.sum(), 0.6), rel=0.01)
    plant.push(np.zeros(3), np.zeros(3))


def test_below_the_friction_limit_it_stays() -> None:
    plant = Plant(NOMINAL)
    hold(plant, 0.3)
    plant.push(np.array([0.0, 0.8 * 0.6 * WEIGHT, 0.0]), np.zeros(3))
    hold(plant, 0.7)
    before = plant.truth(0).position_W
    hold(plant, 0.5)
    assert np.abs(plant.truth(0).position_W - before).max() < 1e-4


def test_friction_stops_a_slide_at_mu_g() -> None:
    plant = Plant(NOMINAL)
    hold(plant, 0.3)
    plant.data.qvel[1] = 0.4
    speeds = []
    for _ in range(60):
        plant.step(-GAIN * plant.shaft_angle_rad, ON)
        speeds.append(plant.data.qvel[1])
    slowing = -np.polyfit(np.arange(10, 50) * 1e-3, speeds[10:50], 1)[0]
    assert slowing == pytest.approx(0.6 * NOMINAL.gravity, rel=0.15)


def test_lifted_feet_follow_the_linkage() -> None:
    plant = Plant(replace(NOMINAL, gravity=1e-9))
    plant.place(height_m=2.0, angle_rad=np.zeros(6))
    worst = 0.0
    for step in range(4000):
        goal = step * 1e-3 * 2.0
        plant.step(GAIN * (goal - plant.shaft_angle_rad), ON)
        if step > 500 and step % 20 == 0:
            x, z, _, _ = foot_path(NOMINAL, plant.shaft_angle_rad)
            expected = NOMINAL.shaft_position + np.stack([x, 0 * x, z], axis=1)
            error = plant.feet_B - expected
            worst = max(worst, float(np.abs(error[:, :2]).max()))
            assert np.abs(error[:, 2]).max() < 5e-4, "the spring gives a little under acceleration"
    assert worst < 2e-5
    assert plant.shaft_angle_rad.min() > 2 * np.pi, "a whole turn"


def test_energy_is_never_created() -> None:
    """Dropped from two centimetres with torque off: it bounces, dissipates, and gains nothing."""
    plant = Plant(NOMINAL)
    plant.place(height_m=0.15, angle_rad=np.zeros(6))
    energies = []
    for _ in range(1500):
        plant.step(np.zeros(6), OFF)
        energies.append(energy_j(plant))
    energy = np.array(energies)
    assert np.diff(energy).max() < 0.02 * np.ptp(energy), "no step gains more than a trace"
    assert energy[-1] < energy[0]
    assert energy[-1] == pytest.approx(energy[-200], abs=1e-3), "and it comes to rest"


def test_the_same_run_gives_the_same_bits() -> None:
    states = []
    for _ in range(2):
        plant = Plant(NOMINAL, seed=1)
        for step in range(400):
            plant.step(GAIN * (0.3 * np.sin(step * 0.01) - plant.shaft_angle_rad), ON)
        states.append(plant.data.qpos.tobytes() + plant.data.qvel.tobytes())
    assert states[0] == states[1]


def test_half_the_step_gives_the_same_standing_and_walking() -> None:
    ways = []
    for substeps in (2, 4):
        plant = Plant(replace(NOMINAL, substeps=substeps))
        for step in range(1500):  # all feet back: the body goes forward
            plant.step(GAIN * (0.3 * step * 1e-3 - plant.shaft_angle_rad), ON)
        ways.append(plant.truth(0).position_W)
    assert ways[0] == pytest.approx(ways[1], abs=2e-4)
    assert ways[0][0] > 0.01, "stance feet moving back move the body forward"


# The motor, against the data sheet and against arithmetic.


def test_stall_is_near_the_data_sheet() -> None:
    motor = NOMINAL.motors[0]
    stall = motor.torque_constant * 12.0 * motor.duty_limit / motor.resistance
    assert 12.0 * motor.duty_limit / motor.resistance == pytest.approx(5.2, rel=0.15), (
        "sheet: 5.2 A"
    )
    load = stall
    for _ in range(100):  # the largest load it still moves: torque = load + friction under both
        load = stall - friction_budget(motor_row(motor), 0.0, stall, -load)
    assert load == pytest.approx(8.4, rel=0.25), "sheet: 8.4 N m at 12 V, a momentary peak"


def test_a_free_shaft_reaches_the_no_load_speed() -> None:
    plant = Plant(replace(NOMINAL, gravity=1e-9))
    plant.place(height_m=2.0, angle_rad=np.zeros(6))
    for _ in range(600):
        plant.step(np.ones(6), ON)
    assert plant.shaft_rate_rad_s.mean() == pytest.approx(4.71, rel=0.1), "45 rpm at 12 V"


def test_dry_friction_holds_a_small_torque() -> None:
    plant = Plant(replace(NOMINAL, gravity=1e-9))
    plant.place(height_m=2.0, angle_rad=np.zeros(6))
    small = (
        0.05 * NOMINAL.motors[0].resistance / NOMINAL.motors[0].torque_constant / 12.0
    )  # 0.05 N m
    for _ in range(300):
        plant.step(np.full(6, small), ON)
    assert np.abs(plant.shaft_angle_rad).max() < 1e-3


def test_no_current_flows_where_the_output_stage_is_off() -> None:
    plant = Plant(NOMINAL)
    driven = np.array([True, False, False, False, False, False])
    plant.step(np.ones(6), driven)
    assert plant.current_a[0] > 4
    assert (plant.current_a[1:] == 0).all()
    assert (plant.supply_v < 12.0).all(), "the battery sags"


def test_a_stalled_motor_heats_up() -> None:
    temperature = 25.0
    for _ in range(200):
        temperature = warmed(motor_row(NOMINAL.motors[0]), temperature, 2.5, 1.0)
    assert 40 < temperature < 25 + 2.5 * 2.372 * 2.5**2


def test_mass_and_inertia_are_the_whole_robots() -> None:
    """Torso and legs together, legs at mid-stance, weigh and turn as the robot file says."""
    plant = Plant(replace(NOMINAL, gravity=1e-9))
    plant.place(height_m=2.0, angle_rad=np.zeros(6))
    centres = plant.data.xipos - plant.data.xpos[plant._torso]
    masses = plant.model.body_mass
    assert (masses[:, None] * centres).sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-4)
    total = np.zeros((3, 3))
    for mass, c, own, axes in zip(
        masses, centres, plant.model.body_inertia, plant.data.ximat, strict=True
    ):
        turn = axes.reshape(3, 3)
        total += turn @ np.diag(own) @ turn.T + mass * (c @ c * np.eye(3) - np.outer(c, c))
    assert total == pytest.approx(np.diag(NOMINAL.inertia), abs=1e-3)
