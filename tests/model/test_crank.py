"""The crank: exact slope against finite differences and against a polygon that is turned and rolled."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.errors import ConfigError
from model.kinematics.crank import CrankKinematics, check_crank, crank_pose
from model.parameters.tables import parse_table, read_leg
from model.values.arrays import FloatArray
from model.values.parameters import CrankParameters
from sim_hw.plant.leg_path import CRANK, leg_point
from tests.soaked import soaked

TURN = np.linspace(-7.0, 7.0, 2001)
STANCE = np.linspace(-1.2, 1.2, 241)
WHEEL = CrankParameters(0.1, 0.05)
SHAFTS = np.array([[-0.2, 0.1, 0.0], [0.0, 0.1, 0.01], [0.2, 0.1, 0.0], [0.1, -0.1, 0.0]])


@pytest.fixture(autouse=True, scope="module")
def ready() -> None:
    """The kernels compile here, not within the time of a first example."""
    crank_pose(WHEEL, TURN)
    leg_point(np.zeros(10), 0.0)


@st.composite
def cranks(draw: st.DrawFn) -> CrankParameters:
    length = draw(st.floats(0.02, 0.5))
    return CrankParameters(length, length * draw(st.floats(0.0, 0.5)))


def outline(crank: CrankParameters, points: int = 20_001) -> FloatArray:
    """The leg's sole at shaft angle 0, by points on its half circle, toe first, (K, 2)."""
    around = np.linspace(0.0, np.pi, points)
    x, z = -crank.radius * np.sin(around), -crank.radius * np.cos(around)
    return np.stack([x, z - (crank.length - crank.radius)], axis=1)


def turned(points: FloatArray, angle: float) -> FloatArray:
    """Points turned about the shaft so that what points down goes backward."""
    c, s = np.cos(angle), np.sin(angle)
    rotated: FloatArray = points @ np.array([[c, -s], [s, c]])
    return rotated


@given(cranks())
def test_matter_at_the_foot_moves_as_the_slope_says(crank: CrankParameters) -> None:
    # the point of the leg that is at the foot, carried on by a small turn about the shaft
    pose, h = crank_pose(crank, TURN), 1e-5
    along = np.stack([np.cos(h) * pose.foot[:, 0] + np.sin(h) * pose.foot[:, 1],
                      np.cos(h) * pose.foot[:, 1] - np.sin(h) * pose.foot[:, 0]], axis=1)  # fmt: skip
    back = np.stack([np.cos(h) * pose.foot[:, 0] - np.sin(h) * pose.foot[:, 1],
                     np.cos(h) * pose.foot[:, 1] + np.sin(h) * pose.foot[:, 0]], axis=1)  # fmt: skip
    np.testing.assert_allclose((along - back) / (2 * h), pose.foot_slope, atol=1e-7)


@given(cranks())
def test_the_place_of_contact_runs_ahead_of_the_matter_by_the_roll(crank: CrankParameters) -> None:
    angle, h = STANCE[np.abs(STANCE) > 1e-4], 1e-6
    pose, ahead, behind = (crank_pose(crank, angle + step) for step in (0.0, h, -h))
    place = (ahead.foot - behind.foot) / (2 * h)
    roll = (ahead.roll - behind.roll) / (2 * h)
    matter = place + np.stack([crank.radius * roll, np.zeros_like(roll)], axis=1)
    np.testing.assert_allclose(matter, pose.foot_slope, atol=1e-7)


@given(cranks())
def test_the_foot_is_the_lowest_point_of_the_leg(crank: CrankParameters) -> None:
    sole = outline(crank)
    for angle in STANCE[::20]:
        points = turned(sole, float(angle))
        lowest = points[np.argmin(points[:, 1])]
        foot = crank_pose(crank, np.array(angle)).foot
        # of a polygon's corners the lowest is a chord off, below a ten-thousandth of the radius
        assert foot[1] == pytest.approx(lowest[1], abs=1e-7)
        assert foot[0] == pytest.approx(lowest[0], abs=2e-4 * crank.radius + 1e-9)


@pytest.mark.parametrize("radius", soaked([0.0, 0.02, 0.05], lambda radius: radius == 0.02))
def test_an_outline_rolled_without_slip_carries_the_shaft_as_the_slope_says(radius: float) -> None:
    """The shaft over ground that holds the sole: rolled numerically, corner by corner of a polygon."""
    crank = CrankParameters(0.11, radius)
    sole = outline(crank, 40_001)
    angles = np.linspace(-1.0, 0.8, 3601)
    at, place = 0, np.zeros(2)  # which corner is on the ground, and where the shaft is
    for before, after in pairwise(angles):
        # the corner that touches stays; the leg turns about it until the next one touches
        points = turned(sole, float(before))
        at = int(np.argmin(points[:, 1]))
        place += points[at] - turned(sole, float(after))[at]
    pose = crank_pose(crank, angles)
    # the body goes as the matter at the foot goes back: up to the arc of each step, r da^2 / 2
    middle = (pose.foot_slope[:-1] + pose.foot_slope[1:]) / 2
    np.testing.assert_allclose(place, -(middle * np.diff(angles)[:, None]).sum(axis=0), atol=3e-5)


def test_a_half_circle_keeps_its_radius_below_its_centre() -> None:
    pose = crank_pose(WHEEL, np.linspace(-np.pi / 2, 0.0, 11))
    centre = (WHEEL.length - WHEEL.radius) * np.cos(np.linspace(-np.pi / 2, 0.0, 11))
    np.testing.assert_allclose(-pose.foot[:, 1], centre + 0.05, atol=1e-15)
    assert pose.roll[0] - pose.roll[-1] == pytest.approx(np.pi / 2)


@given(cranks())
def test_nothing_jumps_over_whole_turns(crank: CrankParameters) -> None:
    pose, step = crank_pose(crank, TURN), TURN[1] - TURN[0]
    assert np.abs(np.diff(pose.foot, axis=0)).max() < 4 * step * crank.length
    assert np.abs(np.diff(pose.roll)).max() < 1.001 * step
    again = crank_pose(crank, TURN + 2 * np.pi)
    np.testing.assert_allclose(again.foot, pose.foot, atol=1e-12)
    np.testing.assert_allclose(again.roll, pose.roll - np.pi, atol=1e-12)


@given(cranks())
def test_feet_in_swing_are_above_the_shaft_or_the_rolling_half(crank: CrankParameters) -> None:
    swing = np.linspace(np.pi / 2, 1.5 * np.pi, 301)
    assert crank_pose(crank, swing).foot[:, 1].min() >= -crank.radius - 1e-12


def test_all_legs_at_once_with_velocities() -> None:
    crank = CrankParameters(0.1, 0.03)
    kinematics = CrankKinematics(crank, SHAFTS)
    random = np.random.default_rng(3)
    angle, rate = random.uniform(-9, 9, (5, 4)), random.uniform(-4, 4, (5, 4))
    motion, pose = kinematics.feet(angle, rate), crank_pose(crank, angle)
    np.testing.assert_allclose(motion.position_m[..., 0], SHAFTS[:, 0] + pose.foot[..., 0])
    np.testing.assert_allclose(motion.position_m[..., 2], SHAFTS[:, 2] + pose.foot[..., 1])
    np.testing.assert_allclose(motion.velocity_m_s[..., [0, 2]], pose.foot_slope * rate[..., None])
    np.testing.assert_array_equal(motion.velocity_m_s[..., 1], 0.0)
    jacobian = kinematics.jacobian(angle)
    assert jacobian.shape == (5, 4, 3, kinematics.joint_count)
    np.testing.assert_allclose(
        np.einsum("fnij,fj->fni", jacobian, rate), motion.velocity_m_s, atol=1e-15
    )
    assert np.isnan(kinematics.feet(np.full(4, np.nan), rate[0]).position_m[:, 0]).all()
    with pytest.raises(ValueError, match="not those of 4 legs"):
        kinematics.feet(angle[:, :3], rate[:, :3])


def test_a_growing_angle_moves_a_foot_in_stance_backward() -> None:
    pose = crank_pose(CrankParameters(0.1, 0.03), STANCE)
    assert (pose.foot_slope[:, 0] < 0).all()


def leg_of(text: str) -> object:
    return read_leg(parse_table("[leg]\n" + text))


def test_a_crank_is_read_from_its_table() -> None:
    leg = leg_of('kind = "crank"\nlength = 0.11\nradius = 0.05\n')
    assert leg == CrankParameters(0.11, 0.05)
    assert leg_of('kind = "crank"\nlength = 0.11\n') == CrankParameters(0.11, 0.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("length = 0.0", r"leg\.length: must be above 0"),
        ("length = nan", r"leg\.length: must be finite"),
        ("radius = 0.02", r"leg\.length: is missing"),
        ("length = 0.1\nradius = -0.01", r"leg\.radius: must be at least 0"),
        ("length = 0.1\nradius = 0.06", r"leg\.radius: a half circle of 60\.0 mm does not fit"),
    ],
)
def test_an_impossible_crank_is_refused(text: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        leg_of('kind = "crank"\n' + text)


def test_the_largest_half_circle_is_half_the_length() -> None:
    check_crank(CrankParameters(0.1, 0.05))
    with pytest.raises(ConfigError):
        check_crank(CrankParameters(0.1, 0.0501))


@given(cranks())
def test_the_plants_own_crank_agrees(crank: CrankParameters) -> None:
    """Two implementations of one leg; the plant's slope is that of the place, apart from the roll."""
    geometry = np.zeros(10)
    geometry[[0, 1, 9]] = crank.length, crank.radius, CRANK
    pose = crank_pose(crank, TURN)
    points = np.array([leg_point(geometry, angle) for angle in TURN])
    np.testing.assert_allclose(points[:, :2], pose.foot, atol=1e-12)
    round_leg = crank.radius > 0
    np.testing.assert_allclose(points[:, 4], pose.roll if round_leg else -TURN, atol=1e-12)
    standing = np.abs((TURN + np.pi) % (2 * np.pi) - np.pi) < np.pi / 2
    matter = points[:, 2:4] + np.stack([crank.radius * points[:, 5], 0 * TURN], axis=1)
    np.testing.assert_allclose(matter[standing], pose.foot_slope[standing], atol=1e-12)
    step = 1e-6
    ahead, behind = (
        np.array([leg_point(geometry, angle + s)[:2] for angle in TURN]) for s in (step, -step)
    )
    smooth = np.abs(TURN / np.pi - np.round(TURN / np.pi)) > 1e-5
    slope = (ahead - behind) / (2 * step)
    np.testing.assert_allclose(slope[smooth], points[smooth, 2:4], atol=1e-7)
