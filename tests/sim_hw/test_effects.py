"""Effects: each acts where its convention says, by the amount that it says, checked against physics."""

import numpy as np
import pytest

from model.errors import ConfigError
from sim_hw.dynamixel.goal_path import GoalPath
from sim_hw.plant.leg_path import foot_path
from sim_hw.plant.parameters import FourBarLegs
from sim_hw.plant.plant import SETTLING_S, Plant
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import LEG, STAGES, EffectKind, TwinEffect, parse_effect
from tests.sim_hw.twins import (
    GAIN,
    NOMINAL,
    ON,
    ROBOT,
    WEIGHT,
    force_W,
    hold,
    plant,
    sliding_ratio,
    twin,
)
from tests.standing import SETTLED

ML, FL = 1, 2


def test_the_contracts_effects_are_all_there_with_their_parameters() -> None:
    known = {k.name: [p.name for p in k.parameters] for k in EFFECTS if k.catalogued}
    assert len(known) == 42
    assert known["gear_backlash"] == ["width_rad"]
    assert known["link_length"] == ["crank_m", "coupler_m", "rocker_m"]
    assert known["payload"] == ["mass_kg", "x_m", "y_m"]
    assert known["stiction"] == ["static_ratio", "speed_m_s"]
    assert {k.stage for k in EFFECTS} == set(STAGES)
    outside = {k.name for k in EFFECTS if not k.catalogued}
    assert outside == {
        "missed_steps", "loose_leg_stop", "gusts", "fading_friction", "sticking_foot", "marker_swap",
    }  # fmt: skip


@pytest.mark.parametrize(
    "settling_s", [0.5, pytest.param(SETTLING_S, marks=pytest.mark.soak)], ids=["short", "whole"]
)
@pytest.mark.parametrize("kind", [k for k in EFFECTS if k.apply], ids=lambda k: k.name)
def test_every_effect_makes_another_twin_that_still_stands(
    kind: EffectKind, settling_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sim_hw.plant.plant.SETTLING_S", settling_s)
    monkeypatch.setattr(Plant, "_stand", SETTLED)  # what comes of it is not kept for other tests
    leg = "@ML" if kind.scope == LEG else ""
    wrong = twin(f"{kind.name}{leg}")
    assert repr(wrong) != repr(twin()), "something is changed"
    robot = Plant(wrong.plant)
    hold(robot, 0.02)
    assert np.isfinite(robot.data.qpos).all()
    assert robot.foot_force_B[:, 2].sum() == pytest.approx(WEIGHT, rel=0.25)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("foot_frction@ML", "did you mean foot_friction"),
        ("foot_friction@ML:mu=1", "has no parameter 'mu'; it has ratio"),
        ("foot_friction@ML:ratio=9", "from 0.1 to 4"),
        ("foot_friction@ML:ratio=much", "must be a number"),
    ],
)
def test_effects_that_make_no_sense_are_refused(text: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        parse_effect(text, EFFECTS)


def test_legs_are_checked_against_the_robot() -> None:
    for text, words in (("foot_friction", "one leg"), ("foot_friction@XX", "no leg"),
                        ("drag@ML", "whole robot")):  # fmt: skip
        with pytest.raises(ConfigError, match=words):
            twin(text)
    assert parse_effect("hip_mount_offset@ML:y_m=0.01", EFFECTS) == TwinEffect(
        "hip_mount_offset", "ML", (0.0, 0.01)
    ), "what is not given is neutral where something is"


# Actuation: goals and gears.


def steps_of_goal(text: str, seconds: float) -> np.ndarray:
    """What the control loops follow after all goals step from 0 to 1000 ticks."""
    path = GoalPath(twin(text).plant.drive, np.zeros(6), 1e-3, seed=1)
    return np.array([path.advance(np.full(6, 1000.0)) for _ in range(round(seconds * 1e3))])


def test_a_late_command_acts_late() -> None:
    followed = steps_of_goal("command_delay:delay_s=0.05", 0.1)
    assert (followed[:49] == 0).all()
    assert (followed[50:] == 1000).all()


def test_a_lagging_set_point_is_two_thirds_there_after_its_time_constant() -> None:
    followed = steps_of_goal("servo_lag@ML:time_constant_s=0.05", 0.1)
    assert followed[49, ML] == pytest.approx(632.1, abs=1)
    assert followed[0, FL] == 1000, "the other legs do not lag"


def test_a_limited_set_point_moves_at_its_limit() -> None:
    followed = steps_of_goal("servo_speed_limit@ML:limit_rad_s=0.5", 0.1)
    assert np.diff(followed[:, ML]).mean() * 1e3 * 2 * np.pi / 4096 == pytest.approx(0.5, rel=1e-3)


def test_missed_goals_are_missed_for_their_time() -> None:
    path = GoalPath(twin("missed_steps@ML:per_s=1,hold_s=0.2").plant.drive, np.zeros(6), 1e-3, 1)
    followed = np.array([path.advance(np.full(6, float(i))) for i in range(20000)])
    still = np.diff(followed[:, ML]) == 0
    assert 0.1 < still.mean() < 0.3, "about one in five"
    assert not (np.diff(followed[:, FL]) == 0).any()


def loaded(text: str, force_n: float) -> tuple[Plant, float]:
    """A robot pushed along x while it stands, and the torque of the ground on leg ML's shaft."""
    robot = plant(text) if text else plant()
    robot.push(np.array([force_n, 0.0, 0.0]), np.zeros(3))
    hold(robot, 1.5)
    _, _, x_slope, z_slope = foot_path(robot.parameters, robot.shaft_angle_rad)
    force = robot.foot_force_B[ML]
    return robot, float(x_slope[ML] * force[0] + z_slope[ML] * force[2])


def test_a_compliant_gear_twists_by_its_torque() -> None:
    robot, torque = loaded("servo_compliance:rad_per_nm=0.05", 20.0)
    twist = (robot.shaft_angle_rad - robot.motor_angle_rad)[ML]
    assert abs(torque) > 0.1
    # the teeth themselves give a little as well
    assert twist == pytest.approx((0.05 + 1 / 1500) * torque, rel=0.02)


def test_backlash_is_taken_up_either_way() -> None:
    width = 0.08
    ends = []
    for force in (25.0, -25.0):
        robot, torque = loaded(f"gear_backlash@ML:width_rad={width}", force)
        ends.append((robot.shaft_angle_rad - robot.motor_angle_rad)[ML] - torque / 1500)
    assert abs(ends[0] - ends[1]) == pytest.approx(width, rel=0.02)


def test_a_tight_shaft_is_behind_by_what_its_loop_needs_to_turn_it() -> None:
    goals = np.linspace(0.0, 0.4, 2000)  # 0.2 rad/s
    errors = []
    for text in ("joint_friction@ML:behind_rad=0", "joint_friction@ML:behind_rad=0.05"):
        robot = plant(text)
        for goal in goals:
            hold(robot, robot.dt_s, goal)
        errors.append(0.4 - robot.shaft_angle_rad)
    more = errors[1] - errors[0]
    assert more[ML] == pytest.approx(0.05, rel=0.05), "the gear's friction falls with its speed"
    assert np.abs(np.delete(more, ML)).max() < 2e-3


def test_what_is_caught_in_a_leg_adds_to_the_friction_of_its_shaft() -> None:
    robot = plant("joint_friction@ML:behind_rad=0.05")
    own = robot.jam_n_m.copy()
    assert own[ML] == pytest.approx(0.05 * GAIN * 2.231 * 12.0 / 2.372 / 1.2316, rel=1e-3)
    assert not np.delete(own, ML).any()
    robot.jam(ML, 30.0)
    assert robot.jam_n_m[ML] == own[ML] + 30.0
    robot.jam(ML, 0.0)
    assert np.array_equal(robot.jam_n_m, own)


def test_the_encoder_does_not_see_a_turned_crank() -> None:
    robot = plant("shaft_zero_offset@ML:offset_rad=0.1")
    hold(robot, 0.5)
    angles = robot.shaft_angle_rad + np.eye(6)[ML] * 0.1
    x, _, _, _ = foot_path(NOMINAL, angles)
    assert abs(robot.shaft_angle_rad[ML]) < 0.03, "the encoder is where it should be"
    assert robot.feet_B[ML, 0] - ROBOT.legs.shaft_position[ML, 0] == pytest.approx(x[ML], abs=5e-4)


# Kinematics and support.


def test_feet_follow_the_longer_crank() -> None:
    robot = plant("link_length@ML:crank_m=0.004")
    hold(robot, 0.3)
    changed = twin("link_length@ML:crank_m=0.004").plant
    assert isinstance(changed.leg, FourBarLegs)
    assert isinstance(NOMINAL.leg, FourBarLegs)
    assert changed.leg.crank[ML] == pytest.approx(0.034)
    assert changed.leg.crank[FL] == NOMINAL.leg.crank[FL]
    z_long, z = (foot_path(p, np.zeros(6))[1][ML] for p in (changed, NOMINAL))
    lower = robot.feet_B[ML, 2] + robot.foot_force_B[ML, 2] * -1 / NOMINAL.stiffness[ML]
    assert lower == pytest.approx(z_long, abs=3e-4)
    assert abs(z_long - z) > 1e-3


def test_flexible_legs_give_sideways() -> None:
    stiff, soft = plant(), plant("leg_flex:lateral_m_per_n=0.0005")
    moved = []
    for robot in (stiff, soft):
        hold(robot, 0.2)
        before = robot.feet_B[:, 1].mean()
        robot.push(np.array([0.0, 12.0, 0.0]), np.zeros(3))
        hold(robot, 2.0)
        moved.append(robot.feet_B[:, 1].mean() - before)
    assert moved[1] - moved[0] == pytest.approx(-12.0 / 6 * 0.0005, rel=0.03)


def test_soft_ground_sinks_and_soft_legs_compress() -> None:
    """Both lower the body as K ratio says; only in the ground do the feet go below its level."""
    sag = WEIGHT / NOMINAL.stiffness.sum()
    low = {}
    for text in ("ground_stiffness:ratio=0.5", "foot_friction@ML:ratio=1"):
        robot = plant(text)
        hold(robot, 2.0)
        low[text] = robot.truth(0).position_W[2], robot.truth(0).foot_position_W[:, 2].mean()
    (height, foot), (plain, level) = low.values()
    assert plain - height == pytest.approx(sag, rel=0.05), "half the stiffness, twice the sag"
    assert level - foot == pytest.approx(sag, rel=0.05), "but for the weight of what gives"


def test_a_longer_leg_carries_more() -> None:
    robot = plant("leg_length@ML:offset_m=0.002")
    hold(robot, 0.5)
    load = robot.foot_force_B[:, 2]
    assert load[ML] > 1.2 * WEIGHT / 6
    assert load.sum() == pytest.approx(WEIGHT, rel=2e-3)


def test_the_body_lies_along_a_slope_and_slides_beyond_mu() -> None:
    robot = plant("ground_slope:slope_x=0.1,slope_y=0.05")
    hold(robot, 0.5)
    up = robot.torso_rotation.T @ [0.0, 0.0, 1.0]
    assert np.degrees(np.arcsin(up[0])) == pytest.approx(np.degrees(np.arctan(0.1)), abs=0.3)
    before = robot.data.qpos[:3].copy()
    hold(robot, 0.5)
    assert np.abs(robot.data.qpos[:3] - before).max() < 1e-4, "it stands"
    slippery = plant("ground_slope:slope_x=0.2", "friction_level:ratio=0.25")  # mu 0.15
    hold(slippery, 0.5)
    assert slippery.data.qvel[0] < -0.05, "downhill is back"


@pytest.mark.parametrize(
    ("text", "extra", "moment"),
    [
        ("com_offset:x_m=0.03,y_m=-0.01", 0.0, (0.03 * WEIGHT, -0.01 * WEIGHT)),
        ("payload:mass_kg=1,x_m=0.15,y_m=0.05", 9.80665, (0.15 * 9.80665, 0.05 * 9.80665)),
    ],
)
def test_loads_balance_weight_where_it_is(
    text: str, extra: float, moment: tuple[float, float]
) -> None:
    robot = plant(text)
    hold(robot, 1.0)
    load, feet = force_W(robot)[:, 2], robot.truth(0)
    assert load.sum() == pytest.approx(WEIGHT + extra, rel=2e-3)
    arm = feet.foot_position_W[:, :2] - feet.position_W[:2]
    lean = robot.torso_rotation[:2, 2] * 0.0
    assert load @ (arm - lean) == pytest.approx(moment, abs=0.02)


def test_a_twisting_chassis_turns_front_against_rear() -> None:
    robot = plant("chassis_twist:rad_per_nm=0.004")
    hold(robot, 0.3)
    robot.data.qfrc_applied[:] = 0
    names = [robot.model.joint(i).name for i in range(robot.model.njnt)]
    hinges = [robot.model.joint(n).qposadr[0] for n in names if n.startswith("twist")]
    assert len(hinges) == 2
    stiffness = [robot.model.joint(n).stiffness[0] for n in names if n.startswith("twist")]
    assert sum(1 / k for k in stiffness) == pytest.approx(0.004), "front against rear"


# Friction.


def test_one_foots_friction() -> None:
    ratio = sliding_ratio(plant("foot_friction@ML:ratio=0.5"), (1.0, 0.0))
    assert ratio[ML] == pytest.approx(0.3, rel=0.02)
    others = np.delete(ratio, ML)
    assert np.nanmax(np.abs(others - 0.6)) < 0.012


@pytest.mark.parametrize(
    ("direction", "expected"),
    [
        ((1.0, 0.0), 0.6 * 1.25),
        pytest.param((0.0, 1.0), 0.6, marks=pytest.mark.soak),
    ],
)
def test_friction_has_a_direction(direction: tuple[float, float], expected: float) -> None:
    ratio = sliding_ratio(plant("friction_anisotropy:w_x=0.5"), direction)
    assert np.nanmax(np.abs(ratio - expected)) < 0.03 * expected


def test_stiction_holds_more_than_sliding_friction() -> None:
    robot = plant("stiction:static_ratio=1.5,speed_m_s=0.01")
    for share in np.linspace(0, 1, 20):  # slowly: the legs' springs would carry it over otherwise
        robot.push(np.array([0.0, share * 1.25 * 0.6 * WEIGHT, 0.0]), np.zeros(3))
        hold(robot, 0.03)
    hold(robot, 0.2)
    assert abs(robot.data.qvel[1]) < 1e-3, "a quarter above sliding friction, it stays"
    robot.push(np.array([0.0, 1.8 * 0.6 * WEIGHT, 0.0]), np.zeros(3))
    hold(robot, 0.15)
    robot.push(np.array([0.0, 1.25 * 0.6 * WEIGHT, 0.0]), np.zeros(3))
    fast = robot.data.qvel[1]
    hold(robot, 0.1)
    assert robot.data.qvel[1] > fast > 0.1, "once sliding, it goes on"


def test_a_round_foot_rolls() -> None:
    """The contact of a rolling foot moves over it: the body goes by the centre's way plus R times turn."""
    radius, ways = 0.025, []
    for text in (f"foot_rolling:radius_m={radius}", ""):
        robot = plant(text) if text else plant()
        start = robot.truth(0).position_W[0]
        for step in range(1500):
            robot.step(GAIN * (0.4 * step / 1500 - robot.motor_angle_rad), ON)
        ways.append((robot.truth(0).position_W[0] - start, robot.shaft_angle_rad.mean()))
    from sim_hw.plant.four_bar import four_bar_point
    from sim_hw.plant.leg_path import leg_geometry

    geometry = leg_geometry(NOMINAL)[0]
    turned = four_bar_point(geometry, ways[0][1])[4] - four_bar_point(geometry, 0.0)[4]
    assert ways[0][0] - ways[1][0] != pytest.approx(0.0, abs=1e-4)
    assert abs(ways[0][0] - ways[1][0]) == pytest.approx(radius * abs(turned), rel=0.35)


def test_a_fading_side_and_a_patch_change_friction_where_and_when_they_say() -> None:
    robot = plant("fading_friction:time_s=1,floor=0.5")
    hold(robot, 1.0)
    left = robot.model.geom_friction[robot._geoms, 0] / 0.6
    assert left[:3] == pytest.approx(np.full(3, 0.5 + 0.5 * np.exp(-1)), rel=0.01)
    assert left[3:] == pytest.approx(np.ones(3))
    patch = plant("friction_patch:ratio=0.4,x_m=0.15")
    hold(patch, 0.01)
    ahead = patch.truth(0).foot_position_W[:, 0] > 0.15
    assert 0 < ahead.sum() < 6
    assert patch.model.geom_friction[patch._geoms, 0] == pytest.approx(np.where(ahead, 0.24, 0.6))


# External forces and dynamics.


def test_the_ground_holds_against_a_tether() -> None:
    robot = plant("tether_force:x_n=4,y_n=-2")
    hold(robot, 1.0)
    assert force_W(robot)[:, :2].sum(axis=0) == pytest.approx([-4.0, 2.0], abs=0.02)


def test_drag_slows_a_slide() -> None:
    speeds = []
    for texts in ((), ("drag:n_s_per_m=400",)):
        robot = plant(*texts)
        hold(robot, 0.1)
        robot.data.qvel[1] = 0.3
        hold(robot, 0.02)
        speeds.append(robot.data.qvel[1])
    assert speeds[1] < speeds[0]


def test_sliding_feet_brake_the_towed_mass_in_its_time_constant() -> None:
    robot = plant("inertia_lag:time_constant_s=0.1")
    assert force_W(robot)[:, 2].sum() == pytest.approx(WEIGHT, rel=0.01), "it has no weight"
    ballast = robot._ballast
    assert ballast is not None
    hold(robot, 0.05)
    for axis in range(
        2
    ):  # along x, then along y: once feet slide, 20 mm/s slower in its time constant
        ballast.rate = np.zeros(3)
        ballast.rate[axis] = robot.data.qvel[axis] = 0.07
        hold(robot, 0.08)
        before = ballast.rate[axis]
        hold(robot, 0.1)
        assert before - ballast.rate[axis] == pytest.approx(0.02, rel=0.05)


def test_a_sticking_foot_is_held_down() -> None:
    robot, usual = plant("sticking_foot@ML:force_n=6"), plant()
    hold(robot, 0.5)
    hold(usual, 0.5)
    assert force_W(robot)[:, 2].sum() == pytest.approx(WEIGHT, rel=3e-3), "it pulls, too"
    pressed_n = robot.data.qfrc_constraint[robot._foot_v[ML]]
    assert pressed_n[2] == pytest.approx(usual.foot_force_B[ML, 2] + 6, abs=0.5)


def test_a_sticking_foot_pulls_at_its_sensor_until_it_comes_off() -> None:
    """Turned by half a cycle the middle left foot lifts; before, its leg pulls at the ground."""
    robot = plant("sticking_foot@ML:force_n=6")
    lowest = 0.0
    for angle in np.linspace(0.0, np.pi, 600):
        goal = np.zeros(robot.parameters.legs)
        goal[ML] = angle
        hold(robot, 0.005, goal)
        lowest = min(lowest, robot.foot_force_B[ML, 2])
    assert -6.5 < lowest < -4.0
    assert robot.foot_force_B[ML, 2] == 0.0, "it is off the ground"


def test_a_leg_with_play_carries_less() -> None:
    robot = plant("loose_leg_stop@ML:play_m=0.004")
    hold(robot, 0.5)
    assert robot.foot_force_B[ML, 2] < 0.8 * WEIGHT / 6
