"""Channels, and whitened residuals, by their definitions: written out with numpy's own functions."""

import numpy as np
import pytest

from gap.machines.legged.channels import to_channels
from gap.machines.legged.grip import Windows
from gap.residuals.whitening import Whitener
from model.effects.grid import DOWN, TWIST_WINDOW_S, Grid
from model.effects.signals import SensorSignals
from model.errors import GapError
from model.motion.se2 import turned
from model.values.arrays import FloatArray

LEGS, JOINTS = 3, 4


def averaged(values: FloatArray) -> FloatArray:
    """(1, 2, 1) / 4 at every second frame, the first and the last value held."""
    wide = np.concatenate([values[:1], values, values[-1:]])
    every: FloatArray = sum(w * wide[k : k + len(values)] for k, w in enumerate(DOWN))
    return every[::2]


@pytest.mark.parametrize("frames", [60, 61])
def test_every_channel_is_the_mean_of_its_signal(frames: int) -> None:
    draws = np.random.default_rng(frames)
    signals = SensorSignals(
        time_s=0.02 * np.arange(frames, dtype=np.float64),
        shaft_rad=draws.normal(size=(frames, JOINTS)),
        foot_m=draws.normal(size=(frames, LEGS, 3)),
        force_n=draws.normal(size=(frames, LEGS, 3)),
        body_m=draws.normal(size=(frames, 3)),
        body_rad=draws.normal(size=(frames, 3)),
    )
    signals.force_n[7, 1, 2] = np.nan
    command = draws.normal(size=(frames, JOINTS))
    grid = Grid(0.0, 0.02, frames, 0.01)
    rate = grid.slope(signals.body_m[:, :2], TWIST_WINDOW_S)
    velocity = turned(rate[:, 0], rate[:, 1], -signals.body_rad[:, 2])
    wide = np.column_stack([
        signals.shaft_rad - command, signals.foot_m.reshape(frames, -1), signals.force_n[..., 2],
        signals.body_m[:, 2], signals.body_rad[:, :2], signals.force_n[..., :2].reshape(frames, -1),
        *velocity, grid.slope(signals.body_rad[:, 2], TWIST_WINDOW_S), signals.force_n.sum(axis=1),
        np.cross(signals.foot_m, signals.force_n).sum(axis=1),
    ])  # fmt: skip

    grip = draws.normal(size=((frames + 1) // 2, LEGS))
    windows = Windows(np.array([0, 11, (frames + 1) // 2]), 1.0)
    channels = to_channels(grid, command, signals, windows, grip)

    even = averaged(wide)
    velocities = even[:, JOINTS + 6 * LEGS + 3 :][:, :3]
    up = even[:, JOINTS + 3 * LEGS :][:, :LEGS]
    pull = np.where(up + 1.0 >= 0.0, 0.0, up + 1.0)  # 1 N at least
    means = [np.broadcast_to(one.mean(axis=0), one.shape) for one in np.split(velocities, [11])]
    expected = np.column_stack([even, pull, np.concatenate(means), grip])
    np.testing.assert_allclose(channels, expected, rtol=1e-12, atol=1e-12)
    assert np.isnan(channels[:, JOINTS + 3 * LEGS + 1]).sum() == 2, "frame 7 counts in two of them"


def test_a_slope_is_that_of_the_parabola_through_each_window() -> None:
    grid = Grid(0.0, 0.02, 80, 0.01)
    values = np.random.default_rng(2).normal(size=80)
    half = grid.window(TWIST_WINDOW_S) // 2
    slopes = grid.slope(values, TWIST_WINDOW_S)
    for frame in (half, 40, 79 - half):
        window = slice(frame - half, frame + half + 1)
        fitted = np.polynomial.Polynomial.fit(grid.time_s[window], values[window], 2)
        assert slopes[frame] == pytest.approx(fitted.deriv()(grid.time_s[frame]), abs=1e-9)
    line = 3.0 - 2.0 * grid.time_s
    np.testing.assert_allclose(grid.slope(line, TWIST_WINDOW_S), -2.0, atol=1e-12)


def test_a_slope_over_more_than_there_is_says_so() -> None:
    grid = Grid(0.0, 0.02, 5, 0.01)
    with pytest.raises(GapError, match="5 frames are too few"):
        grid.slope(np.zeros(5), TWIST_WINDOW_S)


def test_whitened_is_what_counts_in_units_of_noise() -> None:
    draws = np.random.default_rng(3)
    basis = np.linalg.qr(draws.normal(size=(40, 3)))[0]
    gain = draws.uniform(0.5, 2.0, (40, 5))
    gain[:, 2] = gain[:6] = 0.0
    shrink = draws.uniform(size=(3, 5))
    expected = draws.normal(size=(40, 5))
    whitener = Whitener(expected, gain, basis, shrink, gain, np.ones(5))
    error = draws.normal(size=(40, 5))
    error[9, 0] = error[2, 1] = np.nan

    scaled = np.where(np.isfinite(error), error - expected, 0.0) * gain
    away = np.where(gain > 0, basis @ (shrink * (basis.T @ scaled)), 0.0)

    np.testing.assert_allclose(whitener.whiten(error), scaled - away, rtol=1e-12, atol=1e-12)
    assert not whitener.whiten(error)[gain == 0].any()


@pytest.mark.parametrize(
    ("rate_hz", "left", "given_back"), [(0.5, 0.97, 1.0), (1.0, 0.88, 1.0), (2.0, 0.58, 0.93)]
)
def test_what_two_windows_take_from_a_change_is_given_back(
    rate_hz: float, left: float, given_back: float
) -> None:
    grid = Grid(0.0, 0.02, 500, 0.01)
    turn = 2 * np.pi * rate_hz
    place = np.sin(turn * grid.time_s)[:, None]
    twice = grid.slope(grid.slope(place, TWIST_WINDOW_S), TWIST_WINDOW_S)
    more = grid.given_back(twice, TWIST_WINDOW_S, windows=2)
    for found, share in ((twice, left), (more, given_back)):
        size = np.polyfit(-(turn**2) * place[60:-60, 0], found[60:-60, 0], 1)[0]
        assert size == pytest.approx(share, abs=0.005)


def test_an_even_change_has_nothing_to_give_back() -> None:
    grid = Grid(0.0, 0.02, 100, 0.01)
    even = np.tile([0.3, -2.0], (100, 1))
    np.testing.assert_allclose(grid.given_back(even, TWIST_WINDOW_S, windows=2), even, atol=1e-12)
