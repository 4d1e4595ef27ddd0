"""Robots beside the file's: each against the public model of such a robot, and their spread."""

import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from model.estimator import filter as filter_module
from model.estimator.filter import Estimator
from model.estimator.kalman import sound
from model.estimator.neighbourhood import Neighbourhood, neighbourhood
from model.estimator.process import Beside, walking
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.stride import Moment, Stride, stride
from model.estimator.tolerance_kernel import COM_X, COM_Y, CREEP_M_S, OTHERS, SLOPE_X, SLOPE_Y
from model.estimator.tolerances import Apart
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.values.arrays import FloatArray
from model.values.estimate import (
    FIXED,
    POSE,
    SCALE,
    VELOCITY,
    YAW,
    Companions,
    Estimate,
    EstimatorState,
    OdometryInputs,
)
from model.values.legs import FootForces, FootMotion
from model.values.parameters import ContactParameters
from tests.model.estimator_world import CONTACT, PERIOD_NS, WEIGHT_N, feet_at, simulate

ROOT = Path(__file__).parents[2]
SETTINGS = EstimatorSettings()
FLAT = replace(SETTINGS, sway=False, rest_speed=0.0)
EXACT = replace(SETTINGS, height_sd=0.0, com_sd=0.0, slope_sd=0.0)
ROBOTS = 2 * (6 + OTHERS)
STEP_S = PERIOD_NS * 1e-9


def some_mean() -> FloatArray:
    """A state with a yaw, a velocity, and parameters that are not the robot file's."""
    mean = np.zeros(FIXED + 12)
    draw = np.random.default_rng(3)
    mean[YAW], mean[VELOCITY] = 0.8, [0.03, -0.01, 0.1]
    mean[SCALE], mean[FIXED:] = -0.1, 0.2 * draw.normal(size=12)
    return mean


def some_feet() -> FootMotion:
    """Feet that all slip, up and aside as well."""
    feet, draw = feet_at(1.1), np.random.default_rng(4)
    velocity = feet.velocity_m_s + 0.02 * draw.normal(size=(6, 3))
    return FootMotion(feet.position_m, velocity)


def of_mean(mean: FloatArray) -> ContactParameters:
    """What the robot's contact is by a state."""
    mu = CONTACT.mu * np.exp(mean[SCALE] + mean[FIXED : FIXED + 6])
    return ContactParameters(CONTACT.stiffness * np.exp(mean[FIXED + 6 :]), mu, CONTACT.anisotropy)


def answer(mean: FloatArray, feet: FootMotion, record: Record) -> Neighbourhood:
    at_file = neighbourhood(mean, feet, CONTACT, record)
    assert at_file is not None
    return at_file


def one_step(settings: EstimatorSettings) -> tuple[Neighbourhood, Companions, Apart]:
    mean, feet, record = some_mean(), some_feet(), record_of(settings, WEIGHT_N)
    state = replace(Estimator(CONTACT, WEIGHT_N, settings).initial(), mean=mean)
    strode = stride(state, feet, CONTACT, record, None, Moment(STEP_S, 0, np.zeros(3)))
    assert strode is not None
    return strode.model, strode.companions, strode.apart


def public_answer(position: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Velocity, (3,), and loads over the weight, (6,), of the public model for feet moved elsewhere."""
    feet = FootMotion(position[None], some_feet().velocity_m_s[None])
    solved = solve_frames(feet, of_mean(some_mean()), WEIGHT_N, law=FrictionLaw.COULOMB)
    assert solved.valid.all()
    return solved.velocity_B[0], solved.load_n[0] / WEIGHT_N


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("leg", range(6))
def test_a_foot_off_in_height_is_the_model_of_a_robot_with_that_leg(leg: int, sign: int) -> None:
    at_file, _, apart = one_step(FLAT)
    robot = leg if sign > 0 else ROBOTS // 2 + leg
    place = some_feet().position_m.copy()
    place[leg, 2] -= sign * FLAT.height_sd * at_file.pose[2]  # higher ground is a longer leg
    velocity, share = public_answer(place)
    np.testing.assert_allclose(
        at_file.velocity_B + apart.velocity_B[robot], velocity, rtol=0, atol=1e-8
    )
    np.testing.assert_allclose(
        at_file.load_n / WEIGHT_N + apart.load_share[robot], share, rtol=0, atol=1e-9
    )
    assert np.abs(apart.velocity_B[robot]).max() > 1e-5, "such a robot walks elsewhere"


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("axis", [COM_X, COM_Y])
def test_a_centre_of_mass_off_is_the_model_seen_from_there(axis: int, sign: int) -> None:
    at_file, _, apart = one_step(FLAT)
    robot = (0 if sign > 0 else ROBOTS // 2) + 6 + axis
    off = np.zeros(3)
    off[axis] = sign * FLAT.com_sd * at_file.pose[2]
    velocity, share = public_answer(some_feet().position_m - off)
    velocity = velocity.copy()
    velocity[:2] += velocity[2] * np.array([off[1], -off[0]])  # of the body's origin
    np.testing.assert_allclose(
        at_file.velocity_B + apart.velocity_B[robot], velocity, rtol=0, atol=1e-8
    )
    np.testing.assert_allclose(
        at_file.load_n / WEIGHT_N + apart.load_share[robot], share, rtol=0, atol=1e-9
    )


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("axis", [SLOPE_X, SLOPE_Y])
def test_on_a_slope_friction_balances_gravity(axis: int, sign: int) -> None:
    at_file, _, apart = one_step(FLAT)
    robot = (0 if sign > 0 else ROBOTS // 2) + 6 + axis
    feet, contact, yaw = some_feet(), of_mean(some_mean()), some_mean()[YAW]
    down_world = sign * FLAT.slope_sd * np.eye(2)[axis - SLOPE_X]
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    down = turn @ down_world
    vx, vy, turning = at_file.velocity_B + apart.velocity_B[robot]
    slip = feet.velocity_m_s[:, :2] + np.array([vx, vy])
    slip += turning * np.stack([-feet.position_m[:, 1], feet.position_m[:, 0]], axis=1)
    load = at_file.load_n + WEIGHT_N * apart.load_share[robot]
    speed = np.sqrt((slip**2).sum(axis=1) + CREEP_M_S**2)
    friction = -(contact.mu * load / speed)[:, None] * slip
    np.testing.assert_allclose(friction.sum(axis=0), -WEIGHT_N * down, atol=1e-4)
    # about the point below which gravity acts
    arm = feet.position_m[:, :2] - at_file.pose[2] * down
    moment = arm[:, 0] * friction[:, 1] - arm[:, 1] * friction[:, 0]
    assert moment.sum() == pytest.approx(0, abs=1e-4)
    assert load.sum() == pytest.approx(WEIGHT_N)


def run(
    inputs: list[OdometryInputs], settings: EstimatorSettings = SETTINGS
) -> tuple[list[EstimatorState], list[Estimate]]:
    estimator = Estimator(CONTACT, WEIGHT_N, settings)
    state, states, estimates = estimator.initial(), [], []
    for known in inputs:
        state, estimate = estimator.step(state, known)
        states.append(state)
        estimates.append(estimate)
    return states, estimates


@cache  # not made by whoever only collects tests
def walk() -> list[OdometryInputs]:
    return list(simulate(SETTINGS, 31, 150).inputs)


def test_tolerances_of_nothing_spread_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    with_them, estimates = run(walk(), EXACT)
    for state, estimate in zip(with_them, estimates, strict=True):
        assert np.abs(state.companions.apart).max() < 1e-9
        np.testing.assert_allclose(
            estimate.pose_covariance, state.covariance[POSE, POSE], rtol=1e-9, atol=1e-18
        )

    def alone(state: EstimatorState, *rest: Any) -> Stride | None:
        feet, contact, record, _, (dt_s, dead_legs, drift) = rest
        model = neighbourhood(state.mean, feet, contact, record)
        assert model is not None
        beside = Beside(_NOTHING.velocity_B, state.strain, drift)
        step = walking(state.mean, state.covariance, model, record, dt_s, dead_legs, beside)
        return Stride(model, state.companions, _NOTHING, step)

    monkeypatch.setattr(filter_module, "stride", alone)
    without, _ = run(walk(), EXACT)
    np.testing.assert_allclose(with_them[-1].mean, without[-1].mean, rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        with_them[-1].covariance, without[-1].covariance, rtol=1e-7, atol=1e-14
    )


_NOTHING = Apart(np.zeros((ROBOTS, 3)), np.zeros((ROBOTS, 6)))


def test_legs_in_another_order_give_the_same_spread() -> None:
    order = np.array([3, 5, 0, 2, 1, 4])

    def shuffled(known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        feet = FootMotion(known.feet.position_m[order], known.feet.velocity_m_s[order])
        forces = replace(known.forces, force_n=known.forces.force_n[order])
        return replace(known, feet=feet, forces=forces)

    one, other = run(walk())[1][-1], run([shuffled(known) for known in walk()])[1][-1]
    np.testing.assert_allclose(
        other.companion_pose[:6], one.companion_pose[:6][order], rtol=1e-5, atol=1e-9
    )
    np.testing.assert_allclose(other.pose_covariance, one.pose_covariance, rtol=1e-5, atol=1e-12)


def test_a_mirrored_walk_mirrors_the_spread() -> None:
    sign = np.array([1.0, -1.0, 1.0])

    def mirrored(known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        feet = FootMotion(known.feet.position_m * sign, known.feet.velocity_m_s * sign)
        forces = replace(known.forces, force_n=known.forces.force_n * sign)
        return replace(known, feet=feet, forces=forces)

    one, other = run(walk())[1][-1], run([mirrored(known) for known in walk()])[1][-1]
    flip = np.array([1.0, -1.0, -1.0])
    expected = one.pose_covariance * np.outer(flip, flip)
    np.testing.assert_allclose(other.pose_covariance, expected, rtol=1e-5, atol=1e-12)


def test_twice_the_time_is_twice_the_spread() -> None:
    """An error of the file comes back with each stride; noise would add up with the root of time."""
    seconds = 5  # of a stride
    inputs = [OdometryInputs(i * PERIOD_NS, feet_at(i * STEP_S)) for i in range(300 * seconds)]
    states, _ = run(inputs)
    yaw = [
        np.sqrt(states[100 * seconds * k - 1].companions.pose_covariance[2, 2]) for k in (1, 2, 3)
    ]
    assert yaw[0] > 1e-4
    np.testing.assert_allclose(np.array(yaw) / yaw[0], [1, 2, 3], rtol=0.1)


def test_the_covariance_of_the_pose_is_the_filters_and_the_spread() -> None:
    mute = [replace(known, forces=None) for known in walk()]
    for inputs in (walk(), mute):
        for state, estimate in zip(*run(inputs), strict=True):
            apart = state.companions.apart
            up, down = apart[: ROBOTS // 2], apart[ROBOTS // 2 :]
            both = sum(0.5 * np.outer(a, a) for a in (*up, *down))
            expected = state.covariance[POSE, POSE] + both
            np.testing.assert_allclose(estimate.pose_covariance, expected, rtol=1e-9, atol=1e-15)
            assert sound(np.array(estimate.pose_covariance))
        assert np.trace(state.companions.pose_covariance) > 1e-8


def test_an_absolute_pose_gathers_the_spread_in_the_covariance() -> None:
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = run(walk()[:-1])[0][-1]
    without, _ = estimator.step(state, walk()[-1])
    seen = np.array([*without.mean[:2], np.nan])
    gathered, estimate = estimator.step(state, replace(walk()[-1], pose_W=seen))
    assert not gathered.companions.apart.any()
    assert not estimate.companion_pose.any()
    expected = without.before[1].copy()
    expected[POSE, POSE] += without.companions.pose_covariance
    np.testing.assert_allclose(gathered.before[1], expected, rtol=1e-12, atol=1e-18)
    assert np.trace(without.companions.pose_covariance) > 1e-8
    np.testing.assert_array_equal(estimate.pose_covariance, gathered.covariance[POSE, POSE])
    # a pose that nobody knows is none
    nowhere, _ = estimator.step(state, replace(walk()[-1], pose_W=np.full(3, np.nan)))
    assert nowhere.companions.apart.tobytes() == without.companions.apart.tobytes()


def test_standing_still_does_not_spread_the_companions() -> None:
    still = FootMotion(walk()[-1].feet.position_m, np.zeros((6, 3)))
    force = np.zeros((6, 3))
    force[:, 2] = WEIGHT_N / 6
    standing = []
    for i in range(150, 350):
        heard = FootForces(i * PERIOD_NS, force, np.ones(6, dtype=bool))
        standing.append(OdometryInputs(i * PERIOD_NS, still, heard))
    states, estimates = run(walk() + standing)
    assert estimates[200].holding
    assert states[-1].companions.apart.tobytes() == states[200].companions.apart.tobytes()
    before, after = (states[i].companions.pose_covariance for i in (149, -1))
    # a little while it comes to rest
    np.testing.assert_allclose(np.diag(after), np.diag(before), rtol=0.02)


def test_feet_that_cannot_carry_a_companion_leave_it_with_the_files_robot() -> None:
    """A centre of mass that far off tips every robot beside the file's."""
    at_file, companions, apart = one_step(replace(FLAT, com_sd=50.0))
    tipped = [6 + COM_X, 6 + COM_Y, ROBOTS // 2 + 6 + COM_X, ROBOTS // 2 + 6 + COM_Y]
    assert not apart.velocity_B[tipped].any()
    np.testing.assert_allclose(apart.load_share[tipped], 0, atol=1e-15)
    assert np.isfinite(companions.apart).all()
    assert at_file.load_n.sum() == pytest.approx(WEIGHT_N)


WITHOUT = """
import sys
sys.modules["numba"] = None
import numpy as np
from model.compiled import compiles
from tests.model.test_estimator_tolerances import SETTINGS, one_step
assert not compiles()
_, companions, apart = one_step(SETTINGS)
np.savez(sys.argv[1], twist=companions.twist, velocity=apart.velocity_B, load=apart.load_share)
"""


def test_without_a_compiler_they_walk_the_same(tmp_path: Path) -> None:
    path = tmp_path / "out.npz"
    subprocess.run([sys.executable, "-c", WITHOUT, str(path)], cwd=ROOT, check=True)
    plain = np.load(path)
    _, companions, apart = one_step(SETTINGS)
    np.testing.assert_allclose(plain["twist"], companions.twist, atol=1e-9)
    np.testing.assert_allclose(plain["velocity"], apart.velocity_B, atol=1e-9)
    np.testing.assert_allclose(plain["load"], apart.load_share, atol=1e-12)
