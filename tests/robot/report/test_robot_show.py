"""``bigant robot show``: the table, the page, the JSON, and its exit code."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from model.values.gravity import STANDARD_GRAVITY
from robot.cli import main as cli
from robot.config.robot_file import load_robot, parse_robot
from robot.design.assumed import assumed_keys
from robot.design.review import review_robot
from robot.report.robot_figures import leg_lines
from tests.robot.browser import without_scripts
from tests.robot.design.robot_files import NOMINAL, text_with
from tests.soaked import soaked

BEHIND = {"legs.shaft_position": lambda rows: [[x - 0.085, y, z] for x, y, z in rows]}


def written(folder: Path, text: str) -> str:
    path = folder / "lab.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_the_nominal_robot_in_one_screen(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["robot", "show"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("robot          BigANT, 6 legs: HL, ML, FL, HR, MR, FR")
    [margin] = [line for line in lines if line.startswith("static margin")]
    assert " ".join(margin.split()) == "static margin 67 mm at phase 0.60 86 mm at phase 0.16"
    assert not any(line.startswith("warning") for line in lines)
    assert len([line for line in lines if not line.startswith("assumed")]) < 50


def test_a_bad_robot_is_a_bad_verdict_with_its_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lab = written(tmp_path, text_with(BEHIND))
    assert cli.run(["robot", "show", lab, "--gait", "tripod"]) == 1
    printed = capsys.readouterr().out
    assert "tripod tips" in printed
    assert "+85 mm in x" in printed
    assert "metachronal tips" not in printed
    assert "metachronal slips" not in printed


def test_another_gait_than_it_has(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["robot", "show", "--gait", "gallop"]) == 2
    assert "this robot, which has tripod, metachronal" in capsys.readouterr().err


def test_its_json_holds_a_cycle(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert cli.run(["robot", "show", written(tmp_path, text_with(BEHIND)), "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    tripod, metachronal = answer["gaits"]
    assert (tripod["name"], metachronal["name"]) == ("tripod", "metachronal")
    assert len(tripod["margin_m"]) == len(tripod["phase"]) == len(tripod["load_n"])
    assert min(tripod["margin_m"]) == pytest.approx(tripod["figures"]["margin_m"])
    assert answer["concerns"][0]["topic"] == "tips"
    assert "leg.*" in answer["assumed"]


@pytest.mark.usefixtures("words_only")
def test_the_page_draws_it_and_says_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "lab.html"
    lab = written(tmp_path, text_with(BEHIND))
    assert cli.run(["robot", "show", lab, "--gait", "tripod", "--out", str(out)]) == 1
    page = without_scripts(out.read_text(encoding="utf-8"))
    assert page.count("<svg") == 4  # the robot, and three pictures of its gait
    assert "move the shafts by +85 mm" in page
    assert not re.search(r"(src|href)=['\"](?!data:|#)", page)
    assert f"page: {out}" in capsys.readouterr().out


@pytest.mark.soak
def test_a_robot_that_falls_has_a_page_as_well(tmp_path: Path) -> None:
    beside = {"legs.shaft_position": lambda rows: [[x + 0.6, y, z] for x, y, z in rows]}
    out = tmp_path / "lab.html"
    assert cli.run(["robot", "show", written(tmp_path, text_with(beside)), "--out", str(out)]) == 1
    page = without_scripts(out.read_text(encoding="utf-8"))
    assert "falls over" in page
    assert page.count("<svg") == 7  # the robot, and three pictures for each of two gaits


@pytest.mark.usefixtures("empty_pictures")
def test_pictures_alone(tmp_path: Path) -> None:
    assert cli.run(["robot", "show", "--gait", "tripod", "--out", str(tmp_path / "robot.png")]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "robot-robot.png", "robot-tripod-feet-in-stance.png", "robot-tripod-over-one-cycle.png",
    ]  # fmt: skip


def test_keys_whose_comments_say_that_they_are_assumed() -> None:
    text = """
name = "assumed"                 # of no consequence
[body]
mass = 6.5                       # assumed; weighed
text = "# assumed, but not in a comment"

# a place, assumed
place = [
  1.0,
]
other = 1
[leg]                            # made up
crank = 1
[gait.tripod]
duty = 0.6                       # from the paper
sweep = 1.0                      # rad, assumed
"""
    assert assumed_keys(text) == ("body.mass", "body.place", "leg.*", "gait.tripod.sweep")
    assert "servo.max_speed" in assumed_keys(NOMINAL)


@pytest.mark.parametrize(
    "name", soaked(["hexapod18", "quadruped12"], lambda name: name == "hexapod18")
)
def test_a_robot_of_chains_stands(
    name: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    request: pytest.FixtureRequest,
) -> None:
    """Legs of several joints have no gait here: loads, margin and torques with all joints at zero."""
    if name == "hexapod18":  # the other one is drawn
        request.getfixturevalue("words_only")
    out = tmp_path / "robot.html"
    assert cli.run(["robot", "show", f"examples/{name}.toml", "--out", str(out), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    [standing] = answer["gaits"]
    assert standing["name"] == "standing"
    config = load_robot(Path(f"examples/{name}.toml"), driven=False)
    robot = config.parameters
    weight_n = robot.body.mass * STANDARD_GRAVITY
    assert sum(standing["load_n"][0]) == pytest.approx(weight_n)
    assert len(standing["torque_nm"][0]) > len(answer["legs"])
    assert standing["figures"]["duty_most"] is None
    assert standing["figures"]["margin_m"] > 0.05
    assert without_scripts(out.read_text(encoding="utf-8")).count("<svg") == 3


def test_a_crank_is_drawn_with_its_half_circle() -> None:
    text = text_with({"leg": {"kind": "crank", "length": 0.13, "radius": 0.06}})
    text = text.replace("0.085,", "0.0,").replace("0.285,", "0.2,").replace("-0.115,", "-0.2,")
    lines = leg_lines(review_robot(parse_robot(text)))
    assert len(lines) == 6
    sole = lines[0][1]
    np.testing.assert_allclose(sole[-1], [-0.2, 0.25, -0.13], atol=1e-12)
    centre = np.array([-0.2, 0.25, -0.07])
    np.testing.assert_allclose(np.sqrt(((sole - centre) ** 2).sum(1)), 0.06, atol=1e-12)


def test_a_gait_of_a_python_file(capsys: pytest.CaptureFixture[str]) -> None:
    cli.run(["robot", "show", "--gait", "examples/own_gait.py"])
    printed = capsys.readouterr().out
    assert "own_gait" in printed
    assert "tripod" not in printed.split("assumed")[0]
