"""Gaits of Python files: what is derived from them is right, and what is no gait is refused by its line."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gaits.catalog import make_gait
from gaits.gait import TURN, Gait
from gaits.limits import check_gait, frequency_limit
from gaits.plugin import PluginGait
from model.errors import ConfigError, GaitRefused
from model.values.parameters import PluginParameters, RobotParameters
from robot.config.gait_file import read_gait_file
from tests.gaits.test_phases import EXAMPLES, LEGS, OCTOPOD, ROBOT

OWN = read_gait_file(EXAMPLES / "own_gait.py")
SMOOTH = '''"""Turns evenly but for a sine."""
import numpy as np
class Smooth:
    frequency_hz = 0.1
    def __init__(self, legs):
        self.late = np.arange(legs.count) / legs.count
        self.side = np.sign(legs.shaft_position[:, 1])
    def angle(self, phase, steer):
        turn = 2 * np.pi * (phase[..., None] - self.late)
        return turn - (0.5 + 0.1 * steer * self.side) * np.sin(turn)
    def stance(self, phase):
        return (phase[..., None] - self.late) % 1.0 < 0.5
def make(legs):
    return Smooth(legs)
'''


def plugin(text: str = SMOOTH) -> PluginGait:
    return PluginGait(PluginParameters("smooth", "smooth.py", text), LEGS)


GAIT = plugin()


@given(st.floats(-1000, 1000), st.floats(-1, 1))
def test_slope_and_curvature_are_those_of_the_formula(phase: float, steer: float) -> None:
    motion = GAIT.motion(phase, steer)
    turn = TURN * (phase - np.arange(6) / 6)
    bend = 0.5 + 0.1 * steer * np.array([1, 1, 1, -1, -1, -1])
    assert motion.angle_rad == pytest.approx(turn - bend * np.sin(turn), abs=1e-9)
    assert motion.slope == pytest.approx(TURN * (1 - bend * np.cos(turn)), abs=1e-5)
    assert motion.curvature == pytest.approx(TURN**2 * bend * np.sin(turn), abs=1e-3)
    whole = GAIT.motion(phase + 1, steer).angle_rad - motion.angle_rad
    assert whole == pytest.approx(np.full(6, TURN), abs=1e-9)


def test_peaks_hold_at_any_steering_and_limit_the_frequency() -> None:
    slope, curvature = GAIT.peaks(0.0)
    assert slope == pytest.approx(TURN * 1.6, rel=1e-5)
    assert curvature == pytest.approx(TURN**2 * 0.6, rel=1e-5)
    highest = frequency_limit(GAIT, ROBOT.servo)
    check_gait(GAIT, highest, ROBOT.servo)
    with pytest.raises(GaitRefused):
        check_gait(GAIT, 1.001 * highest, ROBOT.servo)


def test_arrays_of_phases_give_arrays() -> None:
    phases = np.linspace(-1, 1, 12).reshape(3, 4)
    motion = GAIT.motion(phases, 0.2)
    assert motion.angle_rad.shape == motion.slope.shape == GAIT.stance(phases).shape == (3, 4, 6)
    assert motion.angle_rad[2, 1] == pytest.approx(GAIT.motion(float(phases[2, 1]), 0.2).angle_rad)


@pytest.mark.parametrize("robot", [ROBOT, OCTOPOD], ids=["bigant", "octopod"])
def test_the_example_fits_any_robot(robot: RobotParameters) -> None:
    gait: Gait = make_gait("own_gait", replace(robot, gaits=(*robot.gaits, OWN)))
    down = gait.stance(np.arange(720) / 720).sum(axis=1)
    assert down.min() >= robot.legs.count // 2
    assert gait.stance(gait.start_phase).sum() == down.max()
    assert frequency_limit(gait, robot.servo) > 0.2


def test_it_starts_in_the_middle_of_most_support() -> None:
    counts = GAIT.stance(np.linspace(0, 1, 7201)).sum(axis=1)
    assert GAIT.stance(GAIT.start_phase).sum() == counts.max()


def test_a_gait_goes_to_other_processes() -> None:
    assert pickle.loads(pickle.dumps(OWN)) == OWN


def test_a_corner_in_the_angle_is_too_much_for_the_servos() -> None:
    even = "turn - (0.5 + 0.1 * steer * self.side) * np.sin(turn)"
    corner = "turn + 0.5 * np.abs((turn / np.pi) % 2 - 1)"
    with pytest.raises(GaitRefused, match=r"servo\.max_acceleration"):
        check_gait(plugin(SMOOTH.replace(even, corner)), 0.1, ROBOT.servo)


SINE = "        return turn - (0.5 + 0.1 * steer * self.side) * np.sin(turn)"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("import numpy", "import numpyy", r"^smooth\.py, line 2: ModuleNotFoundError: No module"),
        ("def make(legs):", "def make(legs)", r"^smooth\.py, line 13: SyntaxError: expected ':'"),
        ("def make(", "def made(", r"^smooth\.py: has no function make\(legs\)"),
        ("return Smooth(legs)", "return Smooth()", r"^smooth\.py, line 14: TypeError: .*'legs'$"),
        ("return Smooth(legs)", "raise SystemExit(3)", r"^smooth\.py, line 14: SystemExit: 3"),
        ("frequency_hz = 0.1", "hz = 0.1", r"line 13: what make returns has no frequency_hz; it n"),
        ("frequency_hz = 0.1", "frequency_hz = 0", r"line 13: frequency_hz must be a number above"),
        ("frequency_hz = 0.1", "frequency_hz = '1'", r"line 13: .* must be a number above 0, not '1'"),
        ("def stance(", "def support(", r"line 13: what make returns has no stance"),
        ("legs.count) / legs.count", "5) / 5", r"line 10: ValueError: .*broadcast"),
        (SINE, "        return turn[..., :4]", r"line 8: phases of shape \(360,\) must give \(360, 6\)"),
        (SINE, "        return str(turn)", r"line 8: angle must give numbers"),
        (SINE, "        return turn * np.nan", r"line 8: angle is not finite \(leg HL, phase 0\.001"),
        (SINE, "        return 2 * turn", r"line 8: one cycle must turn each shaft by 2 pi, not by 12\.56"),
        (SINE, "        return turn % 6.2832", r"line 8: one cycle must turn each shaft by 2 pi"),
        (SINE, "        return turn + 0.2 * (turn % (2 * np.pi) < 1)", r"line 8: angle jumps by 0\.2000"),
        (SINE, "        return turn + 0.2 * (steer > 0.31)", r"line 8: angle jumps near steer 0\.3"),
        (SINE, "        return turn + np.random.random()", r"line 8: angle gave two answers"),
        (SINE, "        return turn + phase.mean() * 0.1 + 0 * turn", r"line 8: angle gave two answers"),
        ("% 1.0 < 0.5", "% 1.0", r"line 11: stance must give true or false, not float64"),
        ("% 1.0 < 0.5", "% 3.0 < 0.5", r"line 11: stance must be the same in every cycle"),
        ("return (phase[..., None]", "return 1 / 0 * (phase[..., None]", r"line 12: ZeroDivisionError"),
    ],
)  # fmt: skip
def test_what_is_no_gait_is_one_sentence_with_its_line(old: str, new: str, words: str) -> None:
    assert old in SMOOTH
    with pytest.raises(ConfigError, match=words) as caught:
        plugin(SMOOTH.replace(old, new))
    assert len(str(caught.value).splitlines()) == 1


def test_a_mistake_that_comes_later_is_named_by_its_line_too() -> None:
    sometimes = SMOOTH.replace("turn = 2", "assert not 0.1230 < phase.flat[0] < 0.1231; turn = 2")
    gait = plugin(sometimes)
    with pytest.raises(ConfigError, match=r"^smooth\.py, line 9: AssertionError"):
        gait.motion(0.12314, 0.0)
