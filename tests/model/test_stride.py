"""The step of a tick in one call against its parts one by one, and the quick proof of a covariance."""

from dataclasses import replace

import numpy as np
import pytest

from model.estimator import kalman
from model.estimator.filter import Estimator
from model.estimator.kalman import sound
from model.estimator.neighbourhood import neighbourhood, with_effects
from model.estimator.process import Beside, walking
from model.estimator.settings import EstimatorSettings, record_of
from model.estimator.stride import Moment, stride
from model.values.arrays import FloatArray
from model.values.estimate import FIXED, VELOCITY, AddedByEffects
from model.values.legs import FootMotion
from tests.model.estimator_world import CONTACT, WEIGHT_N, feet_at

SETTINGS = EstimatorSettings()
RECORD = record_of(SETTINGS, WEIGHT_N)
DRIFT = np.array([1e-8, 2e-7, 3e-7])


@pytest.mark.parametrize("effects", [False, True])
@pytest.mark.parametrize("t_s", [0.2, 1.1, 2.3])
def test_a_stride_is_its_parts_to_the_bit(t_s: float, effects: bool) -> None:
    draw, added = np.random.default_rng(8), None
    if effects:  # one of them takes the load from a foot
        load_n = np.array([0.3, -0.2, 0.0, 0.5, -1e3, 0.1])
        added = AddedByEffects(np.array([0.01, -0.002, 0.05]), load_n)
    start = Estimator(CONTACT, WEIGHT_N, SETTINGS).initial()
    mean = start.mean.copy()
    mean[VELOCITY], mean[FIXED:] = [0.03, -0.01, 0.1], 0.1 * draw.normal(size=12)
    state = replace(start, mean=mean, strain=np.array([1.0, 2.0, 3.0]))
    feet = feet_at(t_s)
    strode = stride(state, feet, CONTACT, RECORD, added, Moment(0.01, 1, DRIFT))
    assert strode is not None
    alone = with_effects(neighbourhood(mean, feet, CONTACT, RECORD), added)
    assert alone is not None
    for own, other in zip(strode.model, alone, strict=True):
        np.testing.assert_array_equal(own, other)
    if added is not None:
        plain = neighbourhood(mean, feet, CONTACT, RECORD)
        assert plain is not None
        np.testing.assert_allclose(
            alone.load_n, np.maximum(plain.load_n + added.load_n, 0.0), rtol=1e-15
        )
        np.testing.assert_allclose(alone.velocity_B, plain.velocity_B + added.velocity_B)
    beside = Beside(strode.apart.velocity_B, state.strain, DRIFT)
    step = walking(mean, state.covariance, alone, RECORD, 0.01, 1, beside)
    for own, other in zip(strode.step, step, strict=True):
        np.testing.assert_array_equal(own, other)
    assert not start.companions.apart.any(), "what was is not written to"


def test_a_robot_that_tips_takes_no_stride() -> None:
    state, feet = Estimator(CONTACT, WEIGHT_N, SETTINGS).initial(), feet_at(0.3)
    away = FootMotion(feet.position_m + np.array([1.0, 0.0, 0.0]), feet.velocity_m_s)
    assert stride(state, away, CONTACT, RECORD, None, Moment(0.01, 0, DRIFT)) is None


def lapack_says(covariance: FloatArray) -> bool:
    return bool(np.isfinite(covariance).all()) and kalman._cholesky()(covariance.T, clean=0)[1] == 0


@pytest.mark.parametrize("smallest", [1.0, 1e-3, 1e-8, 1e-14, 1e-17, 0.0, -1e-17, -1e-9, -1.0])
def test_the_quick_proof_says_what_lapack_says(smallest: float) -> None:
    draw = np.random.default_rng(2)
    for size in (1, 4, 25):
        turned = np.linalg.qr(draw.normal(size=(size, size)))[0]
        values = np.append(10 ** draw.uniform(-4, 0, size - 1), smallest)
        covariance = kalman.symmetric((turned * values) @ turned.T)
        assert sound(covariance) == lapack_says(covariance)
        if size > 1:
            for wrong in (np.nan, np.inf, -np.inf):
                covariance[size - 1, 0] = covariance[0, size - 1] = wrong
                assert not sound(covariance)
