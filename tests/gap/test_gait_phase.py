"""Where in its cycle a machine is: from shafts that turn, from joints that swing, or not at all."""

import numpy as np
import pytest

from gap.data.gait_phase import gait_cycle

HZ = 0.625
TIME_S = np.arange(0.0, 14.0, 0.02)
NOTHING = np.full((len(TIME_S), 3), np.nan)


def swinging(begin: float, hz: float = HZ) -> np.ndarray:
    """Three joints that swing: one hardly, two by half a cycle apart."""
    angle = 2 * np.pi * (hz * TIME_S + begin)
    return np.column_stack(
        [0.01 * np.sin(angle), 0.3 + 0.4 * np.cos(angle), 0.35 * np.cos(angle + np.pi)]
    )


def turning(begin: float, hz: float = HZ) -> np.ndarray:
    """Three cranks that turn unevenly, each a third of a cycle behind the one before."""
    phase = hz * TIME_S[:, None] + begin - np.arange(3) / 3
    return np.asarray(2 * np.pi * phase + 0.6 * np.sin(2 * np.pi * phase) + 0.2)


@pytest.mark.parametrize("hz", [HZ, 0.125, 0.04])
@pytest.mark.parametrize("begin", [0.0, 0.2, 0.33, 0.71, 5.0])
def test_shafts_that_turn_tell_it_wherever_in_the_gait_the_run_was_begun(
    begin: float, hz: float
) -> None:
    for command, shaft in ((turning(begin, hz), NOTHING), (NOTHING, turning(begin, hz))):
        cycle = gait_cycle(TIME_S, command, shaft, hz)
        first = gait_cycle(TIME_S, turning(0.0), NOTHING, HZ)
        apart = cycle - np.interp(hz * TIME_S + begin, HZ * TIME_S, first)
        here = hz * TIME_S + begin < HZ * TIME_S[-1]
        off = np.mod(apart + 0.5, 1.0)[here] - 0.5
        # a run of half a cycle may not have the joint's zero
        assert np.abs(off).max() < (0.1 if hz == 0.04 else 1e-3)
        np.testing.assert_allclose(  # without a frequency just so
            gait_cycle(TIME_S, command, shaft, np.nan) if hz > 0.1 else cycle, cycle, atol=1e-12
        )


def test_it_begins_where_the_first_of_them_is_at_0() -> None:
    command = turning(0.4)
    at_zero = np.interp(2 * np.pi * np.arange(1, 8), command[:, 0], TIME_S)
    cycle = np.interp(at_zero, TIME_S, gait_cycle(TIME_S, command, NOTHING, HZ))
    np.testing.assert_allclose(cycle, np.round(cycle), atol=1e-3)
    back = gait_cycle(TIME_S, -command, NOTHING, HZ)
    np.testing.assert_allclose(back, -gait_cycle(TIME_S, command, NOTHING, HZ), atol=1e-9)


@pytest.mark.parametrize("ways", [(1, 1, 1), (-1, -1, -1), (1, 1, -1), (1, -1, -1)])
def test_on_the_spot_shafts_turn_both_ways(ways: tuple[int, ...]) -> None:
    turned = 2 * np.pi * HZ * TIME_S
    cycle = gait_cycle(TIME_S, np.outer(turned, ways) + 0.4, NOTHING, HZ)
    most = 1.0 if sum(ways) >= 0 else -1.0
    np.testing.assert_allclose(np.diff(cycle), most * HZ * np.diff(TIME_S), atol=1e-12)
    own = (
        (ways[0] * turned + 0.4) * ways[0] * most / (2 * np.pi)
    )  # the first joint's, all turn evenly
    np.testing.assert_allclose(np.mod(cycle - own + 0.5, 1.0), 0.5, atol=1e-9)


@pytest.mark.parametrize("begin", [0.0, 0.2, 0.7])
def test_joints_that_swing_tell_it_whenever_the_run_was_begun(begin: float) -> None:
    for command, shaft in ((swinging(begin), NOTHING), (NOTHING, swinging(begin))):
        cycle = gait_cycle(TIME_S, command, shaft, HZ)
        away = np.mod(cycle - (HZ * TIME_S + begin) + 0.5, 1.0) - 0.5
        assert np.abs(away).max() < 0.01
        assert cycle[-1] - cycle[0] == pytest.approx(HZ * TIME_S[-1])


def test_a_joint_that_nothing_moves_does_not_tell_it() -> None:
    command = np.column_stack([np.zeros(len(TIME_S)), swinging(0.3)])
    cycle = gait_cycle(TIME_S, command, np.full((len(TIME_S), 4), np.nan), HZ)
    away = np.mod(cycle - (HZ * TIME_S + 0.3) + 0.5, 1.0) - 0.5
    assert np.abs(away).max() < 0.01


def test_without_a_frequency_or_angles_it_is_not_known() -> None:
    assert np.isnan(gait_cycle(TIME_S, swinging(0.0), NOTHING, np.nan)).all()
    np.testing.assert_allclose(gait_cycle(TIME_S, NOTHING, NOTHING, HZ), HZ * TIME_S)
