"""The estimator: symmetries, consistency, smoothing, predicted forces."""

from dataclasses import replace

import numpy as np
import pytest

from model.errors import ModelError
from model.estimator.filter import Estimator
from model.estimator.kalman import mended, sound
from model.estimator.settings import EstimatorSettings
from model.estimator.smoother import smooth
from model.values.estimate import (
    SCALE,
    VELOCITY,
    OdometryInputs,
)
from model.values.legs import FootForces, FootMotion
from robot.odometry.metrics import in_band, nees
from tests.model.estimator_world import (
    CONTACT,
    PLACES,
    WEIGHT_N,
    feet_at,
    friction_of,
    run,
    simulate,
)

SETTINGS = EstimatorSettings()
# a robot that is as its file says
EXACT = replace(SETTINGS, height_sd=0.0, com_sd=0.0, slope_sd=0.0)
# ... and forces that are drawn, which shake nothing
CALM = replace(EXACT, vibration_s=0.0, vibration_per_slip=0.0)
KNOWN = replace(SETTINGS, parameter_sd=0.05, scale_sd=0.05)


def test_mending_makes_a_covariance_sound() -> None:
    broken = np.diag([1.0, -1e-3, 2.0])
    assert not sound(broken)
    assert sound(mended(broken))
    np.testing.assert_allclose(np.diag(mended(broken))[[0, 2]], [1.0, 2.0])


def test_legs_may_be_called_in_any_order() -> None:
    order = np.array([3, 5, 0, 2, 1, 4])
    world = simulate(SETTINGS, 4, 150)

    def shuffled(known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        feet = FootMotion(known.feet.position_m[order], known.feet.velocity_m_s[order])
        forces = replace(known.forces, force_n=known.forces.force_n[order])
        return replace(known, feet=feet, forces=forces)

    one = run(list(world.inputs))[1][-1]
    other = run([shuffled(known) for known in world.inputs])[1][-1]
    np.testing.assert_allclose(other.velocity_B, one.velocity_B, atol=1e-8)
    np.testing.assert_allclose(other.position_m, one.position_m, atol=1e-8)
    np.testing.assert_allclose(other.mu, one.mu[order], atol=1e-7)
    np.testing.assert_allclose(other.stiffness, one.stiffness[order], rtol=1e-7)


def test_a_mirrored_walk_gives_the_mirrored_estimate() -> None:
    world = simulate(SETTINGS, 5, 150)
    sign = np.array([1.0, -1.0, 1.0])

    def mirrored(known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        feet = FootMotion(known.feet.position_m * sign, known.feet.velocity_m_s * sign)
        return replace(
            known, feet=feet, forces=replace(known.forces, force_n=known.forces.force_n * sign)
        )

    one = run(list(world.inputs))[1][-1]
    other = run([mirrored(known) for known in world.inputs])[1][-1]
    np.testing.assert_allclose(other.velocity_B, one.velocity_B * [1, -1, -1], atol=1e-8)
    np.testing.assert_allclose(other.position_m, one.position_m * [1, -1], atol=1e-8)
    assert other.yaw_rad == pytest.approx(-one.yaw_rad, abs=1e-8)
    np.testing.assert_allclose(other.mu, one.mu, atol=1e-7)


def test_forces_twice_as_large_say_the_same() -> None:
    world = simulate(SETTINGS, 6, 150)

    def doubled(known: OdometryInputs) -> OdometryInputs:
        assert known.forces is not None
        return replace(known, forces=replace(known.forces, force_n=2 * known.forces.force_n))

    one = run(list(world.inputs))[1][-1]
    other = run([doubled(known) for known in world.inputs])[1][-1]
    np.testing.assert_allclose(other.velocity_B, one.velocity_B, atol=1e-12)
    np.testing.assert_allclose(other.mu, one.mu, atol=1e-12)


def test_same_inputs_same_bits() -> None:
    world = simulate(SETTINGS, 7, 100)
    first, second = (run(list(world.inputs))[0][-1] for _ in range(2))
    assert first.mean.tobytes() == second.mean.tobytes()
    assert first.covariance.tobytes() == second.covariance.tobytes()


def test_without_absolute_poses_the_global_pose_is_never_known_better_than_at_first() -> None:
    world = simulate(SETTINGS, 8, 300)
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial()
    state.covariance[:3, :3] = np.eye(3)
    for known in world.inputs:
        state, estimate = estimator.step(state, known)
        assert np.diag(estimate.pose_covariance).min() >= 1 - 1e-9


def test_parameters_are_found() -> None:
    quiet = replace(EXACT, force_share_sd=0.03, load_sd=0.01, parameter_walk=0.001)
    world = simulate(quiet, 9, 1500)
    state = run(list(world.inputs), quiet)[0][-1]
    found = state.mean[SCALE:]
    sd = np.sqrt(np.diag(state.covariance))[SCALE:]
    mu = slice(friction_of(6).start - SCALE, friction_of(6).stop - SCALE)
    assert np.abs(found - world.parameters)[mu].max() < 0.06
    assert (np.abs(found - world.parameters)[2:] < 4 * sd[2:] + 0.01).all()
    assert np.corrcoef(found[mu], world.parameters[mu])[0, 1] > 0.9


def test_matched_world_is_consistent() -> None:
    """Tier one in small: the benchmark runs 50 worlds, and parameters known less well."""
    runs, known = 10, replace(CALM, parameter_sd=KNOWN.parameter_sd, scale_sd=KNOWN.scale_sd)
    total = np.zeros((2, 250))
    for seed in range(runs):
        world = simulate(known, 100 + seed, 250)
        said = run(list(world.inputs), known)[1]
        velocity = np.array([e.velocity_B for e in said]) - world.velocity
        pose = np.array([[*e.position_m, e.yaw_rad] for e in said]) - world.pose
        total[0] += nees(velocity, np.array([e.twist_covariance for e in said])) / runs
        total[1] += nees(pose, np.array([e.pose_covariance for e in said])) / runs
    assert 2.0 < total[0].mean() < 4.2
    assert 1.5 < total[1].mean() < 5.0
    assert in_band(total[0], 3, runs) > 0.8


def test_smoothing_is_better_than_filtering_and_ends_with_it() -> None:
    # errors that last: white ones leave nothing for the future to tell
    lasting = replace(
        KNOWN, parameter_sd=0.02, scale_sd=0.02, bend=0.0, speed_per_slip=0.0, turn_per_slip=0.0,
        bias_speed_per_slip=0.3, bias_turn_per_slip=0.3, bias_time_s=0.5, height_sd=0.0,
        com_sd=0.0, slope_sd=0.0,
    )  # fmt: skip
    error = np.zeros(2)
    for seed in range(14, 19):
        world = simulate(lasting, seed, 300)
        states = run(list(world.inputs), lasting)[0]
        mean, covariance = smooth(states)
        np.testing.assert_array_equal(mean[-1], states[-1].mean)
        filtered = np.array([s.mean[VELOCITY] for s in states]) - world.velocity
        smoothed = mean[:, VELOCITY] - world.velocity
        error += (filtered**2).sum(), (smoothed**2).sum()
        for i, state in enumerate(states):
            assert (np.diag(covariance[i]) <= np.diag(state.covariance) + 1e-12).all()
    assert error[1] < 0.9 * error[0]


def test_predicted_forces_carry_the_weight_with_and_without_a_sensor() -> None:
    world = simulate(SETTINGS, 16, 60)
    mute = [replace(known, forces=None) for known in world.inputs]
    for inputs in (list(world.inputs), mute):
        said = run(inputs)[1][-1]
        assert said.force_B[:, 2].sum() == pytest.approx(WEIGHT_N)
        assert said.load_share.sum() == pytest.approx(1.0)
        np.testing.assert_allclose(said.force_B[:, :2].sum(axis=0), 0, atol=1e-6)
        for k in np.flatnonzero(said.load_share > 0):
            assert sound(said.force_covariance[k])


@pytest.mark.parametrize(
    "make",
    [
        lambda: EstimatorSettings(force_sd=0.0),
        lambda: EstimatorSettings(lag_s=-1.0),
        lambda: EstimatorSettings(pose_sd=float("nan")),
        lambda: EstimatorSettings(load_on=0.01, load_off=0.05),
        lambda: Estimator(CONTACT, 0.0),
        lambda: Estimator(CONTACT, WEIGHT_N).step(
            Estimator(CONTACT, WEIGHT_N).initial(),
            OdometryInputs(0, FootMotion(np.zeros((5, 3)), np.zeros((5, 3)))),
        ),
        lambda: smooth([]),
    ],
)
def test_mistakes_are_refused(make: object) -> None:
    assert callable(make)
    with pytest.raises(ModelError):
        make()


def test_forces_of_another_robot_are_refused() -> None:
    estimator = Estimator(CONTACT, WEIGHT_N)
    wrong = FootForces(0, np.zeros((4, 3)), np.ones(4, dtype=bool))
    with pytest.raises(ModelError, match="forces must be"):
        estimator.step(estimator.initial(), OdometryInputs(0, feet_at(0), wrong))
    assert len(PLACES) == 6
