"""Realities: what each part does to plant, servos, sensors and days, against physics and statistics."""

import math
from dataclasses import replace

import numpy as np
import pytest

from model.effects.catalogue import EFFECTS
from model.errors import ConfigError
from robot.config.robot_file import load_robot
from robot.virtual.reality_robot import robot_in
from robot.virtual.twin_run import make_twin, plan_of, walk_fast, walk_through_bytes
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.host.world import World
from sim_hw.plant.leg_path import foot_path
from sim_hw.plant.mujoco_model import build_model
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.plant import Plant
from sim_hw.plant.shaft_friction import duty_a_rad
from sim_hw.plant.structure import GearSide, LoopKind, ServoLoop
from sim_hw.realities.catalogue import REALITIES, USUAL, find_reality, why_not_in
from sim_hw.realities.own_effects import EVERY_ROBOT, own_effects
from sim_hw.realities.reality import Gears, LegForm, Reality, Sensing, UnequalLegs, real_twin
from sim_hw.twin.days import DayScatter
from sim_hw.twin.sensing import ForceChannel, SensorParameters
from tests.sim_hw.twins import NOMINAL, ON, ROBOT, WEIGHT, force_W

CONFIG = load_robot()
TICKS_A_TURN = 4096
DUTY_COUNTS = 885


def made(reality: Reality, seed: int = 0) -> PlantParameters:
    return real_twin(reality, ROBOT, seed).plant


def made_of(reality: Reality) -> PlantParameters:
    """Of its own robot."""
    return real_twin(reality, robot_in(reality, CONFIG).parameters, 3).plant


def test_the_usual_one_differs_from_the_file_by_its_day_alone() -> None:
    random = np.random.default_rng([7, 0x70])
    plant = made(USUAL, 7)
    assert plant.mu == pytest.approx(NOMINAL.mu * np.exp(0.04 * random.standard_normal(6)))
    assert plant.stiffness == pytest.approx(
        NOMINAL.stiffness * np.exp(0.03 * random.standard_normal(6))
    )
    assert plant.com == pytest.approx(0.0015 * random.standard_normal(2))
    same = replace(plant, mu=NOMINAL.mu, stiffness=NOMINAL.stiffness, com=NOMINAL.com)
    for name in PlantParameters.__slots__:
        assert str(getattr(same, name)) == str(getattr(NOMINAL, name)), name


@pytest.mark.parametrize("reality", REALITIES, ids=lambda one: one.name)
def test_every_reality_is_a_robot_with_its_files_weight(reality: Reality) -> None:
    config, plant = robot_in(reality, CONFIG), made_of(reality)
    model = build_model(plant)
    pads = (
        np.isfinite(plant.ground.stiffness).sum() * 0.02
    )  # which move with the feet, ground or mat
    assert model.body_mass.sum() == pytest.approx(config.parameters.body.mass, abs=pads + 1e-9)
    assert "\n" not in reality.differs


def test_there_are_enough_realities_and_none_is_another() -> None:
    assert len(REALITIES) >= 12
    plain = {replace(one, name="", differs="") for one in REALITIES}
    assert len(plain) == len(REALITIES)
    assert find_reality("drawn-5") == find_reality("drawn-5")
    drawn = {replace(find_reality(f"drawn-{n}"), name="", differs="") for n in range(30)}
    assert len(drawn) == 30
    with pytest.raises(ConfigError, match=r"did you mean workshop\?.*usual, soft_servo"):
        find_reality("worksop")


# Servo loops.


def goal_of(bank: FirmwareBank, rad: float) -> None:
    bank.servos["torque"] = True
    bank.goal_position[:] = rad / (2 * math.pi) * TICKS_A_TURN


def test_a_profile_inside_the_servo_is_a_trapezoid() -> None:
    speed, ramp, to_go = 2.0, 10.0, 1.0
    bank = FirmwareBank(1, ServoLoop(profile_speed=speed, profile_acceleration=ramp))
    goal_of(bank, to_go)
    still, track = np.zeros(1), []
    for _ in range(1000):
        bank.duty(still, still, still, 1e-3)
        track.append(bank.servos["trajectory"][0] * 2 * math.pi / TICKS_A_TURN)
    whole_s = to_go / speed + speed / ramp
    assert track[round(whole_s * 1000 / 2)] == pytest.approx(to_go / 2, abs=0.01)
    assert track[99] == pytest.approx(ramp * 0.1**2 / 2, rel=0.03)
    assert np.max(np.diff(track)) == pytest.approx(speed * 1e-3, rel=1e-6)
    assert track[round(whole_s * 1000) + 30] == pytest.approx(to_go, abs=2e-3)


def test_a_cascaded_loop_asks_for_a_speed_and_removes_what_is_missing() -> None:
    bank = FirmwareBank(
        1, ServoLoop(LoopKind.CASCADED, angle_gain=20.0, speed_gain=0.5, speed_integral=4.0)
    )
    goal_of(bank, 0.1)
    rate = np.array([1.5])
    missing = 20.0 * bank.goal_position[0] / TICKS_A_TURN * 2 * math.pi - 1.5
    duties = [bank.duty(np.zeros(1), rate, np.zeros(1), 1e-3)[0] for _ in range(101)]
    assert duties[0] == pytest.approx(0.5 * missing + 4.0 * missing * 1e-3)
    assert duties[100] - duties[0] == pytest.approx(4.0 * missing * 0.1, rel=1e-6)


def test_gain_and_speed_feedback_of_the_position_loop() -> None:
    plain, soft = FirmwareBank(1), FirmwareBank(1, ServoLoop(gain=0.5, speed_damping=0.1))
    for bank in (plain, soft):
        goal_of(bank, 0.01)
    still, rate = np.zeros(1), np.array([0.3])
    whole = plain.duty(still, rate, still, 1e-3)[0]
    assert soft.duty(still, rate, still, 1e-3)[0] == pytest.approx(0.5 * whole - 0.03)


@pytest.mark.parametrize("feedback", GearSide)
@pytest.mark.parametrize("encoder", GearSide)
def test_a_loop_and_an_encoder_are_on_their_side_of_the_gear(
    feedback: GearSide, encoder: GearSide
) -> None:
    loop = ServoLoop(feedback=feedback, encoder=encoder)
    drive = replace(NOMINAL.drive, loop=loop, backlash=np.full(6, 0.05))
    world = World(
        Plant(replace(NOMINAL, drive=drive)), FirmwareBank(6, loop), CONFIG.servo_bus,
        CONFIG.force_sensor,
    )  # fmt: skip
    plant = world.plant
    plant.motor_angle_rad[:], plant.shaft_angle_rad[:] = 0.02, 0.01
    side = {GearSide.MOTOR: 0.02, GearSide.SHAFT: 0.01}
    ticks = (world.motors().ticks - CONFIG.servo_bus.zeros) * CONFIG.servo_bus.signs
    assert ticks / TICKS_A_TURN * 2 * math.pi == pytest.approx(np.full(6, side[encoder]))
    assert world._loop_angle == pytest.approx(np.full(6, side[feedback]))


def test_play_inside_the_loop_is_taken_up_and_outside_it_is_not() -> None:
    """A shaft pushed against its flank: the loop on the shaft's side brings the shaft back."""
    held = {}
    for side in GearSide:
        loop = ServoLoop(feedback=side)
        reality = Reality(
            "t", "", loop=loop, gears=Gears(backlash_rad=0.04), days=DayScatter(0, 0, 0)
        )
        plant = Plant(made(reality))
        angle = plant.motor_angle_rad if side is GearSide.MOTOR else plant.shaft_angle_rad
        for _ in range(800):
            plant.step(4.89 * (0.3 - angle), ON)
        held[side] = np.abs(0.3 - plant.shaft_angle_rad)
    assert held[GearSide.MOTOR].max() > 0.015
    assert held[GearSide.SHAFT].mean() < held[GearSide.MOTOR].mean()


# Legs, surface, sensors.


def test_hardening_springs_carry_the_weight_with_less_travel() -> None:
    heights = []
    for hardening in (0.0, 40000.0):
        reality = Reality(
            "t", "", leg=LegForm(hardening_per_m2=hardening), days=DayScatter(0, 0, 0)
        )
        plant = Plant(made(reality))
        assert force_W(plant)[:, 2].sum() == pytest.approx(WEIGHT, rel=0.01)
        _, z, _, _ = foot_path(plant.parameters, plant.shaft_angle_rad)
        travel = plant.feet_B[:, 2] - z
        spring = plant.parameters.stiffness * travel * (1 + hardening * travel**2)
        assert spring == pytest.approx(plant.foot_force_B[:, 2], rel=0.05, abs=0.3)
        heights.append(plant.truth(0).position_W[2])
    assert heights[1] > heights[0]


def test_a_marker_on_the_shank_shows_the_linkage_and_a_share_of_the_give() -> None:
    plant = Plant(replace(NOMINAL, leg_offset=np.array([0, 0.002, 0, 0, 0, 0])))
    position, _, feet = plant.marker_places(1.0)
    x, z, _, _ = foot_path(plant.parameters, plant.shaft_angle_rad)
    linkage = plant.parameters.shaft_position + np.stack([x, np.zeros(6), z], axis=1)
    rigid = position + linkage @ plant.torso_rotation.T
    assert plant.marker_places(0.0)[2] == pytest.approx(rigid)
    assert plant.marker_places(0.25)[2] == pytest.approx(0.25 * feet + 0.75 * rigid)
    assert np.abs(feet - rigid).max() > 0.002, "legs give"


def test_coloured_noise_of_forces_wanders_as_it_says() -> None:
    sensors = replace(SensorParameters.healthy(6), force_wander_n=0.5, force_wander_s=0.2)
    channel = ForceChannel(sensors, seed=1)
    still = np.zeros((6, 6))
    seen = np.array([channel.report(still, tick * 10_000_000) for tick in range(4000)])
    noise = seen[500:, :, :3].reshape(3500, -1)
    assert noise.std() == pytest.approx(0.5, rel=0.1)
    later = (noise[20:] * noise[:-20]).mean() / (noise**2).mean()
    assert later == pytest.approx(math.exp(-0.2 / 0.2), abs=0.08)
    assert not seen[..., 3:].any(), "moments have none"
    again = ForceChannel(sensors, seed=1)
    assert np.array_equal([again.report(still, k * 10_000_000) for k in range(5)], seen[:5])


def test_the_units_own_filter_stands_before_that_of_an_effect() -> None:
    sensors = replace(SensorParameters.healthy(6), force_filter_s=0.1, force_lag_s=0.1)
    channel = ForceChannel(sensors)
    channel.report(np.zeros((6, 6)), 0)
    for tick in range(1, 2001):
        reading = channel.report(np.ones((6, 6)), tick * 100_000)
    assert reading[0, 0] == pytest.approx(1 - 3 * math.exp(-2), abs=1e-3), "two first-order lags"


# Days and legs.


def test_days_differ_as_much_at_each_leg_as_they_say() -> None:
    days = DayScatter(mu=0.02, stiffness=0.01, zero_rad=0.003, legs=(1, 3, 1, 1, 1, 1))
    plants = [made(Reality("t", "", days=days), seed) for seed in range(300)]
    mu = np.log(np.array([one.mu for one in plants]) / NOMINAL.mu).std(axis=0)
    assert mu[1] == pytest.approx(0.06, rel=0.15)
    assert np.delete(mu, 1) == pytest.approx(np.full(5, 0.02), rel=0.2)
    zero = np.array([one.drive.crank_offset for one in plants]).std(axis=0)
    assert zero[0] == pytest.approx(0.003, rel=0.15)
    floor = [
        made(Reality("t", "", days=DayScatter(mu=0.0, floor_mu=0.1)), s).mu for s in range(300)
    ]
    assert np.log(np.array(floor)).std(axis=0) == pytest.approx(np.full(6, 0.1), rel=0.15)
    assert np.ptp(floor[0]) == pytest.approx(0.0)


def test_unequal_legs_are_the_same_ones_every_day() -> None:
    unequal = UnequalLegs(stiffness=0.1, mu=0.1, length_m=0.001, link_m=0.0002, mount_m=0.002)
    still = DayScatter(0, 0, 0)
    one, other = (made(Reality("t", "", unequal=unequal, days=still), seed) for seed in (1, 2))
    renamed = made(Reality("u", "", unequal=unequal, days=still), 1)
    for name in ("stiffness", "mu", "leg_offset", "shaft_position"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
        assert np.ptp(getattr(one, name) - getattr(NOMINAL, name)) > 0, name
        assert not np.array_equal(getattr(one, name), getattr(renamed, name)), name


# As a trial.


def test_a_reality_without_sensors_gives_a_trial_without_their_columns() -> None:
    reality = find_reality("pose_only")
    twin = make_twin(CONFIG, (), 1, reality)
    trial = walk_fast(CONFIG, twin, plan_of(CONFIG, "tripod", 0.1, 0.1, 0.0))
    assert np.isnan(trial.force_n).all()
    assert np.isnan(trial.foot_m).all()
    assert np.isfinite(trial.body_position_m).all()
    assert np.isfinite(trial.shaft_rad).all()
    noise = trial.header.noise
    assert math.isnan(noise.force_n)
    assert math.isnan(noise.foot_position_m)
    assert noise.body_position_m == 0.0005


def test_another_robot_has_a_file_of_its_own() -> None:
    small = robot_in(find_reality("small"), CONFIG)
    assert small.parameters.body.mass == 2.8
    assert small.loop.rate_hz == 50
    before, after = CONFIG.parameters.legs.shaft_position, small.parameters.legs.shaft_position
    assert after == pytest.approx(0.7 * before)
    assert "body.mass" not in small.text
    assert small.name == "BigANT (small)"
    five = replace(find_reality("large"), robot=(("legs.shaft_position", ((0.0, 0.0, 0.0),)),))
    with pytest.raises(ConfigError, match="has 6 entries; the reality large is of robots with 1"):
        robot_in(five, CONFIG)
    with pytest.raises(ConfigError, match=r"leg.length: is not in the robot file"):
        robot_in(replace(five, robot=(("leg.length", 0.1),)), CONFIG)


def test_what_healthy_robots_have_is_in_the_plant_they_are_made_of() -> None:
    assert own_effects(USUAL) == EVERY_ROBOT | {"servo_compliance"}
    assert np.isfinite(NOMINAL.side_stiffness).all()
    assert np.isinf(made(USUAL).ground.stiffness).all()
    for reality in REALITIES:
        own, plant = own_effects(reality), made(reality)
        assert own <= set(EFFECTS), reality.name
        assert ("gear_backlash" in own) == bool(plant.drive.backlash.any()), reality.name
        soft = plant.drive.loop.kind is LoopKind.POSITION or plant.drive.compliance.any()
        assert ("servo_compliance" in own) == soft, reality.name
        assert ("ground_stiffness" in own) == np.isfinite(plant.ground.stiffness).all()
        assert ("chassis_twist" in own) == (plant.twist > 0.0), reality.name
        assert ("marker_on_shank" in own) == (reality.sensing.marker_share < 1.0), reality.name
        assert ("foot_rolling" in own) == (plant.rolling_radius > 0.0), reality.name
    assert own_effects(find_reality("workshop")) >= {"hip_mount_offset", "leg_stiffness"}


def test_a_loop_without_an_integral_holds_a_load_by_an_error_that_shows() -> None:
    motor = made(USUAL).motors[0]
    stall_nm = motor.torque_constant * motor.battery_v / motor.resistance
    rad_per_nm = 1.0 / (duty_a_rad(USUAL.loop) * stall_nm)
    assert rad_per_nm == pytest.approx(0.0181, abs=1e-4)
    assert rad_per_nm > 0.5 * EFFECTS["servo_compliance"].parameters[0].spread


def test_effects_that_a_reality_cannot_have_are_known() -> None:
    bare = Reality("t", "", sensing=Sensing(noise=find_reality("pose_only").sensing.noise))
    assert "no force sensors" in why_not_in(bare, "force_gain")
    assert "no foot markers" in why_not_in(bare, "marker_swap")
    assert "no foot markers" in why_not_in(bare, "marker_on_shank")
    assert not why_not_in(bare, "payload")
    assert not why_not_in(USUAL, "force_gain")


@pytest.mark.thorough
def test_all_that_a_reality_changes_comes_through_the_bytes_as_well() -> None:
    """Loop, gears, marker on the shank, filtered and coloured forces: counts are equal, not just near."""
    reality = find_reality("workshop")
    plan = plan_of(CONFIG, "tripod", 0.2, 0.3, 0.2)
    fast = walk_fast(CONFIG, make_twin(CONFIG, (), 5, reality), plan)
    whole = walk_through_bytes(CONFIG, make_twin(CONFIG, (), 5, reality), plan)
    for field in ("time_s", "shaft_rad", "force_n", "foot_m", "body_position_m"):
        assert getattr(fast, field) == pytest.approx(getattr(whole, field), abs=2e-6), field
    assert np.isfinite(fast.force_n).all()


@pytest.mark.parametrize("number", [105, 301])
def test_a_small_robot_that_is_drawn_with_heavy_legs_can_be_built(number: int) -> None:
    """Six feet of the usual size have more inertia than all of it."""
    drawn = find_reality(f"drawn-{number}")
    assert 0.0 < drawn.leg.foot_mass_kg < find_reality("soft_servo").leg.foot_mass_kg
    build_model(made_of(drawn))
