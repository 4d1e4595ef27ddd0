"""Play of gears, and passes through the stages of a walk, against what they should be by hand."""

import numpy as np
import pytest

import gap.machines.legged.passes as passes
from gap.interfaces import Drive
from gap.machines.legged.chain import LeggedChain, _without_zeros
from gap.search.candidates import away_starts
from model.effects.gear_play import (
    FALL_WINDOW_S,
    LOOSE_PUSH,
    SLACK_SHARE,
    SLIP_KNOWN_TO_M_S,
    Strut,
    in_play,
    strong_drag,
    strut_of,
)
from model.effects.grid import make_grid
from model.effects.settings import settings_of
from model.effects.signals import FootSignals
from tests.gap.predictions import COULOMB, Prediction
from tests.gap.walks import cause, machine, simulator, walk

FRAMES = 500
GRID = make_grid(0.02 * np.arange(FRAMES, dtype=np.float64))
PUSHED = np.where(np.arange(FRAMES) < 250, -0.1, 0.1)[:, None]  # N m


def test_a_free_shaft_goes_to_the_flank_that_its_load_drives_it_to() -> None:
    place = in_play(GRID, PUSHED, np.array([0.04]), None)[:, 0]
    assert np.allclose(place[:230], -0.02)
    assert np.allclose(place[270:], 0.02)
    assert np.all(np.diff(place) >= -1e-12)


def test_bearings_that_drag_hold_a_shaft_back_whichever_way_it_is_driven() -> None:
    driven = np.where(np.arange(FRAMES) < 250, 1.0, -1.0)[:, None].cumsum(axis=0)
    weight = np.full((FRAMES, 1), 0.02)  # N m, that would drive it on
    place = in_play(GRID, weight, np.array([0.04]), None, strong_drag(driven))[:, 0]
    assert np.allclose(place[:230], -0.02)
    assert np.allclose(place[270:], 0.02)
    assert np.allclose(in_play(GRID, weight, np.array([0.04]), None), 0.02)


def test_a_strut_crosses_no_faster_than_its_foot_would_slip() -> None:
    fastest = np.full((FRAMES, 1), 0.02)  # rad/s: two seconds for the width
    strut = Strut(np.zeros((FRAMES, 1)), np.zeros((FRAMES, 1)), fastest)
    place = in_play(GRID, PUSHED, np.array([0.04]), strut)[:, 0]
    assert np.diff(place).max() <= 0.02 * GRID.period_s + 1e-12
    margin = int(FALL_WINDOW_S / GRID.period_s)
    assert np.allclose(place[250 + 100 + margin :], 0.02)
    assert abs(place[250 + 50]) < 1e-3  # half way after half of the time


def test_a_strut_that_bears_nothing_moves_as_its_foot_stands() -> None:
    """Measured torques that are noise say nothing of the flank; where the shaft begins is not known."""
    torque, speed = 0.004 * np.sign(np.sin(np.arange(FRAMES)))[:, None], np.full((FRAMES, 1), 0.02)
    free = Strut(speed, np.full((FRAMES, 1), 0.005), np.full((FRAMES, 1), np.inf))
    place = in_play(GRID, torque, np.array([0.04]), free)[:, 0]
    assert abs(place[0]) < 0.003
    assert np.allclose(np.diff(place)[5:30], 0.02 * GRID.period_s)
    assert np.allclose(place[70:], 0.02)
    bears = Strut(speed, np.full((FRAMES, 1), 0.005), free.fastest_rad_s)
    pressed = in_play(GRID, torque - 0.1, np.array([0.04]), bears)[:, 0]
    assert np.allclose(pressed, -0.02)


def test_the_mean_over_times_that_a_fall_may_have_keeps_the_width() -> None:
    sharp = np.sign(PUSHED[:, 0]) * 0.02
    shifted = [np.roll(sharp, by) for by in range(-7, 8)]
    inside = slice(30, 470)
    blurred = in_play(GRID, PUSHED * 100.0, np.array([0.04]), None)[inside, 0]
    sizes = [float(blurred @ one[inside] / (blurred @ blurred)) for one in shifted]
    assert abs(np.mean(sizes) - 1.0) < 0.005


@pytest.mark.parametrize("chain", [False, True])
def test_the_speed_of_a_strut_is_that_of_slip_over_its_lever(chain: bool) -> None:
    slip = np.array([[[0.03, 0.0]], [[0.0, 0.0]], [[0.03, 0.0]]])
    load = np.array([[5.0], [5.0], [0.0]])
    slope, jacobian = np.tile([-0.05, 0.01], (3, 1, 1)), None
    if chain:
        jacobian = np.zeros((3, 1, 3, 1))
        jacobian[:, 0, :, 0] = -0.05, 0.0, 0.01
    feet = FootSignals(GRID.time_s[:3], np.zeros((3, 1)), np.zeros((3, 1, 3)), slope, jacobian)
    predicted = strut_of(feet, slip, load, measured=False)
    least = SLIP_KNOWN_TO_M_S / 0.05
    assert np.allclose(predicted.fastest_rad_s[:, 0], [0.03 / 0.05 + least, least, np.inf])
    assert not predicted.slack_nm.any()
    measured = strut_of(feet, slip, load, measured=True)
    assert np.allclose(measured.speed_rad_s[:, 0], [0.03 / 0.05, 0.0, 0.0])
    assert np.isinf(measured.fastest_rad_s).all()
    slack = SLACK_SHARE * 5.0 * np.hypot(0.05, 0.01)
    assert np.allclose(measured.slack_nm[:, 0], [slack, slack, 0.0])


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


def test_settings_of_a_walk_in_which_a_leg_hardly_pushes() -> None:
    play, slippery = (
        cause("gear_backlash", 0.04, legs=("ML",)),
        cause("foot_friction", 0.5, legs=("FL",)),
    )
    settings = settings_of([play, slippery], machine().names, machine().size)
    pushes = np.where(settings.each("gear_backlash")[0] > 0.0, LOOSE_PUSH, 1.0)
    loose = settings.without("gear_backlash").times("foot_friction", pushes)
    assert not loose.has("gear_backlash")
    assert settings.has("gear_backlash")
    places = dict(zip(machine().names.legs, loose.each("foot_friction")[0], strict=True))
    assert places.pop("ML") == LOOSE_PUSH
    assert places.pop("FL") == 0.5
    assert set(places.values()) == {1.0}
    alone = settings_of([slippery], machine().names, machine().size)
    assert settings.without("gear_backlash") == alone


def test_a_play_is_looked_for_at_its_usual_size() -> None:
    """A narrow one is crossed wherever noise says so, and looks unlike a wide one."""
    effect = next(one for one in simulator().effects if one.name == "gear_backlash")
    assert effect.curved
    ((start,),) = away_starts(effect)
    assert start == pytest.approx(2.0 * effect.parameters[0].spread)


def test_what_a_foot_bears_where_none_was_predicted_is_no_zero_of_its_load_cell() -> None:
    """A leg that is longer than drawn touches down early: its force decides the flank all the same."""
    force = np.array([[[0.3, 0.0, -0.6], [0.0, 1.0, 14.0], [0.0, 0.0, 0.5]]])
    load = np.array([[0.0, 0.0, 3.0]])
    kept = _without_zeros(force, load)
    assert np.array_equal(kept[0, 0], np.zeros(3))
    assert np.array_equal(kept[0, 1:], force[0, 1:])
