"""The sequence of standing poses: still when it should be, one leg in the air, nothing too fast."""

import numpy as np

from gaits.limits import check_gait, frequency_limit
from gaits.standing_poses import MOVING, STANCE_RAD, StandingPoses
from robot.config.robot_file import load_robot

SERVO = load_robot().parameters.servo
GAIT = StandingPoses(6, rounds=2, heights=3)
STEPS = 2 * 6 * 4


def test_the_servos_can_follow() -> None:
    for seed in range(20):
        gait = StandingPoses(6, rounds=4, heights=3, seed=seed)
        check_gait(gait, gait.frequency_hz, SERVO)
        assert gait.frequency_hz <= frequency_limit(gait, SERVO)


def test_a_cycle_is_whole_turns_and_goes_on_without_a_jump() -> None:
    begin, end = GAIT.motion(0.0, 0.0).angle_rad, GAIT.motion(1.0, 0.0).angle_rad
    assert np.allclose(end - begin, 2 * 2 * np.pi)
    phase = np.linspace(0, 2, 40_001)
    angle = GAIT.motion(phase, 0.0).angle_rad
    assert np.abs(np.diff(angle, axis=0)).max() < GAIT.peaks(0.0)[0] * 2 / 40_000 * 1.01


def test_slope_and_curvature_are_derivatives() -> None:
    phase = np.linspace(0.001, 0.999, 997)
    h = 1e-7
    here, ahead = GAIT.motion(phase, 0.0), GAIT.motion(phase + h, 0.0)
    slope, bend = GAIT.peaks(0.0)
    assert np.abs((ahead.angle_rad - here.angle_rad) / h - here.slope).max() < 1e-3 * slope
    assert np.abs((ahead.slope - here.slope) / h - here.curvature).max() < 1e-2 * bend
    assert np.abs(here.slope).max() <= slope * (1 + 1e-9)
    assert np.abs(here.curvature).max() <= bend * (1 + 1e-9)


def test_at_the_end_of_each_step_all_rest_and_at_most_one_leg_is_up() -> None:
    step = np.arange(STEPS)
    held = GAIT.motion((step + (MOVING + 1) / 2) / STEPS, 0.0)
    assert (held.slope == 0).all()
    offset = np.abs(np.remainder(held.angle_rad + np.pi, 2 * np.pi) - np.pi)
    up = offset > np.pi / 2
    assert (up.sum(axis=1) <= 1).all()
    assert up.sum(axis=0).tolist() == [2 * 3] * 6, "each leg: rounds times heights"
    assert (offset[~up] <= STANCE_RAD + 1e-9).all()
    lifted = ~GAIT.stance((step + (MOVING + 1) / 2) / STEPS)
    assert (lifted | ~up).all(), "a leg that is up is not scheduled to stand"
