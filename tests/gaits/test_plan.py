"""Plans never jump: walking, tuning, steering, slowing, moving leg by leg, changing gait."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaits.catalog import make_gait
from gaits.gait import TURN, Gait, ShaftMotion
from gaits.moves import AIR_RAD, SMALLEST_MOVE_RAD, LegMoves, MovePace
from gaits.plan import Hold, Ramp, Walking
from model.values.arrays import FloatArray
from robot.config.robot_file import load_robot

ROBOT = load_robot().parameters
GAITS = {name: make_gait(name, ROBOT) for name in ("tripod", "metachronal")}
PACE = MovePace.of(ROBOT.servo)
pytestmark = pytest.mark.usefixtures("usual_pace")
MS = 1_000_000
angles = st.lists(st.floats(-30, 30), min_size=6, max_size=6).map(np.array)


def started(name: str, turns: int = 0, frequency_hz: float = 0.1) -> Walking:
    gait = GAITS[name]
    pose = gait.motion(gait.start_phase, 0.0).angle_rad + turns * TURN
    return Walking.begin(0, gait, pose, frequency_hz)


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(0.01, 9), st.integers(0, 10_000))
def test_a_ramps_integral_is_its_area(begin: float, end: float, rate: float, ms: int) -> None:
    ramp = Ramp(0, begin, end, rate)
    grid = np.linspace(0, ms * MS, 2001)
    area = np.trapezoid([ramp.value(int(t)) for t in grid], grid * 1e-9)
    assert ramp.integral(ms * MS) == pytest.approx(area, abs=1e-3)


@given(st.floats(0, 0.3), st.floats(0, 0.3), st.integers(0, 5000))
def test_retuning_never_jumps(first: float, second: float, ms: int) -> None:
    plan = started("tripod", frequency_hz=first)
    other = plan.retuned(ms * MS, second)
    assert other.phase(ms * MS) == pytest.approx(plan.phase(ms * MS))
    assert other.frequency.value(ms * MS) == pytest.approx(plan.frequency.value(ms * MS))
    assert other.frequency.value(ms * MS + 10**11) == pytest.approx(second)


def test_phase_comes_from_the_clock_not_from_counting() -> None:
    plan = started("tripod", frequency_hz=0.1)
    hour = plan.phase(3610 * 10**9) - plan.phase(10 * 10**9)
    assert hour == pytest.approx(360.0, abs=1e-9)


@pytest.mark.parametrize("name", sorted(GAITS))
@given(turns=st.integers(-50, 50))
def test_walking_begins_where_the_legs_are_at_rest(name: str, turns: int) -> None:
    gait = GAITS[name]
    pose = gait.motion(gait.start_phase, 0.0).angle_rad + turns * TURN
    angle, rate = started(name, turns).at(0)
    assert angle == pytest.approx(pose, abs=1e-9)
    assert rate == pytest.approx(np.zeros(6))


@pytest.mark.parametrize("name", sorted(GAITS))
@given(data=st.data())
def test_whatever_the_operator_does_nothing_jumps(name: str, data: st.DataObject) -> None:
    plan = started(name)
    events = {
        data.draw(st.integers(1, 399)): data.draw(
            st.one_of(
                st.tuples(st.just("tune"), st.floats(0.02, 0.2)),
                st.tuples(st.just("steer"), st.floats(-1, 1)),
                st.tuples(st.just("slow"), st.just(0.0)),
            )
        )
        for _ in range(6)
    }
    before, _ = plan.at(0)
    for tick in range(1, 400):
        t_ns = tick * 20 * MS
        kind, value = events.get(tick, ("", 0.0))
        if kind == "tune":
            plan = plan.retuned(t_ns, value)
        elif kind == "steer":
            plan = plan.steered(t_ns, value)
        elif kind == "slow":
            plan = plan.slowing(t_ns)
        angle, rate = plan.at(t_ns)
        assert np.abs(angle - before).max() < 0.02 * ROBOT.servo.max_speed
        assert np.isfinite(rate).all()
        before = angle


@pytest.mark.parametrize("name", sorted(GAITS))
def test_the_rate_is_the_slope_of_the_angle_also_while_steering(name: str) -> None:
    plan = started(name).steered(2000 * MS, 1.0)
    for t_ms in range(2003, 8000, 37):
        t_ns = t_ms * MS
        ahead, behind = plan.at(t_ns + 10_000)[0], plan.at(t_ns - 10_000)[0]
        assert plan.at(t_ns)[1] == pytest.approx((ahead - behind) / 2e-5, abs=0.02)


def test_slowing_comes_to_a_stop_in_half_a_second_at_the_papers_frequency() -> None:
    plan = started("tripod").slowing(5000 * MS)
    assert not plan.stopped(5490 * MS)
    assert plan.stopped(5500 * MS)
    assert plan.at(5500 * MS)[0] == pytest.approx(plan.at(9000 * MS)[0])


@given(angles, angles, st.floats(0.2, 4.0), st.floats(1.0, 60.0))
def test_one_leg_moves_at_a_time_within_the_servos_limits(
    begin: np.ndarray, end: np.ndarray, peak: float, most: float
) -> None:
    moves = LegMoves.sequence(0, begin, end, np.arange(6), MovePace(peak, most))
    times = np.linspace(0, moves.end_ns, 300).astype(int)
    rates = np.array([moves.at(int(t_ns))[1] for t_ns in times])
    gained = np.abs(np.diff(rates, axis=0))
    assert (gained <= 1.001 * most * 1e-9 * np.diff(times)[:, None] + 1e-9).all()
    for rate in rates:
        assert (np.abs(rate) > 1e-9).sum() <= 1
        assert np.abs(rate).max() <= peak * 1.001
    assert moves.at(0)[0] == pytest.approx(begin)
    assert moves.at(moves.end_ns)[0] == pytest.approx(end, abs=SMALLEST_MOVE_RAD)


@given(angles)
def test_standing_brings_the_feet_in_the_air_down_first_and_forward(begin: np.ndarray) -> None:
    moves = LegMoves.stand(0, begin, PACE)
    end, _ = moves.at(moves.end_ns)
    assert np.cos(end) == pytest.approx(np.ones(6)), "mid-stance, up to whole turns"
    offset = np.remainder(begin + np.pi, TURN) - np.pi
    in_air = np.abs(offset) > AIR_RAD
    assert (end[in_air] >= begin[in_air]).all()
    assert (np.abs(end - begin)[~in_air] <= AIR_RAD + 1e-9).all()
    if in_air.any() and (~in_air).any():
        moving = moves.stop_ns > moves.start_ns
        last_landing = moves.stop_ns[in_air].max()
        on_ground = ~in_air & moving
        assert (moves.start_ns[on_ground] >= last_landing).all()


@pytest.mark.parametrize("name", sorted(GAITS))
@given(begin=angles)
def test_the_start_pose_is_reached_the_short_way(name: str, begin: np.ndarray) -> None:
    gait = GAITS[name]
    moves = LegMoves.start(0, gait, begin, PACE)
    end, rate = moves.at(moves.end_ns)
    pose = gait.motion(gait.start_phase, 0.0).angle_rad
    assert np.cos(end - pose) == pytest.approx(np.ones(6))
    assert np.abs(end - begin).max() <= np.pi + 1e-9
    assert rate == pytest.approx(np.zeros(6), abs=1e-9)
    angle, _ = Walking.begin(moves.end_ns, gait, end, 0.1).at(moves.end_ns)
    assert angle == pytest.approx(end, abs=1e-9), "and walking goes on from there"


def test_holding_holds() -> None:
    angle, rate = Hold(np.arange(6.0)).at(123)
    assert angle.tolist() == [0, 1, 2, 3, 4, 5]
    assert rate.tolist() == [0] * 6


@given(
    st.sampled_from(sorted(GAITS)), st.integers(-3, 3), st.floats(0.02, 0.4), st.floats(-1, 1),
    st.integers(0, 20_000),
)  # fmt: skip
def test_goals_of_many_times_are_those_of_each_to_the_bit(
    name: str, turns: int, frequency_hz: float, steer: float, begin_ms: int
) -> None:
    straight = started(name, turns, frequency_hz)
    steered = straight.steered(7 * MS, steer)
    for plan in (straight, steered, steered.slowing(9000 * MS)):
        times = [(begin_ms + 11 * k) * MS + k for k in range(9)]
        goals = plan.rows(times)
        for k, t_ns in enumerate(times):
            angle_rad, rate_rad_s = plan.at(t_ns)
            assert goals.phase[k] == plan.phase(t_ns)
            assert goals.angle_rad[k].tobytes() == angle_rad.tobytes()
            assert goals.rate_rad_s[k].tobytes() == rate_rad_s.tobytes()


def test_a_gait_of_somebody_elses_code_is_asked_once_for_each_time() -> None:
    """It may have been written for one time alone."""
    plan = started("tripod")
    asked = SomebodysGait(plan.gait)
    goals = replace(plan, gait=asked).rows([0, 11 * MS])
    assert goals.angle_rad[1].tobytes() == plan.at(11 * MS)[0].tobytes()
    assert asked.phases == [plan.phase(0), plan.phase(11 * MS)]


class SomebodysGait:
    """A gait of somebody else's code."""

    def __init__(self, gait: Gait) -> None:
        self.name, self.start_phase = gait.name, gait.start_phase
        self._gait, self.phases = gait, list[FloatArray | float]()
        self.peaks, self.stance = gait.peaks, gait.stance
        self.frequency_hz = 0.1

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        self.phases.append(phase)
        return self._gait.motion(phase, steer)
