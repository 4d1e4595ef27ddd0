"""The first-order low pass and its coefficient found from spectra."""

import numpy as np
import pytest

from model.errors import ModelError
from model.motion.low_pass import choose_gamma, low_pass

RATE_HZ = 100.0


def test_it_is_the_recursion() -> None:
    x = np.random.default_rng(0).normal(size=(50, 3))
    y = x.copy()
    for n in range(1, len(x)):
        y[n] = 0.3 * y[n - 1] + 0.7 * x[n]
    assert low_pass(x, 0.3) == pytest.approx(y)
    assert low_pass(x[:, 1], 0.3) == pytest.approx(y[:, 1])
    assert low_pass(x, 0.0) == pytest.approx(x)


def test_a_constant_passes_unchanged_from_the_first_sample() -> None:
    assert low_pass(np.full(20, 2.5), 0.9) == pytest.approx(2.5)


def test_a_gap_stays_a_gap_and_the_filter_begins_anew() -> None:
    x = np.arange(10.0)
    x[4:6] = np.nan
    y = low_pass(x, 0.5)
    assert np.isnan(y[4:6]).all()
    assert y[6] == x[6]
    assert np.isfinite(y[[0, 1, 2, 3, 6, 7, 8, 9]]).all()


@pytest.mark.parametrize("gamma", [0.0, 0.15, 0.5, 0.8])
def test_a_known_gamma_is_found_in_noise(gamma: float) -> None:
    rng = np.random.default_rng(3)
    predicted = rng.normal(size=(3000, 3)) * [0.2, 0.1, 0.4]
    measured = low_pass(predicted, gamma)
    measured += rng.normal(size=measured.shape) * 0.02 * measured.std(axis=0)
    assert choose_gamma(predicted, measured, RATE_HZ) == pytest.approx(gamma, abs=0.02)


def test_noise_between_the_harmonics_of_a_gait_does_not_mislead() -> None:
    time = np.arange(921) / RATE_HZ
    predicted = np.sign(np.sin(2 * np.pi * 0.98 * time)) * 0.05  # harmonics up to the top
    noise = np.random.default_rng(5).normal(0, 5e-4, len(time))
    measured = low_pass(predicted, 0.4) + noise
    assert choose_gamma(predicted, measured, RATE_HZ) == pytest.approx(0.4, abs=0.02)


def test_the_signals_need_not_be_in_step() -> None:
    rng = np.random.default_rng(4)
    predicted = rng.normal(size=6000)
    measured = low_pass(rng.normal(size=8000), 0.6)
    assert choose_gamma(predicted, measured, RATE_HZ) == pytest.approx(0.6, abs=0.03)


@pytest.mark.parametrize("gamma", [-0.1, 1.0, float("nan")])
def test_gamma_outside_its_range_is_refused(gamma: float) -> None:
    with pytest.raises(ModelError, match="below 1"):
        low_pass(np.zeros(5), gamma)


def test_signals_that_make_no_spectrum_are_refused() -> None:
    with pytest.raises(ModelError, match="at least 64"):
        choose_gamma(np.zeros(10), np.zeros(10), RATE_HZ)
    with pytest.raises(ModelError, match="2 predicted components but 3"):
        choose_gamma(np.zeros((99, 2)), np.zeros((99, 3)), RATE_HZ)
    with pytest.raises(ModelError, match="no frequency in common"):
        choose_gamma(np.zeros(99), np.ones(99), RATE_HZ)
    with pytest.raises(ModelError, match="without gaps"):
        choose_gamma(np.full(99, np.nan), np.zeros(99), RATE_HZ)
