"""Slip that feet force on each other: none for a rigid motion, else what least squares leaves."""

import numpy as np

from model.traction.forced_slip import forced_slip
from model.values.arrays import FloatArray

RANDOM = np.random.default_rng(3)


def rigid(feet: FloatArray, velocity: FloatArray) -> FloatArray:
    """Foot velocities that no foot slips with while the body moves so."""
    turning = np.stack([-feet[..., 1], feet[..., 0]], axis=-1)
    speed: FloatArray = -(velocity[:, None, :2] + velocity[:, 2, None, None] * turning)
    return speed


def test_a_rigid_motion_is_found_and_forces_nothing() -> None:
    feet, velocity = RANDOM.normal(size=(50, 6, 2)), RANDOM.normal(size=(50, 3))
    down = RANDOM.random((50, 6)) < 0.6
    down[:, :2] = True
    answer = forced_slip(feet, rigid(feet, velocity), down)
    np.testing.assert_allclose(answer.velocity_B, velocity, atol=1e-12)
    np.testing.assert_allclose(answer.rms_m_s, 0, atol=1e-12)
    assert np.isnan(answer.slip_m_s[~down]).all()
    np.testing.assert_allclose(answer.slip_m_s[down], 0, atol=1e-12)


def test_else_it_is_what_least_squares_leaves() -> None:
    feet, speed = RANDOM.normal(size=(20, 5, 2)), RANDOM.normal(size=(20, 5, 2))
    down = RANDOM.random((20, 5)) < 0.7
    down[:, :3] = True
    answer = forced_slip(feet, speed, down)
    for frame in range(20):
        rows, right = [], []
        for (x, y), (vx, vy), stands in zip(feet[frame], speed[frame], down[frame], strict=True):
            if stands:
                rows += [[1, 0, -y], [0, 1, x]]
                right += [-vx, -vy]
        solved, *_ = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)
        np.testing.assert_allclose(answer.velocity_B[frame], solved, atol=1e-10)
        left = np.array(rows) @ solved - right
        rms = np.sqrt((left**2).sum() / down[frame].sum())
        np.testing.assert_allclose(answer.rms_m_s[frame], rms, atol=1e-10)


def test_one_foot_does_not_say_how_the_body_turns() -> None:
    answer = forced_slip(np.ones((1, 3, 2)), np.ones((1, 3, 2)), np.array([[True, False, False]]))
    assert np.isnan(answer.velocity_B).all()
    assert np.isnan(answer.rms_m_s).all()
