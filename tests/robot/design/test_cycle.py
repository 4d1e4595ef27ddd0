"""A gait walked through the model: loads, torques and shifts against independent solutions."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from gaits.catalog import make_gait
from model.kinematics.legs import leg_kinematics
from model.support.static_margin import static_margin
from model.values.gravity import STANDARD_GRAVITY
from robot.config.robot_file import load_robot
from robot.design.cycle import joint_torque, most_torque, swing_share, walk_cycle
from robot.design.gait_figures import walk_gait
from robot.design.shift import best_shift
from tests.robot.design.robot_files import robot_with

ROBOT = load_robot().parameters
WEIGHT_N = ROBOT.body.mass * STANDARD_GRAVITY
RANDOM = np.random.default_rng(5)


def test_loads_of_a_tripod_are_those_of_its_balance() -> None:
    """Three feet carry what three equations say, whatever their springs."""
    cycle = walk_cycle(ROBOT, make_gait("tripod", ROBOT))
    three = np.flatnonzero(
        (cycle.answer.contact == cycle.stance).all(1) & (cycle.stance.sum(1) == 3)
    )
    assert len(three) > 40
    for frame in three:
        down = np.flatnonzero(cycle.stance[frame])
        x, y, _ = cycle.feet.position_m[frame, down].T
        loads = np.linalg.solve(np.array([np.ones(3), x, y]), [WEIGHT_N, 0, 0])
        np.testing.assert_allclose(cycle.answer.load_n[frame, down], loads, rtol=1e-9)
        height = -loads / ROBOT.contact.stiffness[down]
        np.testing.assert_allclose(cycle.height_m[frame, down], height, atol=1e-12)


def test_margin_is_that_of_scipys_hull() -> None:
    cycle = walk_cycle(ROBOT, make_gait("metachronal", ROBOT))
    for frame in range(0, len(cycle.phase), 7):
        hull = ConvexHull(cycle.feet.position_m[frame, cycle.stance[frame], :2])
        margin = -hull.equations[:, 2].max()
        assert cycle.margin.margin_m[frame] == pytest.approx(margin, abs=1e-12)


@pytest.mark.parametrize("gait", ["tripod", "metachronal"])
def test_torque_is_that_of_virtual_work(gait: str) -> None:
    """A force that does work on a foot as the shaft turns is held by that work a radian."""
    cycle = walk_cycle(ROBOT, make_gait(gait, ROBOT))
    legs, step = leg_kinematics(ROBOT), 1e-6
    angle, still = cycle.shafts.angle_rad, np.zeros_like(cycle.shafts.angle_rad)

    def work(by_rad: float) -> np.ndarray:
        feet = legs.feet(angle + by_rad, still).position_m
        done: np.ndarray = (feet * cycle.force_n).sum(axis=-1)
        return done

    expected = -(work(step) - work(-step)) / (2 * step)
    np.testing.assert_allclose(cycle.torque_nm, expected, atol=1e-7)


def test_no_friction_asks_more_than_the_bound() -> None:
    cycle = walk_cycle(ROBOT, make_gait("tripod", ROBOT))
    most = most_torque(cycle, ROBOT.contact.mu)
    for _ in range(20):
        angle, size = RANDOM.uniform(0, 2 * np.pi, most.shape), RANDOM.random(most.shape)
        limit = ROBOT.contact.mu * cycle.answer.load_n * size
        force = np.stack(
            [limit * np.cos(angle), limit * np.sin(angle), cycle.answer.load_n], axis=-1
        )
        torque = np.abs(joint_torque(cycle.jacobian_m, force))
        assert (torque <= most + 1e-12).all()
    assert (np.abs(cycle.torque_nm) <= most + 1e-9).all()


def test_a_gait_of_even_speed_over_flat_paths_forces_no_slip() -> None:
    """In single support all feet of a tripod go through the same angles at the same speed."""
    cycle = walk_cycle(ROBOT, make_gait("tripod", ROBOT))
    single = cycle.stance.sum(axis=1) == 3
    middle = single & np.roll(single, 4) & np.roll(single, -4)  # away from the rounded corners
    np.testing.assert_allclose(cycle.forced.rms_m_s[middle], 0, atol=1e-12)
    uneven = walk_cycle(ROBOT, make_gait("metachronal", ROBOT))
    assert uneven.forced.rms_m_s.min() > 1e-3


def test_speed_is_that_of_the_feet_where_none_slips() -> None:
    cycle = walk_cycle(ROBOT, make_gait("tripod", ROBOT))
    frame = int(np.argmin(np.abs(cycle.phase - 0.3)))
    down = cycle.stance[frame]
    feet = -cycle.feet.velocity_m_s[frame, down, 0]
    assert cycle.answer.velocity_B[frame, 0] == pytest.approx(feet.mean(), abs=1e-9)


def test_how_far_a_foot_is_through_its_swing() -> None:
    stance = np.array([[1, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1], [0, 0, 1, 1]], dtype=np.bool_)
    share = swing_share(stance)
    np.testing.assert_allclose(share[:, 0], [np.nan, np.nan, 0.25, 0.75])
    assert np.isnan(share[:, 1]).all()  # never down: no beginning
    np.testing.assert_allclose(share[:, 2], [np.nan, 0.25, 0.75, np.nan])
    np.testing.assert_allclose(share[:, 3], [0.25, 0.75, np.nan, np.nan])


def test_two_swings_in_a_cycle_and_one_over_its_end() -> None:
    column = np.array([0, 1, 0, 0, 1, 1, 0], dtype=np.bool_)
    share = swing_share(column[:, None])[:, 0]
    np.testing.assert_allclose(share, [0.75, np.nan, 0.25, 0.75, np.nan, np.nan, 0.25])


def test_no_other_shift_keeps_the_robot_farther_from_tipping() -> None:
    robot = robot_with(
        {"legs.shaft_position": lambda rows: [[x + 0.1, y + 0.02, z] for x, y, z in rows]}
    )
    cycle = walk_cycle(robot.parameters, make_gait("tripod", robot.parameters))
    feet = cycle.feet.position_m[..., :2]
    best = best_shift(feet, cycle.stance)
    assert static_margin(feet + best.shift_m, cycle.stance).margin_m.min() == pytest.approx(
        best.margin_m
    )
    for _ in range(200):
        shift = best.shift_m + RANDOM.normal(size=2) * 0.02
        assert static_margin(feet + shift, cycle.stance).margin_m.min() <= best.margin_m + 1e-9
    assert best.shift_m[1] == pytest.approx(-0.02, abs=1e-3)


def test_a_line_of_feet_has_no_good_place() -> None:
    feet = np.broadcast_to(np.array([[0.0, -1], [0, 1]]), (5, 2, 2))
    assert best_shift(feet, np.ones((5, 2), dtype=np.bool_)).margin_m == pytest.approx(0)


def test_full_steering_turns_to_the_left_and_straight_walks_straight() -> None:
    walked = walk_gait(ROBOT, make_gait("tripod", ROBOT))
    straight = walked.cycle.answer.velocity_B.mean(axis=0)
    assert walked.figures.speed_m_s == pytest.approx(straight[0])
    assert np.abs(straight[1:]).max() < 1e-12
    assert walked.figures.turn_rad_s > 0.005


def test_a_faster_gait_is_faster_and_no_heavier() -> None:
    gait = make_gait("tripod", ROBOT)
    slow, fast = walk_gait(ROBOT, gait).figures, walk_gait(ROBOT, gait, 0.3).figures
    assert fast.speed_m_s == pytest.approx(3 * slow.speed_m_s, rel=1e-6)
    assert fast.shaft_rad_s2 == pytest.approx(9 * slow.shaft_rad_s2)
    assert fast.torque_most_nm == pytest.approx(slow.torque_most_nm)
