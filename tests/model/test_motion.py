"""Dead reckoning and shaft speed from samples."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.motion.dead_reckoning import advance
from model.motion.differentiate import latest_rate
from model.values.tick import DeadReckoning

START = DeadReckoning(0, np.zeros(2), 0.0, np.full(3, np.nan), valid=False)
SECOND = 1_000_000_000


def test_straight_ahead() -> None:
    after = advance(START, np.array([0.1, 0.02, 0.0]), 2 * SECOND)
    assert after.position_m == pytest.approx([0.2, 0.04])
    assert after.valid


def test_a_circle_closes() -> None:
    velocity = np.array([0.1, 0.0, 2 * np.pi / 10])
    pose = START
    for tick in range(1, 11):
        pose = advance(pose, velocity, tick * SECOND)
    assert pose.position_m == pytest.approx([0, 0], abs=1e-12)
    assert pose.yaw_rad == pytest.approx(2 * np.pi)


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3, 3), st.integers(2, 40))
def test_many_small_steps_are_one_large_one(x: float, y: float, turn: float, steps: int) -> None:
    velocity = np.array([x, y, turn])
    pose = START
    for tick in range(1, steps + 1):
        pose = advance(pose, velocity, tick * SECOND // steps)
    whole = advance(START, velocity, (SECOND // steps) * steps)
    assert pose.position_m == pytest.approx(whole.position_m, abs=1e-6)


def test_an_unknown_velocity_holds_the_pose_and_says_so() -> None:
    there = advance(START, np.array([0.1, 0.0, 0.5]), SECOND)
    held = advance(there, np.full(3, np.nan), 2 * SECOND)
    assert (held.position_m == there.position_m).all()
    assert held.yaw_rad == there.yaw_rad
    assert not held.valid
    assert np.isnan(held.velocity_B).all()


def test_rate_of_a_ramp_through_missing_samples() -> None:
    t_ns = np.arange(11) * 10_000_000
    angle = np.column_stack([0.3 * t_ns * 1e-9, -2.0 * t_ns * 1e-9, t_ns * 0.0])
    angle[3, 0] = angle[7, 1] = np.nan
    angle[:, 2] = np.nan
    rate = latest_rate(t_ns, angle)
    assert rate[:2] == pytest.approx([0.3, -2.0])
    assert np.isnan(rate[2])


def test_rate_is_far_finer_than_one_encoder_count_a_period() -> None:
    t_ns = np.arange(11) * 10_000_000
    tick = 2 * np.pi / 4096
    errors = []
    for phase in np.linspace(0, 1, 50):
        angle = np.round((0.35 * t_ns * 1e-9) / tick + phase) * tick
        errors.append(latest_rate(t_ns, angle[:, None])[0] - 0.35)
    assert np.std(errors) < 0.01
