"""Where in its cycle a machine is: from shafts that turn, from joints that swing, or not at all."""

import numpy as np
import pytest

from gap.machines.legged.gait_phase import gait_cycle

HZ = 0.625
TIME_S = np.arange(0.0, 14.0, 0.02)
NOTHING = np.full((len(TIME_S), 3), np.nan)


def swinging(begin: float, hz: float = HZ) -> np.ndarray:
    """Three joints that swing: one hardly, two by half a cycle apart."""
    angle = 2 * np.pi * (hz * TIME_S + begin)
    return np.column_stack(
        [0.01 * np.sin(angle), 0.3 + 0.4 * np.cos(angle), 0.35 * np.cos(angle + np.pi)]
    )


def test_shafts_that_turn_tell_it_from_the_start_of_the_run() -> None:
    turned = 0.3 * np.sin(2 * np.pi * HZ * TIME_S) + 2 * np.pi * HZ * TIME_S
    cycle = gait_cycle(TIME_S, np.column_stack([turned] * 3) + 1.0, NOTHING, HZ)
    np.testing.assert_allclose(cycle, turned / (2 * np.pi), atol=1e-12)
    np.testing.assert_allclose(  # without a frequency just so
        gait_cycle(TIME_S, np.column_stack([turned] * 3), NOTHING, np.nan), cycle, atol=1e-12
    )


@pytest.mark.parametrize("ways", [(1, 1, 1), (-1, -1, -1), (1, 1, -1), (1, -1, -1)])
def test_on_the_spot_shafts_turn_both_ways(ways: tuple[int, ...]) -> None:
    turned = 2 * np.pi * HZ * TIME_S
    cycle = gait_cycle(TIME_S, np.outer(turned, ways) + 0.4, NOTHING, HZ)
    most = 1.0 if sum(ways) >= 0 else -1.0
    np.testing.assert_allclose(cycle, most * HZ * TIME_S, atol=1e-12)


@pytest.mark.parametrize("begin", [0.0, 0.2, 0.7])
def test_joints_that_swing_tell_it_whenever_the_run_was_begun(begin: float) -> None:
    for command, shaft in ((swinging(begin), NOTHING), (NOTHING, swinging(begin))):
        cycle = gait_cycle(TIME_S, command, shaft, HZ)
        away = np.mod(cycle - (HZ * TIME_S + begin) + 0.5, 1.0) - 0.5
        assert np.abs(away).max() < 0.02
        assert cycle[-1] - cycle[0] == pytest.approx(HZ * TIME_S[-1])


def test_a_joint_that_nothing_moves_does_not_tell_it() -> None:
    command = np.column_stack([np.zeros(len(TIME_S)), swinging(0.3)])
    cycle = gait_cycle(TIME_S, command, np.full((len(TIME_S), 4), np.nan), HZ)
    away = np.mod(cycle - (HZ * TIME_S + 0.3) + 0.5, 1.0) - 0.5
    assert np.abs(away).max() < 0.02


def test_without_a_frequency_or_angles_it_is_not_known() -> None:
    assert np.isnan(gait_cycle(TIME_S, swinging(0.0), NOTHING, np.nan)).all()
    np.testing.assert_allclose(gait_cycle(TIME_S, NOTHING, NOTHING, HZ), HZ * TIME_S)
