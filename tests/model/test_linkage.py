"""The four-bar: loop closure, derivative, branch, and linkages that cannot turn."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.errors import ConfigError
from model.kinematics.four_bar import FourBarKinematics, LinkagePose, check_linkage, linkage_pose
from model.values.arrays import FloatArray
from model.values.parameters import FourBarParameters
from robot.config.robot_file import load_robot
from sim_hw.plant.leg_path import foot_path
from sim_hw.plant.parameters import PlantParameters, plant_legs

ROBOT = load_robot().parameters
assert isinstance(ROBOT.leg, FourBarParameters)
NOMINAL = ROBOT.leg
TURN = np.linspace(-np.pi, np.pi, 721)


@pytest.fixture(autouse=True, scope="module")
def _compiled() -> None:
    linkage_pose(NOMINAL, TURN)
    foot_path(PlantParameters.nominal(ROBOT), np.zeros((1, 6)))


def transmission_sine(linkage: FourBarParameters, pose: LinkagePose) -> FloatArray:
    """Sine of the angle between coupler and rocker, (M,); 0 is a dead centre."""
    u = (pose.rocker_pin - pose.crank_pin) / linkage.coupler
    v = (pose.rocker_pin - linkage.ground_pivot) / linkage.rocker
    sine: FloatArray = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return sine


@st.composite
def crank_rockers(draw: st.DrawFn) -> FourBarParameters:
    """Linkages whose crank can turn, with something to spare at both dead centres."""
    coupler = draw(st.floats(0.05, 0.2))
    rocker = coupler * draw(st.floats(0.4, 2.0))
    fold, reach = abs(coupler - rocker), coupler + rocker
    margin = 0.05 * min(coupler, rocker)
    crank = draw(st.floats(0.05, 0.9)) * ((reach - fold) / 2 - margin)
    nearest, farthest = fold + margin + crank, reach - margin - crank
    ground = nearest + draw(st.floats(0, 1)) * (farthest - nearest)
    bearing = draw(st.floats(-3.1, 3.1))
    pivot = ground * np.array([np.cos(bearing), np.sin(bearing)])
    foot = np.array([draw(st.floats(-0.1, 0.1)), draw(st.floats(-0.2, 0.2))])
    branch = draw(st.sampled_from([1, -1]))
    return FourBarParameters(crank, pivot, coupler, rocker, foot, branch, draw(st.floats(-7, 7)))


@given(crank_rockers())
def test_the_loop_closes_at_every_angle(linkage: FourBarParameters) -> None:
    pose = linkage_pose(linkage, TURN)
    scale = linkage.coupler + linkage.rocker
    assert np.abs(np.linalg.norm(pose.crank_pin, axis=1) - linkage.crank).max() < 1e-12 * scale
    bar = np.linalg.norm(pose.rocker_pin - pose.crank_pin, axis=1)
    assert np.abs(bar - linkage.coupler).max() < 1e-12 * scale
    rocker = np.linalg.norm(pose.rocker_pin - linkage.ground_pivot, axis=1)
    assert np.abs(rocker - linkage.rocker).max() < 1e-10 * scale


@given(crank_rockers())
def test_freudensteins_equation_holds(linkage: FourBarParameters) -> None:
    """K1 cos(rocker) - K2 cos(crank) + K3 = cos(crank - rocker), angles from the ground link."""
    pose = linkage_pose(linkage, TURN)
    ground = np.hypot(*linkage.ground_pivot)
    bearing = np.arctan2(linkage.ground_pivot[1], linkage.ground_pivot[0])
    a, b, c, d = linkage.crank, linkage.coupler, linkage.rocker, ground
    crank = linkage.mid_stance - TURN - bearing
    arm = pose.rocker_pin - linkage.ground_pivot
    rocker = np.arctan2(arm[:, 1], arm[:, 0]) - bearing
    left = d / a * np.cos(rocker) - d / c * np.cos(crank)
    left += (a**2 - b**2 + c**2 + d**2) / (2 * a * c)
    # Freudenstein's signs are for a ground link from crank pivot to rocker pivot
    assert np.abs(left - np.cos(crank - rocker)).max() < 1e-8 * (d / a + d / c + 1)


@given(crank_rockers())
def test_the_derivative_is_exact(linkage: FourBarParameters) -> None:
    h = 1e-6
    pose = linkage_pose(linkage, TURN)
    ahead, behind = linkage_pose(linkage, TURN + h), linkage_pose(linkage, TURN - h)
    numeric = (ahead.foot - behind.foot) / (2 * h)
    size = np.abs(pose.foot_slope).max() + np.abs(linkage.foot).max()
    worst = np.abs(transmission_sine(linkage, pose)).min()
    assert np.abs(numeric - pose.foot_slope).max() < 1e-6 * size / worst**2


@given(crank_rockers())
def test_the_branch_is_kept_all_the_way_round(linkage: FourBarParameters) -> None:
    pose = linkage_pose(linkage, TURN)
    along = linkage.ground_pivot - pose.crank_pin
    to_pin = pose.rocker_pin - pose.crank_pin
    side = along[:, 0] * to_pin[:, 1] - along[:, 1] * to_pin[:, 0]
    assert (np.sign(side) == linkage.branch).all()


@given(crank_rockers())
def test_the_plants_own_four_bar_agrees(linkage: FourBarParameters) -> None:
    """Two solutions of one mechanism: by vectors here, by angles in the plant."""
    plant = replace(
        PlantParameters.nominal(ROBOT),
        leg=plant_legs(linkage, 6),
    )
    angles = np.repeat(TURN[:, None], plant.legs, axis=1)
    x, z, x_slope, z_slope = (part[:, 0] for part in foot_path(plant, angles))
    pose = linkage_pose(linkage, TURN)
    assert np.abs(np.stack([x, z], axis=1) - pose.foot).max() < 1e-9
    slope = np.stack([x_slope, z_slope], axis=1)
    sine = transmission_sine(linkage, pose)
    assert np.abs(slope - pose.foot_slope).max() < 1e-8 / np.abs(sine).min()


def test_increasing_shaft_angle_moves_a_stance_foot_backward() -> None:
    stance = np.linspace(-1.0, 1.0, 41)
    pose = linkage_pose(NOMINAL, stance)
    assert (pose.foot_slope[:, 0] < 0).all()
    assert (pose.foot[:, 1] < -0.12).all(), "below the shaft"
    assert np.ptp(pose.foot[:, 1]) < 0.006, "nearly level"
    lifted = linkage_pose(NOMINAL, np.array([np.pi]))
    assert lifted.foot[0, 1] - pose.foot[:, 1].min() > 0.03, "clear of the ground in the return"


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"crank": 0.2}, "leg.crank"),
        ({"rocker": 0.006}, "leg.crank"),
        ({"coupler": 0.06}, "leg.crank"),
        ({"rocker": 0.24, "coupler": 0.1}, "leg.rocker"),
        ({"ground_pivot": np.array([0.0, 0.02])}, "leg.rocker"),
    ],
)
def test_linkages_that_cannot_turn_are_refused(change: dict[str, object], key: str) -> None:
    with pytest.raises(ConfigError, match=r"the linkage cannot turn: .* mm") as caught:
        check_linkage(replace(NOMINAL, **change))  # type: ignore[arg-type]
    assert caught.value.key == key


def test_a_dead_centre_exactly_is_refused() -> None:
    ground = float(np.hypot(*NOMINAL.ground_pivot))
    with pytest.raises(ConfigError):
        check_linkage(replace(NOMINAL, crank=NOMINAL.coupler + NOMINAL.rocker - ground))


def test_feet_over_legs_and_time() -> None:
    kinematics = FourBarKinematics(NOMINAL, ROBOT.legs.shaft_position)
    angle = np.linspace(0, 6, 30).reshape(5, 6)
    rate = np.full((5, 6), 2.0)
    motion = kinematics.feet(angle, rate)
    assert motion.position_m.shape == motion.velocity_m_s.shape == (5, 6, 3)
    one = kinematics.feet(angle[3], rate[3])
    assert (one.position_m == motion.position_m[3]).all()
    pose = linkage_pose(NOMINAL, angle)
    assert motion.velocity_m_s[..., 0] == pytest.approx(2 * pose.foot_slope[..., 0])
    assert (motion.velocity_m_s[..., 1] == 0).all(), "legs move fore and aft, never sideways"
    assert np.isnan(kinematics.feet(np.full(6, np.nan), rate[0]).position_m[:, 0]).all()


def test_the_jacobian_is_the_derivative_of_the_feet() -> None:
    kinematics = FourBarKinematics(NOMINAL, ROBOT.legs.shaft_position)
    angle = np.random.default_rng(1).uniform(-np.pi, np.pi, (4, 6))
    jacobian, still, step = kinematics.jacobian(angle), np.zeros((4, 6)), 1e-6
    assert jacobian.shape == (4, 6, 3, kinematics.joint_count)
    for joint in range(6):
        moved = step * (np.arange(6) == joint)
        ahead, behind = (kinematics.feet(angle + s * moved, still).position_m for s in (1, -1))
        np.testing.assert_allclose(jacobian[..., joint], (ahead - behind) / (2 * step), atol=1e-8)
