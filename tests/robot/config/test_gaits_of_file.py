"""Tables ``[gait.NAME]`` of a robot file: any number, in their order, and what cannot be a gait."""

import numpy as np
import pytest

from gaits.catalog import default_gait, gait_names, make_gait
from gaits.gait import TURN
from model.errors import ConfigError
from model.values.parameters import BuehlerParameters, CubicParameters
from robot.config.robot_file import RobotConfig, load_robot, parse_robot

TEXT = load_robot().text
HEAD = TEXT[: TEXT.index("[gait.tripod]")]
RIPPLE = """
[gait.ripple]
kind = "phases"
frequency = 0.1
touchdown = [0.0, 0.3333, 0.6667, 0.5, 0.8333, 0.1667]
duty = 0.6667
stance_sweep = [1.5, 2.0, 1.5, 1.5, 2.0, 1.5]
"""


def robot(gaits: str) -> RobotConfig:
    return parse_robot(HEAD + gaits)


def test_a_file_may_have_one_gait_of_its_own() -> None:
    parameters = robot(RIPPLE).parameters
    assert gait_names(parameters) == ("ripple",)
    assert default_gait(parameters) == "ripple"
    gait = make_gait("ripple", parameters)
    turned = gait.motion(1.0, 0.0).angle_rad - gait.motion(0.0, 0.0).angle_rad
    assert turned == pytest.approx(np.full(6, TURN))


def test_gaits_keep_the_order_of_the_file() -> None:
    both = RIPPLE + TEXT[len(HEAD) :] + RIPPLE.replace("ripple", "a-third")
    assert gait_names(robot(both).parameters) == ("ripple", "tripod", "metachronal", "a-third")


def test_a_number_stands_for_all_legs_and_blend_for_the_buehler_clock() -> None:
    (cubic,) = robot(RIPPLE).parameters.gaits
    (clock,) = robot(RIPPLE + "blend = 0.05\noffset = 0.1\n").parameters.gaits
    assert isinstance(cubic, CubicParameters)
    assert isinstance(clock, BuehlerParameters)
    assert cubic.duty.tolist() == clock.duty.tolist() == [0.6667] * 6
    assert cubic.stance_sweep.tolist() == [1.5, 2.0, 1.5] * 2
    assert (cubic.offset.tolist(), cubic.cubic.tolist()) == ([0.0] * 6, [0.0] * 6)
    assert (clock.offset.tolist(), clock.blend) == ([0.1] * 6, 0.05)


def test_a_tripod_of_another_name_says_its_kind() -> None:
    tripod = TEXT[len(HEAD) : TEXT.index("[gait.metachronal]")]
    slow = tripod.replace("[gait.tripod]", '[gait.slow]\nkind = "tripod"').replace("0.1", "0.05", 1)
    named, usual = robot(tripod + slow).parameters.gaits[::-1]
    assert named.name == "slow"
    assert isinstance(named, BuehlerParameters)
    assert isinstance(usual, BuehlerParameters)
    assert (named.touchdown == usual.touchdown).all()


def test_a_robot_that_is_not_driven_has_no_gait() -> None:
    parameters = robot("").parameters
    assert parameters.gaits == ()
    with pytest.raises(ConfigError, match=r"gait: the robot file has no gait; add a table"):
        default_gait(parameters)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('kind = "phases"\n', "", r"^gait\.ripple\.kind: is missing; add it"),
        ('"phases"', '"gallop"', r"gait\.ripple\.kind: must be one of tripod, metachronal, phases"),
        ("0.1667]", "0.1667, 0.2]", r"gait\.ripple\.touchdown: must have 6 entries"),
        ("0.1667]", "1.1667]", r"gait\.ripple\.touchdown: must be shares of the cycle"),
        ("duty = 0.6667", "duty = 1.0", r"gait\.ripple\.duty: must be below 1"),
        ("duty = 0.6667", "duty = [0.5, 0.5]", r"gait\.ripple\.duty: must have 6 entries"),
        ("[1.5, 2.0,", "[1.5, -2.0,", r"gait\.ripple\.stance_sweep: must be above 0"),
        ("[1.5, 2.0,", "[1.5, 5.0,", r"gait\.ripple\.stance_sweep: full steering widens it to 6.5"),
        ("duty = 0.6667", "duty = 0.6667\nblend = 0.5", r"gait\.ripple\.blend: 0\.5 is longer"),
        ("duty = 0.6667", "duty = 0.6667\nblend = 0.1\ncubic = 0.1", "blend: and cubic exclude"),
        ("duty = 0.6667", "duty = 0.6667\ncubic = 2", r"gait\.ripple\.cubic: must be at most 1"),
        ("duty = 0.6667", "duty = 0.6667\noffset = 4", r"gait\.ripple\.offset: must be below"),
        ("duty = 0.6667", "dutty = 0.6667", r"gait\.ripple\.duty: is missing; is 'dutty' meant"),
        ("duty = 0.6667", "duty = 0.2\ncubic = 1.0", r"ripple\.stance_sweep: the shaft would turn back"),
        ("gait.ripple", 'gait."my ripple"', r"gait\.my ripple: must be named by letters"),
    ],
)  # fmt: skip
def test_what_cannot_be_a_gait_is_refused_by_name(old: str, new: str, words: str) -> None:
    assert old in RIPPLE
    with pytest.raises(ConfigError, match=words):
        robot(RIPPLE.replace(old, new))
