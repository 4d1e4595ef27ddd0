"""Gaits by tables: any touchdowns, duties and sweeps, and the paper's two exactly as they were."""

from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gaits.buehler import BuehlerClock
from gaits.catalog import gait_names, make_gait, make_gaits
from gaits.cubic import CubicClock
from gaits.gait import STEER_GAIN, TURN
from gaits.limits import STEERING, gait_peaks
from gaits.moves import AIR_RAD, LegMoves, MovePace
from model.errors import ConfigError
from model.values.parameters import BuehlerParameters, CubicParameters
from robot.config.robot_file import load_robot
from tests.robot.runs import CONFIG

ROBOT = CONFIG.parameters
LEGS = ROBOT.legs
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
OCTOPOD = load_robot(EXAMPLES / "octopod.toml").parameters
Clock: TypeAlias = BuehlerClock | CubicClock
KEPT = np.load(Path(__file__).with_name("motions_before_tables.npz"))


def lists(low: float, high: float) -> st.SearchStrategy[np.ndarray]:
    return st.lists(st.floats(low, high), min_size=6, max_size=6).map(np.array)


@st.composite
def clocks(draw: st.DrawFn) -> Clock:
    """A gait of any touchdowns, duties, sweeps and offsets."""
    common = (draw(lists(0, 1)), draw(lists(0.3, 2.5)), draw(lists(0.2, 0.85)), draw(lists(-1, 1)))
    if draw(st.booleans()):
        blend = draw(st.floats(0.01, 0.15))
        return BuehlerClock(BuehlerParameters("any", 0.1, *common, blend), LEGS)
    parameters = CubicParameters("any", 0.1, *common, cubic=draw(lists(0, 1)))
    try:
        return CubicClock(parameters, LEGS)
    except ConfigError as error:
        assume("turn backward" not in str(error))
        raise


@given(clocks(), st.floats(-20, 20), st.floats(-1, 1))
def test_one_cycle_is_one_turn(gait: Clock, phase: float, steer: float) -> None:
    here, later = gait.motion(phase, steer), gait.motion(phase + 1, steer)
    assert later.angle_rad - here.angle_rad == pytest.approx(np.full(6, TURN), abs=1e-6)


@given(clocks(), st.floats(-1, 1))
def test_angle_and_speed_are_continuous_and_speed_is_the_slope(gait: Clock, steer: float) -> None:
    phase = np.linspace(0, 1, 8001)
    step = phase[1]
    motion = gait.motion(phase, steer)
    slope, curvature = gait_peaks(gait)
    assert np.abs(np.diff(motion.angle_rad, axis=0)).max() <= slope * step * 1.001
    assert np.abs(np.diff(motion.slope, axis=0)).max() <= curvature * step * 1.001
    assert motion.slope.min() >= -1e-9, "no shaft turns backward"
    numeric = np.gradient(motion.angle_rad, phase, axis=0)
    assert np.abs(numeric - motion.slope)[1:-1].max() <= curvature * step * 1.01 + 1e-6


@given(clocks())
def test_peaks_are_the_peaks(gait: Clock) -> None:
    phase = np.linspace(0, 1, 20_001)
    for steer in STEERING:
        motion = gait.motion(phase, steer)
        slope, curvature = gait.peaks(steer)
        assert slope == pytest.approx(np.abs(motion.slope).max(), rel=1e-3)
        assert curvature >= np.abs(motion.curvature).max() * (1 - 1e-9)
        assert curvature == pytest.approx(np.abs(motion.curvature).max(), rel=0.02)


@given(clocks(), st.floats(-1, 1))
def test_each_leg_spends_its_duty_in_stance_and_sweeps_its_sweep(gait: Clock, steer: float) -> None:
    """Touchdown at its own phase, duty share of the cycle, sweep centred on the offset, less inside."""
    p = gait._parameters
    phase = (np.arange(4000) + 0.5) / 4000
    assert gait.stance(phase).mean(axis=0) == pytest.approx(p.duty, abs=5e-4)
    assert gait.stance(p.touchdown + 1e-6)[range(6), range(6)].all()
    assert not gait.stance(p.touchdown - 1e-6)[range(6), range(6)].any()
    side = np.array([1, 1, 1, -1, -1, -1])
    sweep = p.stance_sweep * (1 - STEER_GAIN * steer * side)
    begin = gait.motion(p.touchdown, steer).angle_rad[range(6), range(6)]
    middle = gait.motion(p.touchdown + p.duty / 2, steer).angle_rad[range(6), range(6)]
    end = gait.motion(p.touchdown + p.duty, steer).angle_rad[range(6), range(6)]
    # blends round the corners by less than a blend's share of the change of speed
    rounded = 0.0
    if isinstance(p, BuehlerParameters):
        rounded = float(np.abs((TURN - sweep) / (1 - p.duty) - sweep / p.duty).max()) * p.blend / 8
    assert end - begin == pytest.approx(sweep, abs=2 * rounded + 1e-6)
    inside = isinstance(p, CubicParameters) or p.duty.min() > p.blend
    if inside:
        assert middle == pytest.approx(p.offset, abs=1e-6)


@pytest.mark.parametrize("name", ["tripod", "metachronal"])
def test_the_papers_two_gaits_are_what_they_were(name: str) -> None:
    """Against numbers of the version in which both were written out by hand."""
    gait, phase = make_gait(name, ROBOT), KEPT["phase"]
    for steer in (0.0, 0.17, -1.0):
        motion = gait.motion(phase, steer)
        now = np.stack([motion.angle_rad, motion.slope, motion.curvature])
        assert now == pytest.approx(KEPT[f"{name} {steer:g}"], rel=1e-14, abs=1e-14)
        assert gait.peaks(steer) == pytest.approx(KEPT[f"{name} {steer:g} peaks"], rel=1e-14)
    assert (gait.stance(phase) == KEPT[f"{name} stance"]).all()
    assert [gait.frequency_hz, gait.start_phase] == KEPT[f"{name} frequency start"].tolist()


def test_the_octopod_ripples_and_waves() -> None:
    assert gait_names(OCTOPOD) == ("tripod", "metachronal", "ripple", "wave")
    phase = np.linspace(0, 1, 2001)[:-1] + 1e-5
    ripple, wave = (make_gait(name, OCTOPOD).stance(phase) for name in ("ripple", "wave"))
    assert set(ripple.sum(axis=1)) == {6}
    assert set(wave.sum(axis=1)) == {7}
    lifted = [int(np.flatnonzero(~row)[0]) for row in wave]
    assert [leg for leg, before in zip(lifted, [-1, *lifted], strict=False) if leg != before] == [
        *range(1, 8), 0
    ]  # fmt: skip


@pytest.mark.parametrize("after", gait_names(OCTOPOD))
@pytest.mark.parametrize("before", gait_names(OCTOPOD))
@given(stopped=st.floats(0, 1), turns=st.integers(-3, 3))
@settings(max_examples=8)
def test_between_two_gaits_the_feet_of_one_of_them_carry(
    before: str, after: str, stopped: float, turns: int
) -> None:
    """While legs move from where one gait stopped to where another begins, one pose's feet are all down."""
    gaits = {gait.name: gait for gait in make_gaits(OCTOPOD)}
    begin = gaits[before].motion(stopped + turns, 0.0).angle_rad
    moves = LegMoves.start(0, gaits[after], begin, MovePace.of(OCTOPOD.servo))
    down_before, down_after = _down(begin), _down(moves.end_rad)
    for t_ns in np.linspace(0, moves.end_ns, 120).astype(int):
        now = _down(moves.at(int(t_ns))[0])
        assert now[down_before].all() or now[down_after].all()


def _down(angle_rad: np.ndarray) -> np.ndarray:
    return np.abs(np.remainder(angle_rad + np.pi, TURN) - np.pi) <= AIR_RAD + 1e-9
