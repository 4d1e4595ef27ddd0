"""The sliding body against motion worked out by hand."""

import numpy as np
import pytest

from gap.interfaces import Cause, Drive
from gap.machines.sliding_body.simulator import sliding_body
from tests.gap.bench_trials import slide_trial

G = 9.80665
T = np.arange(90) / 148.0


def coulomb_path(mu: float, start: float = 1.0) -> np.ndarray:
    stop = start / (mu * G)
    t = np.minimum(T, stop)
    s = start * t - 0.5 * mu * G * t**2
    return np.column_stack([0.8 * s, 0.6 * s])


def test_coulomb_friction_decelerates_by_mu_g() -> None:
    trial = slide_trial(coulomb_path(0.15))
    simulator = sliding_body([trial])
    seen = simulator.observe(trial)
    on = seen.weight[:, 0] > 0
    assert np.median(seen.values[on, 0]) == pytest.approx(0.15 * G, rel=1e-3)
    for drive in Drive:
        told = simulator.predict(trial, [Cause("coulomb_friction", (), (0.15,))], drive)
        inner = np.flatnonzero(on)[:-8]
        assert np.median(told[inner, 0]) == pytest.approx(0.15 * G, rel=1e-3)
        assert told[inner, 2] == pytest.approx(seen.values[inner, 2], abs=0.02)


def test_viscous_friction_decays_exponentially() -> None:
    rate = 0.2 * G
    path = np.column_stack([(1 - np.exp(-rate * T)) / rate, 0 * T])
    trial = slide_trial(path)
    simulator = sliding_body([trial])
    seen = simulator.observe(trial)
    on = seen.weight[:, 0] > 0
    for drive in Drive:
        told = simulator.predict(trial, (), drive)
        assert told[on, 2] == pytest.approx(seen.values[on, 2], rel=0.02)


def test_a_slope_pulls_downhill_and_neutral_is_nothing() -> None:
    trial = slide_trial(coulomb_path(0.15))
    simulator = sliding_body([trial])
    on = simulator.observe(trial).weight[:, 0] > 0
    base = simulator.predict(trial, (), Drive.MEASURED)
    tilted = simulator.predict(trial, [Cause("ground_slope", (), (0.02, 0.0))], Drive.MEASURED)
    assert np.median((tilted - base)[on, 0]) == pytest.approx(0.02 * G * 0.8, rel=1e-3)
    assert np.median((tilted - base)[on, 1]) == pytest.approx(0.02 * G * 0.6, rel=1e-3)
    for effect in simulator.effects[1:]:
        neutral = tuple(p.neutral for p in effect.parameters)
        same = simulator.predict(trial, [Cause(effect.name, (), neutral)], Drive.COMMAND)
        assert np.array_equal(same, simulator.predict(trial, (), Drive.COMMAND)), effect.name
