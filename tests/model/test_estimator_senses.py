"""What the estimator makes of late samples, absolute poses, a gyro, roll and pitch."""

from dataclasses import replace

import numpy as np
import pytest

from model.estimator.filter import Estimator
from model.estimator.history import EstimatorMemory, LateSample, advance, use_late
from model.estimator.settings import EstimatorSettings
from model.values.arrays import FloatArray
from model.values.estimate import (
    FIXED,
    TILT_BIAS,
    Health,
    OdometryInputs,
)
from model.values.legs import FootMotion
from tests.model.estimator_world import (
    CONTACT,
    PERIOD_NS,
    WEIGHT_N,
    feet_at,
    run,
    simulate,
    solved,
    stiffness_of,
)

SETTINGS = EstimatorSettings()
MEMORY_S = 0.5


def test_a_late_sample_counts_as_if_it_had_come_in_time() -> None:
    world = simulate(SETTINGS, 10, 120)
    estimator = Estimator(CONTACT, WEIGHT_N)
    straight = delayed = EstimatorMemory(estimator.initial())
    for known, pose in zip(world.inputs, world.pose, strict=True):
        straight, _ = advance(estimator, straight, replace(known, pose_W=pose), MEMORY_S)
    waiting: list[LateSample] = []
    for i, (known, pose) in enumerate(zip(world.inputs, world.pose, strict=True)):
        delayed, _ = advance(estimator, delayed, known, MEMORY_S)
        waiting.append(LateSample(known.t_ns, pose))
        if i % 20 == 19:  # two at a time out of order, the rest in order
            waiting[0], waiting[1] = waiting[1], waiting[0]
            for sample in waiting:
                delayed, estimate = use_late(estimator, delayed, (sample,))
                assert estimate is not None
            waiting.clear()
    assert delayed.state.mean.tobytes() == straight.state.mean.tobytes()
    assert delayed.refused == 0


def test_late_samples_that_are_too_old_or_known_are_refused() -> None:
    world = simulate(SETTINGS, 11, 120)
    estimator = Estimator(CONTACT, WEIGHT_N)
    memory = EstimatorMemory(estimator.initial())
    late = [
        LateSample(known.t_ns, pose) for known, pose in zip(world.inputs, world.pose, strict=True)
    ]
    for known, sample in zip(world.inputs, late, strict=True):
        memory, _ = advance(estimator, memory, replace(known, pose_W=sample.pose_W), MEMORY_S)
    before = memory.state.mean.tobytes()
    for sample in (late[10], late[-5], replace(late[-1], t_ns=late[-1].t_ns + 1)):
        memory, estimate = use_late(estimator, memory, (sample,))
        assert estimate is None
    assert memory.refused == 3
    assert memory.state.mean.tobytes() == before


def test_an_absolute_pose_holds_the_estimate_also_across_half_a_turn() -> None:
    world = simulate(SETTINGS, 12, 200)
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial(np.array([0.0, 0.0, np.pi - 0.05]))
    state.covariance[:3, :3] = np.diag([0.01, 0.01, 0.01])
    for known, pose in zip(world.inputs, world.pose, strict=True):
        yaw = (pose[2] + 2 * np.pi) % (2 * np.pi) - np.pi  # half a turn on, as a camera says it
        seen = np.array([-pose[0], -pose[1], yaw])
        state, estimate = estimator.step(state, replace(known, pose_W=seen))
    assert estimate.yaw_rad == pytest.approx(world.pose[-1, 2] + np.pi, abs=0.005)
    np.testing.assert_allclose(estimate.position_m, -world.pose[-1, :2], atol=0.003)
    assert np.sqrt(np.diag(estimate.pose_covariance)).max() < 0.005


def test_a_pose_that_stays_elsewhere_is_believed_in_the_end() -> None:
    world = simulate(SETTINGS, 12, 100)
    estimator = Estimator(CONTACT, WEIGHT_N)
    state = estimator.initial()
    off = []
    for known, pose in zip(world.inputs, world.pose, strict=True):
        seen = pose + np.array([0.5, 0.0, 0.0])
        state, estimate = estimator.step(state, replace(known, pose_W=seen))
        off.append(abs(estimate.position_m[0] - seen[0]))
    assert min(off[:10]) > 0.4
    assert off[-1] < 0.1


def test_a_gyro_makes_the_yaw_rate_better_known() -> None:
    world = simulate(SETTINGS, 13, 200)
    with_gyro = [
        replace(known, yaw_rate_rad_s=float(v[2]))
        for known, v in zip(world.inputs, world.velocity, strict=True)
    ]
    one, other = run(list(world.inputs))[1][-1], run(with_gyro)[1][-1]
    assert other.twist_covariance[2, 2] < one.twist_covariance[2, 2]


def test_at_standstill_a_gyro_tells_its_bias() -> None:
    """Nothing moves, so what it reports is its bias; that walks, so its sd ends above that of a mean."""
    feet = FootMotion(feet_at(0.0).position_m, np.zeros((6, 3)))
    draw = np.random.default_rng(5)
    inputs = [
        OdometryInputs(i * PERIOD_NS, feet, yaw_rate_rad_s=0.013 + 0.002 * draw.normal())
        for i in range(500)
    ]
    said = run(inputs)[1]
    assert said[-1].holding
    assert said[-1].yaw_rad == pytest.approx(0, abs=1e-4)
    error = said[-1].gyro_bias_rad_s - 0.013
    assert abs(error) < 3 * said[-1].gyro_bias_sd < 0.001
    assert SETTINGS.gyro_sd / np.sqrt(500) < said[-1].gyro_bias_sd
    silent = run([replace(known, yaw_rate_rad_s=np.nan) for known in inputs])[1][-1]
    assert np.isnan([silent.gyro_bias_rad_s, silent.gyro_bias_sd]).all(), "no gyro, no bias"


@pytest.mark.parametrize("wrong", [-1.0, 180 / np.pi])
def test_a_gyro_of_a_wrong_sign_or_unit_is_noticed(wrong: float) -> None:
    world = simulate(SETTINGS, 14, 300)
    turning = [  # the robot of these worlds hardly turns of itself: all feet move aside
        replace(known, feet=turned(known.feet, 0.15)) for known in world.inputs
    ]
    plain = [replace(known, forces=None) for known in turning]
    rates = [estimate.velocity_B[2] for estimate in run(plain)[1]]
    assert np.abs(rates[50:]).min() > 0.05
    for sign, health in ((1.0, Health.OK), (wrong, Health.DEGRADED)):
        heard = [
            replace(known, yaw_rate_rad_s=sign * float(rate))
            for known, rate in zip(plain, rates, strict=True)
        ]
        last = run(heard)[1][-1]
        assert last.health is health, last.reason
        assert ("gyro contradicts the feet" in last.reason) is (sign != 1.0)
        assert (last.rejects > 100) is (sign != 1.0)


def turned(feet: FootMotion, rate: float) -> FootMotion:
    """Feet that turn about the body's z axis against a yaw rate [rad/s]: the body turns by it."""
    velocity = feet.velocity_m_s.copy()
    velocity[:, 0] += rate * feet.position_m[:, 1]
    velocity[:, 1] -= rate * feet.position_m[:, 0]
    return FootMotion(feet.position_m, velocity)


def tilted_walk(true: FloatArray, offset: FloatArray) -> list[OdometryInputs]:
    """Six seconds without forces, with the roll and pitch of a robot of these parameters, askew."""
    inputs = []
    for i in range(600):
        feet = feet_at(i * PERIOD_NS * 1e-9)
        lifted = feet.position_m.copy()
        lifted[:, 2] -= 0.01 * np.sin(2 * np.pi * (0.4 * i * PERIOD_NS * 1e-9 + np.arange(6) / 3))
        feet = FootMotion(lifted, feet.velocity_m_s)
        slope = solved(true, feet).pose
        roll, pitch = np.arctan(slope[[1, 0]]) + offset
        inputs.append(OdometryInputs(i * PERIOD_NS, feet, None, np.nan, float(roll), float(pitch)))
    return inputs


def test_tilt_tells_of_stiffness_and_of_how_the_imu_is_mounted() -> None:
    true = np.zeros(FIXED + 12)
    true[stiffness_of(6)] = [0.2, 0.1, 0, 0, -0.1, -0.2]
    offset = np.array([0.03, -0.02])
    states, said = run(tilted_walk(true, offset))
    errors = np.log(said[-1].stiffness / CONTACT.stiffness) - true[stiffness_of(6)]
    assert np.abs(errors - errors.mean()).max() < 0.05, (
        "what is common to all springs tilts nothing"
    )
    np.testing.assert_allclose(states[-1].mean[TILT_BIAS], offset, atol=2e-3)
    assert said[-1].health is Health.OK
    assert said[-1].rejects == 0
