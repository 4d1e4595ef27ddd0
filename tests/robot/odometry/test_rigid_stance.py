"""Odometry of legs that do not slip: the twist that moves loaded feet least over the ground."""

import numpy as np

from model.values.legs import FootMotion
from robot.odometry.compare import _rigid_stance

TICKS, LEGS = 60, 6


def walk() -> tuple[FootMotion, np.ndarray, np.ndarray]:
    """Feet that move with a twist, which of them are loaded, and the twists, (T, 3)."""
    chance = np.random.default_rng(5)
    place = chance.uniform(-0.2, 0.2, (TICKS, LEGS, 3))
    twist = chance.normal(0.0, 0.3, (TICKS, 3))
    speed = np.zeros_like(place)
    speed[..., 0] = -(twist[:, None, 0] - twist[:, None, 2] * place[..., 1])
    speed[..., 1] = -(twist[:, None, 1] + twist[:, None, 2] * place[..., 0])
    return FootMotion(place, speed), chance.random((TICKS, LEGS)) > 0.5, twist


def test_feet_that_do_not_slip_give_the_twist_of_the_body() -> None:
    feet, loaded, twist = walk()
    velocity = _rigid_stance(feet, loaded)
    enough = loaded.sum(axis=1) >= 2
    assert 0 < enough.sum() < TICKS
    np.testing.assert_allclose(velocity[enough], twist[enough], atol=1e-9)
    assert np.isnan(velocity[~enough]).all()


def test_feet_that_slip_give_the_least_squares_and_unknown_ones_nothing() -> None:
    feet, loaded, _ = walk()
    feet.velocity_m_s[:] += np.random.default_rng(6).normal(0.0, 0.05, feet.velocity_m_s.shape)
    loaded[7] = True
    feet.position_m[7, 2] = np.nan
    velocity = _rigid_stance(feet, loaded)
    assert np.isnan(velocity[7]).all()
    tick = int(np.flatnonzero(loaded.sum(axis=1) == 4)[0])
    x, y = feet.position_m[tick, loaded[tick], :2].T
    nothing, one = np.zeros(4), np.ones(4)
    rows = np.vstack([np.column_stack([one, nothing, -y]), np.column_stack([nothing, one, x])])
    still = -feet.velocity_m_s[tick, loaded[tick], :2].T.ravel()
    expected = np.linalg.lstsq(rows, still, rcond=None)[0]
    np.testing.assert_allclose(velocity[tick], expected, rtol=1e-9)
