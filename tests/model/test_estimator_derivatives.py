"""The estimator's derivatives against differences, and what it stacks of a foot."""

from dataclasses import replace

import numpy as np
import pytest

from model.estimator import measurements as measure
from model.estimator import process
from model.estimator.kalman import MeasurementStack
from model.estimator.neighbourhood import neighbourhood
from model.estimator.process import ProcessStep
from model.estimator.settings import EstimatorSettings, record_of
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.values.arrays import FloatArray
from model.values.estimate import (
    FIXED,
    SCALE,
    VELOCITY,
    OdometryInputs,
)
from model.values.legs import FootMotion
from tests.model.estimator_world import (
    CERTAIN,
    CONTACT,
    WEIGHT_N,
    feet_at,
    slip_of_feet,
    solved,
)

SETTINGS = EstimatorSettings()
RECORD = record_of(SETTINGS, WEIGHT_N)


@pytest.mark.parametrize("law", FrictionLaw)
def test_neighbourhood_is_the_public_model_plus_sway(law: FrictionLaw) -> None:
    mean, feet = np.zeros(FIXED + 12), feet_at(1.3)
    settings = replace(SETTINGS, law=law, rest_speed=0.0, sway_step_s=0.001)
    without = record_of(replace(settings, sway=False), WEIGHT_N)
    found = neighbourhood(mean, feet, CONTACT, without)
    assert found is not None
    one = FootMotion(feet.position_m[None], feet.velocity_m_s[None])
    expected = solve_frames(one, CONTACT, WEIGHT_N, law=law)
    np.testing.assert_allclose(found.velocity_B, expected.velocity_B[0], atol=1e-9)
    np.testing.assert_allclose(found.load_n, expected.load_n[0], atol=1e-9)
    np.testing.assert_allclose(found.slip_B, expected.slip_B[0], atol=1e-9)
    with_sway = neighbourhood(mean, feet, CONTACT, record_of(settings, WEIGHT_N))
    assert with_sway is not None
    slopes = [
        solve_frames(
            FootMotion(one.position_m + h * one.velocity_m_s, one.velocity_m_s), CONTACT, WEIGHT_N
        ).pose[0]
        for h in (-1e-3, 1e-3)
    ]
    rate = (slopes[1] - slopes[0]) / 2e-3
    height = expected.pose[0, 2]
    np.testing.assert_allclose(
        with_sway.sway_B, [height * rate[0], -height * rate[1]], rtol=1e-6, atol=1e-12
    )


@pytest.mark.parametrize("law", FrictionLaw)
def test_process_jacobian_against_differences(law: FrictionLaw) -> None:
    record = record_of(replace(SETTINGS, law=law), WEIGHT_N)
    draw = np.random.default_rng(1)
    mean = 0.05 * draw.normal(size=FIXED + 12)
    mean[VELOCITY] = [0.02, 0.003, 0.3]
    feet = feet_at(0.7)

    def after(at: FloatArray) -> ProcessStep:
        return process.walking(at, CERTAIN, solved(at, feet, law), record, 0.01)

    analytic = after(mean).transition
    for i in range(len(mean)):
        step = np.zeros(len(mean))
        step[i] = 1e-3
        numeric = (after(mean + step).mean - after(mean - step).mean) / 2e-3
        # one-sided steps of 1 % inside, central ones here
        np.testing.assert_allclose(analytic[:, i], numeric, atol=3e-5, rtol=0.03)


def test_measurement_rows_against_differences() -> None:
    draw = np.random.default_rng(2)
    mean = 0.05 * draw.normal(size=FIXED + 12)
    mean[VELOCITY] = [0.03, 0.002, 0.1]
    feet = feet_at(2.0)
    share = np.column_stack([draw.normal(size=(6, 2)) * 0.05, np.full(6, 1 / 6)])
    every = np.ones(6, dtype=bool)
    absolute = OdometryInputs(0, feet, pose_W=np.array([1.0, 2.0, 0.3]))

    def measured(at: FloatArray) -> MeasurementStack:
        model = solved(at, feet)._replace(sway_B=solved(mean, feet).sway_B)
        pose = measure.pose_stack(at, absolute, SETTINGS)
        assert pose is not None
        forces = measure.feet_stack(
            measure.Belief(at, CERTAIN), share, feet, every, model, CONTACT.mu, RECORD
        )
        assert forces.rows.shape == (6 + 2 * 6 + 1, len(at))
        gyro = measure.gyro_stack(at, 0.2, 0.0, SETTINGS)
        tilts = measure.tilt_stacks(at, (0.01, -0.02), model, SETTINGS)
        stack = measure.stacked([forces, gyro, *tilts, pose])
        assert stack is not None
        return stack

    rows = measured(mean).rows
    for i in range(len(mean)):
        step = np.zeros(len(mean))
        step[i] = 1e-4
        up, down = (measured(mean + sign * step).innovation for sign in (1, -1))
        np.testing.assert_allclose(rows[:, i], (down - up) / 2e-4, atol=2e-3)


def test_no_force_row_touches_the_global_pose() -> None:
    feet, mean = feet_at(0.4), np.zeros(FIXED + 12)
    model = solved(mean, feet)
    mean[VELOCITY] = [0.02, 0, 0]
    share = np.full((6, 3), 1 / 6)
    every = np.ones(6, dtype=bool)
    stack = measure.feet_stack(
        measure.Belief(mean, CERTAIN), share, feet, every, model, CONTACT.mu, RECORD
    )
    assert len(stack.rows) == 6 + 2 * 6 + 1
    assert not stack.rows[:, :3].any()


def test_what_is_stacked_of_a_foot_and_with_what_noise() -> None:
    feet, mean = feet_at(0.4), np.zeros(FIXED + 12)
    mean[VELOCITY] = [0.02, 0, 0]
    model = solved(mean, feet)
    covariance = np.diag(np.full(len(mean), 1e-6))
    covariance[SCALE, SCALE] = 0.04
    share = np.full((6, 3), 1 / 6)
    share[1], share[4, 0] = np.nan, np.nan
    usable = np.array([True, True, False, True, True, True])
    stack = measure.feet_stack(
        measure.Belief(mean, covariance), share, feet, usable, model, CONTACT.mu, RECORD
    )
    # no load of leg 1; no friction of 1 and 4 (not heard), of 2 (not usable)
    assert stack.blocks.tolist() == [
        [0, 0, 0], [1, 0, 2], [2, 0, 3], [3, 0, 4], [4, 0, 5],
        [5, 1, 0], [7, 1, 3], [9, 1, 5], [11, -1, 0],
    ]  # fmt: skip
    slip = slip_of_feet(mean[VELOCITY], feet, model.sway_B)[3]
    pull = CONTACT.mu[3] / 6
    size = np.sqrt(slip @ slip + SETTINGS.creep_speed**2)
    np.testing.assert_allclose(stack.innovation[7:9], 1 / 6 + pull * slip / size, rtol=1e-12)
    x, y, _ = feet.position_m[3]
    turned = 0.5e-6 * (2 + x * x + y * y) / size**2
    flat = SETTINGS.force_sd**2 + SETTINGS.force_share_sd**2 * 2 / 36
    bent = pull**2 * (turned**2 + 0.5 * (0.04 + 1e-6) ** 2)
    np.testing.assert_allclose(stack.variance[7:9], flat + bent, rtol=1e-12)
    known = np.full(5, SETTINGS.load_sd**2)
    np.testing.assert_allclose(stack.variance[:5], known, rtol=1e-12)
    gates = [SETTINGS.gate_load] * 5 + [SETTINGS.gate_pair] * 3 + [np.inf]
    assert stack.gates.tolist() == gates
