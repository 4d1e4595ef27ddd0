"""Play of gears, and passes through the stages of a walk, against what they should be by hand."""

import numpy as np
import pytest

import gap.machines.legged.passes as passes
from gap.interfaces import Drive
from gap.machines.legged.chain import LeggedChain
from model.effects.gear_play import FALL_WINDOW_S, SLIP_KNOWN_TO_M_S, crossing_speed, in_play
from model.effects.grid import make_grid
from model.effects.signals import FootSignals
from tests.gap.predictions import COULOMB, Prediction
from tests.gap.walks import cause, walk

FRAMES = 500
GRID = make_grid(0.02 * np.arange(FRAMES, dtype=np.float64))
PUSHED = np.where(np.arange(FRAMES) < 250, -0.1, 0.1)[:, None]  # N m


def test_a_free_shaft_goes_to_the_flank_that_its_load_drives_it_to() -> None:
    place = in_play(GRID, PUSHED, np.array([0.04]), None)[:, 0]
    assert np.allclose(place[:230], -0.02)
    assert np.allclose(place[270:], 0.02)
    assert np.all(np.diff(place) >= -1e-12)


def test_a_strut_crosses_no_faster_than_its_foot_would_slip() -> None:
    speed = np.full((FRAMES, 1), 0.02)  # rad/s: two seconds for the width
    place = in_play(GRID, PUSHED, np.array([0.04]), speed)[:, 0]
    assert np.diff(place).max() <= 0.02 * GRID.period_s + 1e-12
    margin = int(FALL_WINDOW_S / GRID.period_s)
    assert np.allclose(place[250 + 100 + margin :], 0.02)
    assert abs(place[250 + 50]) < 1e-3  # half way after half of the time


def test_the_mean_over_times_that_a_fall_may_have_keeps_the_width() -> None:
    """A step at a wrong time has its width by the blurred one, and less by a sharp one."""
    sharp = np.sign(PUSHED[:, 0]) * 0.02
    shifted = [np.roll(sharp, by) for by in range(-7, 8)]
    inside = slice(30, 470)
    blurred = in_play(GRID, PUSHED * 100.0, np.array([0.04]), None)[inside, 0]
    sizes = [float(blurred @ one[inside] / (blurred @ blurred)) for one in shifted]
    assert abs(np.mean(sizes) - 1.0) < 0.005
    assert np.mean([float(sharp[inside] @ one[inside]) for one in shifted]) < 0.99 * float(
        sharp[inside] @ sharp[inside]
    )


@pytest.mark.parametrize("chain", [False, True])
def test_the_speed_of_a_strut_is_that_of_slip_over_its_lever(chain: bool) -> None:
    slip = np.array([[[0.03, 0.0]], [[0.0, 0.0]], [[0.03, 0.0]]])
    load = np.array([[5.0], [5.0], [0.0]])
    slope, jacobian = np.tile([-0.05, 0.01], (3, 1, 1)), None
    if chain:
        jacobian = np.zeros((3, 1, 3, 1))
        jacobian[:, 0, :, 0] = -0.05, 0.0, 0.01
    feet = FootSignals(GRID.time_s[:3], np.zeros((3, 1)), np.zeros((3, 1, 3)), slope, jacobian)
    fastest = crossing_speed(feet, slip, load)[:, 0]
    least = SLIP_KNOWN_TO_M_S / 0.05
    assert np.allclose(fastest, [0.03 / 0.05 + least, least, np.inf])


@pytest.mark.parametrize("others", [(), ("servo_compliance",)])
def test_passes_settle_in_a_few_and_on_the_same_walk(
    monkeypatch: pytest.MonkeyPatch, others: tuple[str, ...]
) -> None:
    causes = [COULOMB, cause("inertia_lag", 0.02), *(cause(one, 0.01) for one in others)]
    count = 0
    run = LeggedChain._pass

    def counted(*args: object) -> object:
        nonlocal count
        count += 1
        return run(*args)  # type: ignore[arg-type]

    monkeypatch.setattr(LeggedChain, "_pass", counted)
    trial = walk("tripod", 0.2, 6.0, [COULOMB])
    some = Prediction(trial, causes, Drive.COMMAND)
    assert 1 < count <= 10  # halves of the way would take 17
    monkeypatch.setattr(passes, "CONVERGED", 1e-10)
    trial = walk("tripod", 0.2, 6.0, [COULOMB])
    longer = Prediction(trial, causes, Drive.COMMAND)
    for channel in ("shaft_error", "body_vx", "foot_x"):
        assert np.nanmax(np.abs(some[channel] - longer[channel])) < 1e-5, channel
