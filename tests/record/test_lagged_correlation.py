"""Lags between signals: known ones recovered within what is said of them, whatever the loudness."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from model.values.arrays import FloatArray
from record.trial.lagged_correlation import best_lag, likeness_at

PERIOD_S = 0.01


def wandering(rng: np.random.Generator, count: int, smooth: float = 8.0) -> FloatArray:
    return gaussian_filter1d(rng.normal(size=count), smooth)[:, None]


def test_known_lags_lie_within_the_stated_uncertainty() -> None:
    """Errors in units of the stated deviation: of 200 draws their RMS is near 1, and none is far off."""
    rng, errors = np.random.default_rng(0), []
    for _ in range(200):
        whole = wandering(rng, 1400)
        later = int(rng.integers(-60, 60))
        x = whole[100:1300] + rng.normal(0, 0.03, (1200, 1))
        y = 3 * whole[100 - later : 1300 - later] + rng.normal(0, 0.09, (1200, 1)) + 5
        lag = best_lag(x, y, PERIOD_S, 2.0, 0.5)
        assert lag.correlation > 0.5
        errors.append((lag.seconds - later * PERIOD_S) / lag.sd_s)
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.6
    assert np.abs(errors).max() < 5


def test_the_likeness_at_the_best_lag_is_that_of_the_best_lag() -> None:
    rng = np.random.default_rng(4)
    whole = np.hstack([wandering(rng, 900), wandering(rng, 900)])
    x, y = whole[60:860] + rng.normal(0, 0.05, (800, 2)), whole[40:840].copy()
    y[200:240, 1] = np.nan
    best = best_lag(x, y, PERIOD_S, 2.0, 0.5)
    assert best.seconds == pytest.approx(0.2, abs=0.005)
    assert likeness_at(x, y, 20) == pytest.approx(best.correlation, abs=1e-9)
    assert likeness_at(x, y, -20) < best.correlation
    assert np.isnan(likeness_at(x, np.ones((800, 2)), 0))


def test_a_loud_stretch_does_not_draw_the_lag_to_itself() -> None:
    """Sums of products peak where the louder part of one signal lies over all of the other."""
    time_s = np.arange(0, 8, PERIOD_S)
    quiet = np.sin(2 * np.pi * time_s / 3.1) + 0.3 * np.sin(2 * np.pi * time_s / 0.7)
    signal = (np.where(time_s > 6, 6.0, 1.0) * quiet)[:, None]
    lag = best_lag(signal, signal, PERIOD_S, 1.5, 0.5)
    assert lag.seconds == pytest.approx(0.0, abs=1e-9)
    assert lag.correlation == pytest.approx(1.0)
    assert lag.correlation <= 1.0 + 1e-12


def test_holes_and_columns_without_numbers_are_left_out() -> None:
    rng = np.random.default_rng(1)
    whole = wandering(rng, 1200)
    x, y = whole[50:1150], whole[20:1120].copy()
    y[300:420] = np.nan
    nothing = np.full((1100, 1), np.nan)
    lag = best_lag(np.hstack([x, nothing]), np.hstack([y, x]), PERIOD_S, 2.0, 0.5)
    assert lag.seconds == pytest.approx(0.3, abs=1e-3)
    assert np.isnan(best_lag(nothing, y, PERIOD_S, 2.0, 0.5).seconds)
    assert np.isnan(best_lag(np.ones((1100, 1)), y, PERIOD_S, 2.0, 0.5).correlation)


def test_a_periodic_motion_has_a_rival_a_period_later_and_one_with_a_beginning_has_none() -> None:
    time_s = np.arange(0, 30, PERIOD_S)
    walking = np.sin(2 * np.pi * time_s)
    noise = np.random.default_rng(2).normal(0, 0.05, (2, len(time_s)))
    for_ever = best_lag(
        (walking + noise[0])[:, None], (walking + noise[1])[:, None], PERIOD_S, 5.0, 0.5
    )
    periods = abs(for_ever.rival_s - for_ever.seconds)
    assert round(periods) >= 1
    assert periods == pytest.approx(round(periods), abs=0.02)
    assert for_ever.sigmas < 3
    begun = walking * ((time_s > 7) & (time_s < 25))
    once = best_lag((begun + noise[0])[:, None], (begun + noise[1])[:, None], PERIOD_S, 5.0, 0.5)
    assert once.seconds == pytest.approx(0.0, abs=0.01)
    assert once.sigmas > 20
