"""Gaits: periodic, continuous, the right feet down, inside the servos' limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from gaits.buehler import BuehlerClock
from gaits.catalog import make_gait
from gaits.cubic import CubicClock
from gaits.gait import STEER_GAIN, TURN, Gait, ShaftMotion
from gaits.limits import check_gait, frequency_limit, gait_peaks
from model.errors import ConfigError, GaitRefused
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import BuehlerParameters, CubicParameters
from robot.config.robot_file import load_robot

ROBOT = load_robot().parameters
TRIPOD: Gait = make_gait("tripod", ROBOT)
METACHRONAL: Gait = make_gait("metachronal", ROBOT)
GAITS = pytest.mark.parametrize("gait", [TRIPOD, METACHRONAL], ids=lambda g: g.name)
(CLOCK,) = (one for one in ROBOT.gaits if isinstance(one, BuehlerParameters))
(CUBICS,) = (one for one in ROBOT.gaits if isinstance(one, CubicParameters))
SWEEP = {gait.name: float(gait.stance_sweep[0]) for gait in (CLOCK, CUBICS)}
GROUP_A = np.array([name in {"HL", "FL", "MR"} for name in ROBOT.legs.names])
LEFT, RIGHT = slice(0, 3), slice(3, 6)
phases = st.floats(-20, 20)
steers = st.floats(-1, 1)


@GAITS
@given(phase=phases, steer=steers)
def test_one_cycle_is_one_turn_exactly(gait: Gait, phase: float, steer: float) -> None:
    here, later = gait.motion(phase, steer), gait.motion(phase + 1, steer)
    assert later.angle_rad - here.angle_rad == pytest.approx(np.full(6, TURN), abs=1e-6)


@GAITS
@given(phase=phases, steer=steers)
@example(phase=0.0, steer=0.0)
@example(phase=1e9, steer=-1.0)
def test_one_phase_and_many_are_the_same_to_the_bit(gait: Gait, phase: float, steer: float) -> None:
    near = phase + np.linspace(
        0.0, 1.0, 41
    )  # touchdowns, lift-offs, and what is rounded beside them
    many = gait.motion(near, steer)
    for i, now in enumerate(near.tolist()):
        one = gait.motion(now, steer)
        for name in ("angle_rad", "slope", "curvature"):
            assert getattr(one, name).tobytes() == getattr(many, name)[i].tobytes()


@GAITS
@given(steer=steers)
def test_speed_is_the_slope_of_the_angle(gait: Gait, steer: float) -> None:
    phase = np.linspace(0, 2, 4001)
    motion = gait.motion(phase, steer)
    numeric = np.gradient(motion.angle_rad, phase, axis=0)
    bend = np.abs(motion.curvature).max() * (phase[1] - phase[0])
    assert np.abs(numeric - motion.slope)[1:-1].max() <= bend * 1.01 + 1e-6


@GAITS
@given(steer=steers)
def test_angle_and_speed_are_continuous(gait: Gait, steer: float) -> None:
    """C1 everywhere: no step of angle or speed beyond what slope and curvature allow."""
    phase = np.linspace(0, 1, 20_001)
    step = phase[1]
    motion = gait.motion(phase, steer)
    slope, curvature = gait_peaks(gait)
    assert np.abs(np.diff(motion.angle_rad, axis=0)).max() <= slope * step * 1.001
    assert np.abs(np.diff(motion.slope, axis=0)).max() <= curvature * step * 1.001


@GAITS
def test_peaks_are_the_peaks(gait: Gait) -> None:
    phase = np.linspace(0, 1, 50_001)
    for steer in (-1.0, 0.0, 1.0):
        motion = gait.motion(phase, steer)
        slope, curvature = gait.peaks(steer)
        assert slope == pytest.approx(motion.slope.max(), rel=1e-3)
        assert curvature == pytest.approx(np.abs(motion.curvature).max(), rel=1e-2)


@GAITS
@given(phase=phases)
def test_stance_is_within_the_sweep(gait: Gait, phase: float) -> None:
    sweep = SWEEP[gait.name]
    motion, stance = gait.motion(phase, 0.0), gait.stance(phase)
    offset = np.remainder(motion.angle_rad + np.pi, TURN) - np.pi
    assert (np.abs(offset[stance]) <= sweep / 2 + 0.06).all(), "up to the rounding of the corners"
    assert (np.abs(offset[~stance]) >= sweep / 2 - 0.06).all()


@given(phases)
def test_metachronal_has_exactly_two_feet_a_side_down_at_any_time(phase: float) -> None:
    stance = METACHRONAL.stance(phase)
    assert stance[LEFT].sum() == 2
    assert stance[RIGHT].sum() == 2


def test_metachronal_has_two_feet_a_side_down_at_the_switches_too() -> None:
    for sixth in range(-12, 13):
        stance = METACHRONAL.stance(sixth / 6)
        assert (stance[LEFT].sum(), stance[RIGHT].sum()) == (2, 2)


def test_metachronal_is_a_cubic_of_time_in_stance() -> None:
    duty = float(CUBICS.duty[0])
    phase = np.linspace(0.001, duty - 0.001, 200)
    angle = METACHRONAL.motion(phase, 0.0).angle_rad[:, 0]  # hind left: stance begins at phase 0
    cubic = np.polynomial.Polynomial.fit(phase, angle, 3)
    assert np.abs(cubic(phase) - angle).max() < 1e-9
    assert abs(cubic.convert().coef[3]) > 1, "and not less than a cubic"


def test_metachronal_wave_runs_from_hind_to_front() -> None:
    begins = []
    phase = np.linspace(0, 1, 3001)[:-1]
    stance = METACHRONAL.stance(phase)
    for leg in range(3):
        touchdown = stance[:, leg] & ~np.roll(stance[:, leg], 1)
        begins.append(phase[np.flatnonzero(touchdown)[0]])
    assert begins == pytest.approx([0, 1 / 3, 2 / 3], abs=1e-3)


@given(phases)
def test_tripod_always_stands_on_one_group(phase: float) -> None:
    stance = TRIPOD.stance(phase)
    assert stance[GROUP_A].all() or stance[~GROUP_A].all()


def test_buehler_clock_spends_its_duty_in_stance() -> None:
    phase = (np.arange(100_000) + 0.5) / 100_000
    assert TRIPOD.stance(phase).mean(axis=0) == pytest.approx(CLOCK.duty)


def test_without_blends_it_is_the_classical_clock() -> None:
    clock = BuehlerClock(replace(CLOCK, blend=0.0), ROBOT.legs)
    phase = np.linspace(0, 1, 1001)
    slope = clock.motion(phase, 0.0).slope
    sweep, duty = float(CLOCK.stance_sweep[0]), float(CLOCK.duty[0])
    slow, fast = sweep / duty, (TURN - sweep) / (1 - duty)
    assert set(np.round(np.unique(slope), 9)) == {round(slow, 9), round(fast, 9)}
    with pytest.raises(GaitRefused, match=r"servo\.max_acceleration"):
        check_gait(clock, 0.1, ROBOT.servo)


@GAITS
@given(phase=phases)
def test_steering_left_shortens_the_left_sweep(gait: Gait, phase: float) -> None:
    sweep = SWEEP[gait.name]
    grid = phase + np.linspace(0, 1, 2001)
    straight, left = gait.motion(grid, 0.0), gait.motion(grid, 1.0)
    stance = gait.stance(grid)
    for leg in range(6):
        ratio = np.ptp(_in_stance(left, stance, leg)) / np.ptp(_in_stance(straight, stance, leg))
        assert ratio == pytest.approx(1 - STEER_GAIN if leg < 3 else 1 + STEER_GAIN, abs=0.05)
    assert sweep * (1 + STEER_GAIN) < TURN


def _in_stance(motion: ShaftMotion, stance: BoolArray, leg: int) -> FloatArray:
    offset: FloatArray = np.remainder(motion.angle_rad[:, leg] + np.pi, TURN) - np.pi
    return offset[stance[:, leg]]


@given(phases, steers, st.floats(-1e-3, 1e-3))
def test_angles_are_continuous_in_steering(phase: float, steer: float, change: float) -> None:
    for gait in (TRIPOD, METACHRONAL):
        here, near = gait.motion(phase, steer), gait.motion(phase, steer + change)
        assert np.abs(near.angle_rad - here.angle_rad).max() < 2 * abs(change) + 1e-12


@GAITS
def test_the_highest_frequency_is_the_limit(gait: Gait) -> None:
    highest = frequency_limit(gait, ROBOT.servo)
    assert highest > 0.2
    check_gait(gait, highest, ROBOT.servo)
    with pytest.raises(GaitRefused, match=r"servo\.max_(speed|acceleration) allows"):
        check_gait(gait, highest * 1.001, ROBOT.servo)


def test_a_gait_that_is_too_fast_names_the_limit() -> None:
    with pytest.raises(GaitRefused) as caught:
        check_gait(TRIPOD, 1.0, ROBOT.servo)
    assert caught.value.limit == "servo.max_speed"
    assert caught.value.needed > caught.value.allowed == ROBOT.servo.max_speed


def test_an_unknown_gait_lists_the_choices() -> None:
    with pytest.raises(
        ConfigError, match=r"'gallop' is no gait of .*, which has tripod, metachronal$"
    ):
        make_gait("gallop", ROBOT)
    with pytest.raises(ConfigError, match="did you mean 'tripod'"):
        make_gait("tripd", ROBOT)
    with pytest.raises(ConfigError, match=r"has no gait; add a table \[gait.NAME\]"):
        make_gait("tripod", replace(ROBOT, gaits=()))


def test_parameters_that_make_no_gait_are_refused() -> None:
    with pytest.raises(ConfigError, match="longer than the shorter part"):
        BuehlerClock(replace(CLOCK, blend=0.5), ROBOT.legs)
    with pytest.raises(ConfigError, match="stay below a turn"):
        BuehlerClock(replace(CLOCK, stance_sweep=np.full(6, 5.5)), ROBOT.legs)
    with pytest.raises(ConfigError, match="turn backward"):
        CubicClock(
            replace(
                CUBICS,
                stance_sweep=np.full(6, 4.5),
                cubic=np.full(6, 1.0),
                duty=np.full(6, 0.3),
            ),
            ROBOT.legs,
        )


@GAITS
def test_a_gait_starts_where_most_feet_are_down(gait: Gait) -> None:
    counts = gait.stance(np.linspace(0, 1, 7201)).sum(axis=1)
    assert gait.stance(gait.start_phase).sum() == counts.max()
