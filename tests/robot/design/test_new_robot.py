"""``bigant robot new``: files that load, walk without a warning, and say what is assumed."""

import io
import tomllib
from pathlib import Path

import numpy as np
import pytest

from drivers.dynamixel.catalog import SERVO_MODELS
from model.kinematics.legs import leg_kinematics
from model.values.parameters import CrankParameters
from model.values.tick import Mode
from robot.cli import main as cli
from robot.config.robot_file import load_robot, parse_robot
from robot.design.assumed import assumed_keys
from robot.design.new_robot import new_robot
from robot.design.new_text import CRANK, FOUR_BAR
from robot.design.review import review_robot
from robot.report.summary import read_summary
from robot.requests.robot import RobotNewRequest
from tests.soaked import THOROUGH, soaked

MODELS = [model.name for model in SERVO_MODELS]


def made(folder: Path, *options: str) -> Path:
    out = folder / "lab.toml"
    assert cli.run(["robot", "new", "--out", str(out), *options]) == 0
    return out


@pytest.mark.parametrize(
    ("legs", "leg"),
    [
        pytest.param(
            legs, leg, marks=() if (leg == CRANK) is (legs in {5, 12}) else pytest.mark.soak
        )
        for legs in (4, 5, 6, 7, 8, 12)
        for leg in (FOUR_BAR, CRANK)
    ],
)
def test_any_number_of_legs_walks_without_a_warning(tmp_path: Path, legs: int, leg: str) -> None:
    config = load_robot(made(tmp_path, "--legs", str(legs), "--leg", leg))
    review = review_robot(config)
    assert review.warnings == ()
    assert config.parameters.legs.count == legs
    for one in review.gaits:
        assert one.figures.speed_m_s > 5e-4
        assert one.figures.margin_m > 2e-3
        assert one.figures.feet_least >= 3


# Each servo carries one kind of legs here, in turns.
ON_EITHER_LEG = [(model, leg) for model in MODELS for leg in (FOUR_BAR, CRANK)]


@pytest.mark.parametrize(
    ("model", "leg"),
    [
        pytest.param(*case, marks=() if number % 12 in {0, 7} else pytest.mark.soak)
        for number, case in enumerate(ON_EITHER_LEG)
    ],
)
def test_any_servo_carries_the_robot_that_suits_it(tmp_path: Path, model: str, leg: str) -> None:
    config = load_robot(made(tmp_path, "--servo", model, "--leg", leg))
    assert config.parameters.servo.models == (model,) * 6
    assert review_robot(config).warnings == ()


def test_it_has_the_sizes_that_were_given(tmp_path: Path) -> None:
    path = made(
        tmp_path, "--name", "Quad \"4\"", "--legs", "4", "--leg-length", "0.2", "--length", "0.6",
        "--width", "0.4", "--mass", "5", "--force-sensors", "ati",
    )  # fmt: skip
    config = load_robot(path)
    robot = config.parameters
    assert config.name == 'Quad "4"'
    assert robot.body.mass == 5
    feet = leg_kinematics(robot).feet(np.zeros(4), np.zeros(4)).position_m
    assert feet[:, 2] == pytest.approx([-0.2] * 4, abs=5e-4)
    assert feet[:, 0].max() - feet[:, 0].min() == pytest.approx(0.6, abs=1e-3)
    assert sorted(feet[:, 1]) == pytest.approx([-0.2, -0.2, 0.2, 0.2])
    assert feet[:, 0].mean() == pytest.approx(
        0, abs=6e-3
    )  # the middle of the stance is in the middle
    assert config.force_sensor.transducers.tolist() == [1, 2, 3, 4]
    assert not {"body.mass", "legs.shaft_position"} & set(assumed_keys(config.text))


def test_what_was_not_given_is_marked_as_assumed(tmp_path: Path) -> None:
    text = made(tmp_path).read_text(encoding="utf-8")
    assert {"body.mass", "body.inertia", "legs.shaft_position", "contact.mu", "leg.*"} <= set(
        assumed_keys(text)
    )
    assert "force_sensor" not in tomllib.loads(text)
    assert max(map(len, text.splitlines())) <= 108


def test_seven_sensors_are_one_too_many_for_a_unit(tmp_path: Path) -> None:
    config = load_robot(made(tmp_path, "--legs", "8", "--force-sensors", "ati"))
    assert config.force_sensor.transducers.tolist() == [1, 2, 3, 4, 5, 6, 0, 0]


def test_an_earlier_file_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first = made(tmp_path).read_text(encoding="utf-8")
    made(tmp_path, "--legs", "8")
    assert (tmp_path / "lab.1.toml").read_text(encoding="utf-8") == first
    assert "lab.1.toml" in capsys.readouterr().err


def test_a_robot_that_cannot_carry_itself_is_written_with_its_warning(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "heavy.toml"
    options = ["--servo", "XL330-M077", "--mass", "6", "--out", str(out)]
    assert cli.run(["robot", "new", *options]) == 1
    assert out.is_file()
    assert "saturates" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--servo", "AX-12"], "no servo known here"),
        (["--out", "lab.txt"], "must end in .toml"),
    ],
)
def test_what_cannot_be(options: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["robot", "new", *options]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--legs", "3"], "from 4 to 24"),
        (["--mass", "-1"], "from 0.02 to 200"),
        (["--leg", "wheel"], "invalid choice"),
    ],
)
def test_what_the_parser_refuses(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        cli.run(["robot", "new", *options])
    assert words in capsys.readouterr().err


class Terminal(io.StringIO):
    """Answers as if typed at a terminal."""

    def isatty(self) -> bool:
        return True


def test_a_person_is_asked_for_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers = iter(["Spider", "three", "8", "wheel", "crank", "0.1", "-3", "", "", "4.5", "ati"])
    asked: list[str] = []

    def typed(question: str) -> str:
        asked.append(question)
        return next(answers)

    monkeypatch.setattr("builtins.input", typed)
    monkeypatch.setattr("sys.stdin", Terminal())
    monkeypatch.setattr("sys.stdout", Terminal())
    new_robot(RobotNewRequest(out=tmp_path / "spider.toml", servo="XM430-W350"))
    config = load_robot(tmp_path / "spider.toml")
    robot = config.parameters
    assert (config.name, robot.legs.count, robot.body.mass) == ("Spider", 8, 4.5)
    assert robot.leg == CrankParameters(0.1, 0.05)
    assert config.force_sensor.any
    assert len(asked) == 11
    assert not any("servo" in question for question in asked)  # it was given


def test_without_a_terminal_nobody_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("builtins.input", lambda _: pytest.fail("asked"))
    monkeypatch.setattr("sys.stdin", io.StringIO())
    assert cli.run(["robot", "new", "--name", "Lab Robot 2"]) == 0
    assert load_robot(tmp_path / "lab-robot-2.toml").name == "Lab Robot 2"


@pytest.mark.parametrize(
    "options",
    soaked(
        [
            ("--leg", "crank", "--servo", "XL430-W250"),
            ("--legs", "4", "--servo", "XL330-M288"),
            ("--legs", "8", "--force-sensors", "ati"),
            ("--legs", "5", "--leg", "crank"),
        ],
        lambda options: "XL430-W250" in options,
        " ".join,
        THOROUGH,
    ),
)
def test_it_walks_virtually_as_fast_as_the_model_says(
    tmp_path: Path, options: tuple[str, ...]
) -> None:
    robot = made(tmp_path, *options)
    robot.write_text(robot.read_text() + "\n[estimator]\nenabled = false\n")  # not looked at
    expected = review_robot(load_robot(robot)).gaits[-1].figures
    log = tmp_path / "walk.mcap"
    drive = [
        "drive",
        "--robot",
        str(robot),
        "--virtual-time",
        "--gait",
        expected.gait,
        "--log",
        str(log),
    ]
    assert cli.run([*drive, "--cycles", "1"]) == 0
    _, recording = read_summary(log)
    walking = recording.mode == Mode.WALK.value
    x = recording.truth_position_W[walking, 0]
    speed = (x[-1] - x[0]) * expected.frequency_hz  # of one cycle
    assert speed == pytest.approx(expected.speed_m_s, rel=0.3)


def test_the_text_is_the_same_every_time(tmp_path: Path) -> None:
    text = made(tmp_path).read_text(encoding="utf-8")
    assert text == made(tmp_path).read_text(encoding="utf-8")
    assert parse_robot(text).text == text
