"""Filters against what they must do to ramps, exponentials and holes."""

import numpy as np
import pytest

from model.motion.filters import at_times, lagged, play

PERIOD_S = 0.02
TIME_S = PERIOD_S * np.arange(200)


def test_a_ramp_comes_late_by_the_time_constant() -> None:
    ramp = np.column_stack([0.3 * TIME_S, 1.0 - 2.0 * TIME_S])
    late = lagged(ramp, 0.1, PERIOD_S, ramping=True)
    assert late == pytest.approx(ramp - 0.1 * np.array([0.3, -2.0]))
    at_rest = lagged(ramp[:, 0], 0.1, PERIOD_S)
    assert at_rest == pytest.approx(0.3 * (TIME_S - 0.1 * (1.0 - np.exp(-TIME_S / 0.1))))


def test_without_a_time_constant_nothing_is_filtered_and_nothing_is_written() -> None:
    values = np.random.default_rng(0).normal(size=(20, 2, 3))
    values.setflags(write=False)
    assert np.array_equal(lagged(values, 0.0, PERIOD_S), values)
    assert lagged(values, 0.1, PERIOD_S).shape == values.shape


def test_play_drags_along_with_its_flanks() -> None:
    there_and_back = np.array([0.0, 0.5, 1.0, 0.8, 0.5, 0.0])
    assert play(there_and_back, 0.4, 0.0) == pytest.approx([0.0, 0.3, 0.8, 0.8, 0.7, 0.2])
    assert play(there_and_back, 0.4, 9.0)[0] == pytest.approx(0.2)


def test_other_times_are_between_samples_and_a_hole_touches_only_its_neighbours() -> None:
    time_s = np.array([0.0, 1.0, 2.0, 4.0])
    values = np.array([0.0, 10.0, np.nan, 40.0])
    found = at_times(time_s, values, np.array([-1.0, 0.25, 1.0, 1.5, 4.0, 9.0]))
    assert found == pytest.approx([0.0, 2.5, 10.0, np.nan, 40.0, 40.0], nan_ok=True)
    wide = at_times(time_s, np.stack([values, 2 * values], axis=1)[:, None], np.array([0.5]))
    assert wide == pytest.approx(np.array([[[5.0, 10.0]]]))
