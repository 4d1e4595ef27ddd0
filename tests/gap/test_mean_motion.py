"""Mean velocities of the body: known from where cycles begin and end, whatever frames say."""

import numpy as np
import pytest

from gap.interfaces import Drive
from gap.machines.legged.grip import Windows
from gap.machines.legged.mean_motion import mean_noise, means_of
from tests.gap.predictions import Prediction
from tests.gap.walks import cause, simulator, walk

WINDOWS = Windows(np.array([0, 40, 100]), 1.0)


def test_each_window_has_its_mean() -> None:
    velocity = np.random.default_rng(1).normal(size=(100, 3))
    velocity[:10, 0] = np.nan
    velocity[40:80, 1] = np.nan
    means = means_of(WINDOWS, velocity)
    assert means[:40, 0] == pytest.approx(velocity[10:40, 0].mean())
    assert means[40:, 2] == pytest.approx(velocity[40:, 2].mean())
    assert np.isnan(means[40:, 1]).all(), "more than half of it is missing"


def test_the_noise_of_a_mean_is_that_of_its_ends() -> None:
    """A hundred samples a second of a place that is known to half a millimetre."""
    rng, sigma, seconds = np.random.default_rng(2), 5e-4, 10.0
    time_s = np.arange(round(100 * seconds) + 1) / 100
    slopes = [
        np.gradient(0.02 * time_s + rng.normal(0.0, sigma, len(time_s)), time_s).mean()
        for _ in range(300)
    ]
    expected = mean_noise(sigma, sigma, seconds)[0]
    assert np.std(slopes) == pytest.approx(expected, rel=0.6)
    assert expected < np.std(np.gradient(rng.normal(0.0, sigma, 1000), 0.01)) / 100


def test_a_turned_frame_of_markers_is_plain_in_the_mean_alone() -> None:
    """In each frame 0.05 rad of yaw are less than the noise of the body's velocity."""
    trial = walk("metachronal", 0.2, 20.0, [cause("pose_yaw_offset", 0.05)], noise_seed=1)
    names = [one.name for one in simulator().channels]
    seen = simulator().observe(trial)
    base = Prediction(trial, [], Drive.MEASURED)
    left = {n: seen.values[:, names.index(n)] - base[n] for n in ("body_vy", "mean_vy")}
    inside = slice(20, -20)
    in_noise = {
        name: abs(rest[inside].mean()) / seen.noise[0, names.index(name)]
        for name, rest in left.items()
    }
    assert in_noise["mean_vy"] > 5.0
    assert in_noise["body_vy"] < 1.0
