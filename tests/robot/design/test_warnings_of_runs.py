"""What is wrong with a robot file is printed by drive and check, and kept in the log."""

from pathlib import Path
from typing import Any

import pytest

from record.log.survey import survey_log
from robot.bringup.preflight.design import design_findings
from robot.bringup.preflight.finding import CheckVerdict, exit_code
from robot.cli import main as cli
from robot.console.exit_codes import ExitCode
from robot.design.review import review_for_run, review_robot, warning_lines
from tests.robot.design.robot_files import robot_with, text_with
from tests.robot.design.test_concerns import SYMMETRIC, moved

FAST = ("--virtual-time", "--force-unit", "none", "--duration", "0.5")


def lab(folder: Path, changes: dict[str, Any]) -> str:
    path = folder / "lab.toml"
    path.write_text(text_with(changes), encoding="utf-8")
    return str(path)


def test_a_drive_warns_of_its_own_gait_and_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "run.mcap"
    robot = lab(tmp_path, SYMMETRIC)
    assert cli.run(["drive", "--robot", robot, "--log", str(log), *FAST]) == 0
    warnings = [
        line for line in capsys.readouterr().err.splitlines() if line.startswith("warning: ")
    ]
    assert warnings[0].startswith("warning: tripod tips: ")
    assert all("tripod" in line for line in warnings)
    kept = survey_log(log).metadata["warnings"].splitlines()
    assert [f"warning: {line}" for line in kept] == warnings
    assert cli.run(["log", "info", str(log)]) == 0
    lines = [line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines()]
    assert ["warning", kept[0]] in lines


@pytest.mark.soak
def test_a_drive_of_a_healthy_robot_warns_of_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "run.mcap"
    assert cli.run(["drive", "--log", str(log), *FAST]) == 0
    assert "warning" not in capsys.readouterr().err
    assert "warnings" not in survey_log(log).metadata


def test_a_drive_of_a_robot_that_cannot_stand_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = lab(tmp_path, {"legs.shaft_position": moved(0.6)})
    assert cli.run(["drive", "--robot", robot, "--log", "none", *FAST]) == 2
    assert "the robot falls over; move the shafts by -600 mm in x" in capsys.readouterr().err


def test_who_only_listens_is_not_warned(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = lab(tmp_path, SYMMETRIC)
    assert cli.run(["drive", "--readonly", "--robot", robot, "--log", "none", *FAST]) == 0
    assert "tips" not in capsys.readouterr().err


def test_a_robot_that_is_served_is_warned_of_with_all_its_gaits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The lines of a drive that may choose any gait, before anything waits for a client."""
    monkeypatch.setattr("robot.virtual.serve.serve", lambda *_, **__: None)
    monkeypatch.setattr("signal.signal", lambda *_: None)
    assert cli.run(["sim", "serve", "--robot", lab(tmp_path, SYMMETRIC)]) == 0
    lines = capsys.readouterr().err.splitlines()
    warnings = [line for line in lines if line.startswith("warning: ")]
    assert warnings == warning_lines(review_robot(robot_with(SYMMETRIC)))
    assert {"tripod", "metachronal"} <= {line.split()[1] for line in warnings}
    assert cli.run(["sim", "serve"]) == 0
    assert "warning: " not in capsys.readouterr().err


def test_check_has_a_line_for_each_warning() -> None:
    good = list(design_findings(review_for_run(robot_with({}))))
    assert [one.verdict for one in good] == [CheckVerdict.PASS]
    assert good[0].found == "tripod 67 mm from tipping; metachronal 86 mm from tipping"
    shaky = list(design_findings(review_for_run(robot_with(SYMMETRIC))))
    assert {one.verdict for one in shaky} == {CheckVerdict.WARN}
    assert "+85 mm in x" in shaky[0].advice
    assert exit_code(shaky) is ExitCode.OK
    falls = list(design_findings(review_for_run(robot_with({"legs.shaft_position": moved(0.6)}))))
    assert falls[0].verdict is CheckVerdict.FAIL
