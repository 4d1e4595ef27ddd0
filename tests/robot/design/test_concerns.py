"""Wrong robot files are caught with their reason; healthy ones raise no alarm."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from model.errors import ConfigError
from record.chain_file import complete
from robot.config.robot_file import load_robot, parse_robot
from robot.design.concern import Concern, Severity
from robot.design.gait_concerns import gait_concerns
from robot.design.leg_places import FRONT, HIND, LEFT, MIDDLE, RIGHT, named_place
from robot.design.review import RobotReview, refuse_impossible, review_robot, warning_lines
from tests.robot.design.robot_files import OCTOPOD, robot_with, text_with
from tests.soaked import soaked


def moved(x: float = 0.0, y: float = 0.0) -> Callable[[Any], Any]:
    return lambda rows: [[row[0] + x, row[1] + y, row[2]] for row in rows]


def times(factor: float) -> Callable[[Any], Any]:
    def scaled(value: Any) -> Any:
        return [scaled(one) for one in value] if isinstance(value, list) else value * factor

    return scaled


def with_one(index: int, value: Any) -> Callable[[Any], Any]:
    return lambda values: [*values[:index], value, *values[index + 1 :]]


def of_all(value: Any) -> Callable[[Any], Any]:
    return lambda values: [value for _ in values]


def review(changes: dict[str, Any]) -> RobotReview:
    return review_robot(robot_with(changes))


LENGTHS = ("leg.crank", "leg.ground_pivot", "leg.coupler", "leg.rocker", "leg.foot")
SYMMETRIC = {"legs.shaft_position": moved(-0.085)}  # what a lab writes first: shafts about the body

# what is wrong, the topic that it is caught by, and what its line says
WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "feet behind the centre of mass": (SYMMETRIC, "tips", "+85 mm in x"),
    "feet ahead of it": ({"legs.shaft_position": moved(0.12)}, "tips", "-120 mm in x"),
    "the centre of mass beside all feet": (
        {"legs.shaft_position": moved(0.6)}, "falls", "-600 mm in x",
    ),
    "feet to the left of it": ({"legs.shaft_position": moved(y=0.2)}, "tips", "-200 mm in y"),
    "names of left and right swapped": (
        {"legs.order": ["HR", "MR", "FR", "HL", "ML", "FL"]}, "names",
        "leg HR (and MR, FR, HL, ML, FL) is right by its name and on the left",
    ),
    "names of front and hind swapped": (
        {"legs.order": ["FL", "ML", "HL", "FR", "MR", "HR"]}, "names", "leg FL should be ahead of ML",
    ),
    "one name in the wrong place": (
        {"legs.order": ["HL", "FL", "ML", "HR", "MR", "FR"]}, "names", "leg FL should be ahead of ML",
    ),
    "y points to the right": (
        {"legs.shaft_position": lambda rows: [[x, -y, z] for x, y, z in rows]}, "names",
        "y points to the left",
    ),
    "one leg out of place": (
        {"legs.shaft_position": with_one(4, [0.04, -0.25, 0.0])}, "asymmetric", "leg ML at x 85",
    ),
    "all legs on one side": (
        {"legs.order": list("ABCDEF"), "gait.tripod.group_a": ["A", "C", "E"],
         "legs.shaft_position": lambda rows: [[x + 0.01 * i, 0.25, z] for i, (x, _, z) in enumerate(rows)]},
        "asymmetric", "all legs are on the left",
    ),
    "one servo's sign": (
        {"legs.servo_sign": [1, 1, -1, -1, -1, -1]}, "signs",
        "FL: not the sign of the other legs on the left",
    ),
    "shafts in millimetres": ({"legs.shaft_position": times(1e3)}, "units", "500 mm would be 0.5 m"),
    "legs in millimetres": (dict.fromkeys(LENGTHS, times(1e3)), "units", "177 mm would be 0.177 m"),
    "all lengths in millimetres": (
        {**dict.fromkeys(LENGTHS, times(1e3)), "legs.shaft_position": times(1e3)}, "units", "lengths in m",
    ),
    "mass in grams": ({"body.mass": 6500.0}, "units", "6500 g would be 6.5"),
    "stiffness in N/mm": ({"contact.stiffness": of_all(2.5)}, "units", "give it in N/m"),
    "soft springs": ({"contact.stiffness": of_all(300.0)}, "too soft", "give it in N/m"),
    "springs like rock": ({"contact.stiffness": of_all(2.5e9)}, "too stiff", "rounding"),
    "friction in per cent": ({"contact.mu": of_all(60.0)}, "friction", "leg HL has 60"),
    "no friction": ({"contact.mu": of_all(0.001)}, "friction", "cannot push"),
    "inertia in kg cm^2": ({"body.inertia": [1000.0, 1400.0, 2200.0]}, "inertia", "kg m^2"),
    "inertia of a nut": ({"body.inertia": [1e-5, 1.4e-5, 2.2e-5]}, "inertia", "kg m^2"),
    "a sensor far away": (
        {"force_sensor.offset": with_one(2, [0.0, 60.0, 0.0])}, "sensor", "leg FL is 60 m from its shaft",
    ),
    "a short stance": ({"gait.tripod.duty": 0.4}, "leaps", "no foot is in stance"),
    "one side at a time": (
        {"gait.tripod.group_a": ["HL", "ML", "FL"]}, "tips", "let more feet stand at a time",
    ),
    "two legs of six": ({"gait.tripod.group_a": ["HL", "FR"]}, "too few feet", "only two feet"),
    "too heavy": ({"body.mass": 90.0, "contact.stiffness": of_all(35e3),
                   "body.inertia": [1.4, 1.9, 3.0]}, "saturates", "servo.rated_torque_limit"),
    "too fast": ({"gait.tripod.frequency": 0.6}, "saturates", "lower the frequency to 0.33"),
    "a sweep that never lifts": ({"gait.tripod.stance_sweep": 0.5}, "drags", "middle of their swing"),
    "mid-stance at the top": ({"leg.mid_stance": lambda v: v - np.pi}, "hangs", "check mid_stance"),
    "upside down": (
        {"leg.ground_pivot": lambda v: [v[0], -v[1]], "leg.branch": -1,
         "leg.foot": lambda v: [v[0], -v[1]], "leg.mid_stance": lambda v: -v}, "upside down", "z points up",
    ),
    "feet that cannot agree": (
        {"gait.metachronal.stance_sweep": 0.8}, "slides", "as far as the body walks",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_robot_file_is_caught_with_its_reason(case: str) -> None:
    changes, topic, words = WRONG[case]
    concerns = [one for one in review(changes).warnings if one.topic == topic]
    assert concerns, f"nothing of the kind: {review(changes).concerns}"
    assert any(words in one.line for one in concerns), concerns
    assert all(one.advice for one in concerns)


# Mistakes that leave the legs as they are: the first line that is printed names the cause.
FIRST = [
    case
    for case in WRONG
    if case not in {"all legs on one side", "mid-stance at the top", "too heavy",
                    "feet that cannot agree"}
]  # fmt: skip


@pytest.mark.parametrize("case", FIRST)
def test_the_first_warning_names_the_cause(case: str) -> None:
    changes, topic, _ = WRONG[case]
    assert review(changes).warnings[0].topic == topic


def test_what_no_body_can_be_is_refused_when_the_file_is_read() -> None:
    with pytest.raises(ConfigError, match="no rigid body"):
        robot_with({"body.inertia": [0.1, 0.1, 0.32]})


def test_a_robot_that_cannot_stand_is_refused() -> None:
    beside = review({"legs.shaft_position": moved(0.6)})
    assert beside.concerns[0].severity is Severity.IMPOSSIBLE
    with pytest.raises(ConfigError, match="falls over; move the shafts by -600 mm"):
        refuse_impossible(beside)
    refuse_impossible(review(SYMMETRIC))  # a warning is no refusal


def topics(concerns: tuple[Concern, ...]) -> list[str]:
    return [f"{one.place} {one.topic}" for one in concerns]


def test_the_nominal_robot_has_no_warning_and_a_gait_that_is_made_to_slip() -> None:
    nominal = review_robot(load_robot())
    assert topics(nominal.warnings) == []
    assert topics(nominal.concerns) == ["metachronal slips"]
    assert warning_lines(nominal) == []


def test_the_afternoon_with_a_symmetric_robot_would_have_taken_a_minute() -> None:
    """A lab's first file had its shafts symmetric about the body: feet 85 mm behind, and no warning."""
    first = review(SYMMETRIC).warnings[0]
    assert first.line == (
        "tripod tips: at phase 0.50 the centre of mass lies 11 mm outside the feet in stance, ahead: it "
        "tips until a swinging foot catches it; move the shafts by +85 mm in x (legs.shaft_position) or "
        "the centre of mass by -85 mm in x: the margin is then 67 mm"
    )
    assert topics(review({}).warnings) == []


SIZES = (*LENGTHS, "legs.shaft_position")
HEALTHY: dict[str, dict[str, Any]] = {
    "ten per cent larger": dict.fromkeys(SIZES, times(1.1)),
    "ten per cent smaller": dict.fromkeys(SIZES, times(0.9)),
    "heavier": {"body.mass": 7.15},
    "lighter": {"body.mass": 5.85},
    "longer": {"legs.shaft_position": lambda rows: [[1.1 * x - 0.0085, y, z] for x, y, z in rows]},
    "wider": {"legs.shaft_position": lambda rows: [[x, 1.1 * y, z] for x, y, z in rows]},
    "stiffer": {"contact.stiffness": times(1.1)},
    "softer": {"contact.stiffness": times(0.9)},
    "more grip": {"contact.mu": times(1.1)},
    "less grip": {"contact.mu": times(0.9)},
    "a legs' centre a little ahead": {"legs.shaft_position": moved(0.01)},
    "a legs' centre a little behind": {"legs.shaft_position": moved(-0.01)},
    "faster": {"gait.tripod.frequency": 0.2, "gait.metachronal.frequency": 0.2},
    "a longer stance": {"gait.tripod.duty": 0.65, "gait.metachronal.duty": 0.7},
    "a wider sweep": {"gait.tripod.stance_sweep": times(1.1)},
    "a narrower sweep": {"gait.tripod.stance_sweep": times(0.9)},
    "more inertia": {"body.inertia": times(1.1)},
    "less inertia": {"body.inertia": times(0.9)},
    "springs that differ": {"contact.stiffness": [2250, 2500, 2750, 2600, 2400, 2500]},
    "sensors at the feet": {"force_sensor.offset": of_all([-0.08, 0.0, -0.12])},
}


@pytest.mark.parametrize("case", soaked(HEALTHY, lambda case: case in [*HEALTHY][::2]))
def test_a_healthy_robot_raises_no_alarm(case: str) -> None:
    assert topics(review(HEALTHY[case]).warnings) == []


@pytest.mark.parametrize("robots", [12, pytest.param(100, marks=pytest.mark.thorough)])
def test_robots_of_ten_per_cent_raise_no_alarm(robots: int) -> None:
    random = np.random.default_rng(0)

    def spread(value: Any) -> Any:
        return (
            [spread(one) for one in value]
            if isinstance(value, list)
            else value * random.uniform(0.95, 1.05)
        )

    alarms = []
    for _ in range(robots):
        size = random.uniform(0.9, 1.1)
        changes = dict.fromkeys(SIZES, times(size))
        changes |= {"body.mass": spread, "body.inertia": spread, "contact.stiffness": spread,
                    "contact.mu": spread}  # fmt: skip
        alarms += topics(review(changes).warnings)
    assert alarms == []


def test_a_robot_that_walks_backward_is_told() -> None:
    config = load_robot()
    figures = replace(review_robot(config).gaits[0].figures, speed_m_s=-0.013)
    servo = config.parameters.servo
    assert [one.topic for one in gait_concerns(figures, servo, 0.35)] == ["walks backward"]


@pytest.mark.parametrize(
    ("name", "end", "side"),
    [
        ("FL", FRONT, LEFT), ("HR", HIND, RIGHT), ("ML", MIDDLE, LEFT), ("RR", HIND, RIGHT),
        ("RL", HIND, LEFT), ("LF", FRONT, LEFT), ("RF", FRONT, RIGHT), ("BL", HIND, LEFT),
        ("fr", FRONT, RIGHT), ("L1", None, LEFT), ("R_2", None, RIGHT), ("front_left", FRONT, LEFT),
        ("hindRight", HIND, RIGHT), ("left-rear", HIND, LEFT), ("middle left leg", MIDDLE, LEFT),
        ("A", None, None), ("LR", None, None), ("leg3", None, None), ("FLAT", None, None),
    ],
)  # fmt: skip
def test_what_a_name_says_of_the_place(name: str, end: int | None, side: int | None) -> None:
    assert named_place(name) == (end, side)


def test_the_octopod_of_the_examples_has_no_warning() -> None:
    assert topics(review_robot(load_robot(OCTOPOD)).warnings) == []


def chain_topics(changes: dict[str, Any]) -> list[str]:
    """Warnings of the 18-joint hexapod with some keys of its file changed."""
    folder = Path("examples")
    text = text_with(changes, (folder / "hexapod18.toml").read_text(encoding="utf-8"))
    return topics(review_robot(parse_robot(complete(text, folder))).warnings)


def test_legs_of_chains_that_are_swapped_are_caught() -> None:
    """The feet in another order than the names: left is right, front is hind, two of them."""
    assert chain_topics({}) == []
    for order in (
        ["RF", "RM", "RH", "LF", "LM", "LH"],
        ["LH", "LM", "LF", "RH", "RM", "RF"],
        ["RF", "LM", "LH", "LF", "RM", "RH"],
        ["LM", "LF", "LH", "RF", "RM", "RH"],
    ):
        assert chain_topics({"leg.feet": [f"{leg}_foot" for leg in order]}) == ["legs.order names"]


def test_a_chain_whose_centre_of_mass_is_elsewhere_is_caught() -> None:
    assert "standing falls" in chain_topics({"leg": lambda leg: {**leg, "origin": [0.6, 0.0, 0.0]}})
