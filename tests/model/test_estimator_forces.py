"""Predicted forces between filter and open loop: each alone where it is the nearer, always in balance."""

from dataclasses import replace

import numpy as np
import pytest

from model.estimator import force_blend
from model.estimator.filter import Estimator
from model.estimator.settings import RECORD_S, EstimatorSettings
from model.quasistatic.frame import solve_frame
from model.values.arrays import FloatArray
from model.values.estimate import ForceMemory, OdometryInputs
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from tests.model.estimator_world import CONTACT, PERIOD_NS, WEIGHT_N, feet_at, simulate

SETTINGS = EstimatorSettings()
DRAW = np.random.default_rng(7)
PLAIN = 0.05 * DRAW.normal(size=(6, 3))
FILTERED = PLAIN + 0.03 * DRAW.normal(size=(6, 3))
RECORDS = 5000  # five memories


def predict(
    memory: ForceMemory, measured: FloatArray | None, filtered: FloatArray, plain: FloatArray
) -> tuple[FloatArray, ForceMemory]:
    """Forces of a robot of weight 1, and what is known then."""
    predicted, apart, agree = np.empty(plain.shape), np.empty(2), np.empty(2)
    heard = filtered if measured is None else measured
    known = force_blend.blend_kernel(
        memory.apart, memory.agree, heard, measured is not None, filtered, plain, 1.0,
        RECORD_S / SETTINGS.learning_s, predicted, apart, agree,
    )  # fmt: skip
    return predicted, ForceMemory(apart, agree) if known else memory


def of_feet(
    memory: ForceMemory, feet: FootMotion, contact: ContactParameters, filtered: FloatArray
) -> FloatArray:
    """Forces over the weight of feet whose open loop the kernel solves itself, without a record."""
    predicted, apart, agree = np.empty((6, 3)), np.empty(2), np.empty(2)
    force_blend.forces_kernel(
        feet.position_m, feet.velocity_m_s, contact.stiffness, contact.mu, contact.anisotropy,
        WEIGHT_N, memory.apart, memory.agree, filtered, False, filtered, 0.0, predicted, apart, agree,
    )  # fmt: skip
    return predicted / WEIGHT_N


def learn(
    memory: ForceMemory, measured: FloatArray, filtered: FloatArray, plain: FloatArray
) -> ForceMemory:
    return predict(memory, measured, filtered, plain)[1]


def blended(memory: ForceMemory, filtered: FloatArray, plain: FloatArray) -> FloatArray:
    return predict(memory, None, filtered, plain)[0]


def after(measured: FloatArray, records: int = RECORDS) -> ForceMemory:
    memory = force_blend.at_start()
    for _ in range(records):
        memory = learn(memory, measured, FILTERED, PLAIN)
    return memory


@pytest.mark.parametrize("skew", [0.0, 0.4])
@pytest.mark.parametrize("t_s", [0.0, 0.7, 2.3])
def test_the_open_loop_is_the_public_model(t_s: float, skew: float) -> None:
    draw = np.random.default_rng(2)
    contact = ContactParameters(
        draw.uniform(1500, 3000, 6), draw.uniform(0.3, 0.9, 6), skew * draw.normal(size=(6, 2))
    )
    expected = solve_frame(feet_at(t_s), contact, WEIGHT_N)
    share = of_feet(force_blend.at_start(), feet_at(t_s), contact, FILTERED)
    np.testing.assert_allclose(
        WEIGHT_N * share[:, :2], expected.traction.force_B[:, :2], rtol=0, atol=1e-9
    )
    np.testing.assert_allclose(share[:, 2], FILTERED[:, 2])


def test_without_forces_the_prediction_is_the_open_loop() -> None:
    estimator = Estimator(CONTACT, WEIGHT_N, SETTINGS)
    state = estimator.initial()
    for i in range(100):
        feet = feet_at(i * PERIOD_NS * 1e-9)
        state, estimate = estimator.step(state, OdometryInputs(i * PERIOD_NS, feet))
        expected = solve_frame(feet, CONTACT, WEIGHT_N)
        assert expected.traction.force_B.any()
        np.testing.assert_allclose(
            estimate.force_B[:, :2], expected.traction.force_B[:, :2], rtol=0, atol=1e-9
        )
        np.testing.assert_allclose(
            estimate.force_B[:, 2], expected.support.load_n, rtol=0, atol=1e-9
        )


def test_before_anything_was_measured_the_open_loop_is_predicted() -> None:
    both = blended(force_blend.at_start(), FILTERED, PLAIN)
    np.testing.assert_array_equal(both[:, :2], PLAIN[:, :2])
    np.testing.assert_array_equal(both[:, 2], FILTERED[:, 2])


@pytest.mark.parametrize("part", [-0.5, 0.0, 0.3, 1.0, 1.7])
def test_what_is_predicted_goes_to_the_nearer_and_never_beyond(part: float) -> None:
    memory = after(PLAIN + part * (FILTERED - PLAIN))
    both = blended(memory, FILTERED, PLAIN)
    share = np.clip(part, 0, 1)
    expected = PLAIN + share * (FILTERED - PLAIN)
    # the last hundredth stays the open loop's: that they differ has to be seen first
    np.testing.assert_allclose(both[:, :2], expected[:, :2], atol=0.05 * 0.03)
    np.testing.assert_array_equal(both[:, 2], FILTERED[:, 2])
    if part <= 0:
        np.testing.assert_array_equal(both[:, :2], PLAIN[:, :2])


def test_axes_are_weighed_one_by_one() -> None:
    measured = PLAIN.copy()
    measured[:, 1] = FILTERED[:, 1]
    both = blended(after(measured), FILTERED, PLAIN)
    np.testing.assert_array_equal(both[:, 0], PLAIN[:, 0])
    np.testing.assert_allclose(both[:, 1], FILTERED[:, 1], atol=0.05 * 0.03)


def test_weights_are_the_least_squares_of_what_was_measured() -> None:
    """Of many noisy records: the weight at which the blend's residual is smallest, by numpy's solver."""
    draw, memory = np.random.default_rng(5), force_blend.at_start()
    rows: tuple[list[FloatArray], list[FloatArray]] = ([], [])
    for _ in range(400):
        plain = 0.05 * draw.normal(size=(6, 3))
        filtered = plain + 0.03 * draw.normal(size=(6, 3))
        measured = plain + 0.6 * (filtered - plain) + 0.02 * draw.normal(size=(6, 3))
        memory = learn(memory, measured, filtered, plain)
        rows[0].append((filtered - plain)[:, 0])
        rows[1].append((measured - plain)[:, 0])
    weight = np.linalg.lstsq(np.concatenate(rows[0])[:, None], np.concatenate(rows[1]))[0][0]
    share = memory.agree[0] / memory.apart[0]
    assert share == pytest.approx(weight, abs=0.02)
    assert share == pytest.approx(0.6, abs=0.05)


def test_feet_without_a_force_teach_nothing() -> None:
    nothing = np.full((6, 3), np.nan)
    before = after(FILTERED, 10)
    assert learn(before, nothing, FILTERED, PLAIN) is before
    assert learn(before, FILTERED, FILTERED, nothing) is before
    some = FILTERED.copy()
    some[2, 0], some[4] = np.nan, np.inf
    heard = [0, 1, 3, 5]
    one = learn(before, some, FILTERED, PLAIN)
    other = learn(before, FILTERED[heard], FILTERED[heard], PLAIN[heard])
    np.testing.assert_array_equal(one.apart, other.apart)
    np.testing.assert_array_equal(one.agree, other.agree)


def test_without_an_open_loop_the_filter_predicts_alone() -> None:
    ahead = feet_at(0.3).position_m + np.array([1.0, 0.0, 0.0])
    tipping = FootMotion(ahead, feet_at(0.3).velocity_m_s)
    nothing = np.full((6, 3), np.nan)
    np.testing.assert_array_equal(blended(after(PLAIN), FILTERED, nothing), FILTERED)
    np.testing.assert_allclose(of_feet(after(PLAIN), tipping, CONTACT, FILTERED), FILTERED)


def test_whatever_was_learned_the_forces_are_in_balance() -> None:
    known = replace(SETTINGS, parameter_sd=0.3)
    estimator = Estimator(CONTACT, WEIGHT_N, known)
    state = estimator.initial()
    between = 0
    for inputs in simulate(known, 61, 400).inputs:
        state, estimate = estimator.step(state, inputs)
        np.testing.assert_allclose(estimate.force_B[:, :2].sum(axis=0), 0, atol=1e-6)
        assert estimate.force_B[:, 2].sum() == pytest.approx(WEIGHT_N)
        share = state.forces.agree / (state.forces.apart + force_blend.PRIOR)
        between += bool(((share > 0.1) & (share < 1.0)).any())
    assert between > 100, "the filter's forces and the open loop's are both in what is predicted"
