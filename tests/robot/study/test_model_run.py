"""``bigant model run``: a table, a picture, JSON; and one clear line for what makes no sense."""

import json
import runpy
import struct
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from model.errors import ModelError
from model.systems.predict import predict
from model.values.legs import FootMotion
from robot.cli import main as cli
from robot.console.exit_codes import ExitCode
from robot.study.model_plots import draw_predictions
from robot.study.model_run import prediction_rows
from robot.study.systems import build_system
from tests.soaked import soaked

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
OCTOPOD = EXAMPLES / "octopod.toml"


def run(*words: object) -> int:
    return cli.run(["model", "run", *(str(word) for word in words)])


SYSTEMS = ("bigant", "disk", "multipod", "quadruped", "stairs", "slither")


@pytest.mark.parametrize("system", soaked(SYSTEMS, lambda system: system in {"bigant", "stairs"}))
def test_every_system_prints_a_table_and_draws_a_picture(
    system: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "motion.png"
    assert run(system, "--cycles", "1", "--out", out) == ExitCode.OK
    printed = capsys.readouterr().out
    for label in (
        "frames",
        "mean speed",
        "distance",
        "turned",
        "forward slip",
        "without an answer",
    ):
        assert label in printed
    assert ("climbed" in printed) == (system == "stairs")
    assert "-0.0 deg" not in printed
    head = out.read_bytes()[:24]
    assert head.startswith(b"\x89PNG")
    width, height = struct.unpack(">II", head[16:])
    assert width > 600
    assert height > 600
    assert out.stat().st_size < 200_000


@pytest.mark.usefixtures("words_only")
def test_both_laws_side_by_side_on_a_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "motion.html"
    words = ("bigant", "--gait", "metachronal", "--cycles", "1", "--law", "both", "--out", out)
    assert run(*words) == ExitCode.OK
    printed = capsys.readouterr().out
    assert "viscous" in printed
    assert "coulomb" in printed
    page = out.read_text(encoding="utf-8")
    assert "<svg" in page
    assert "metachronal" in page


def test_json_has_the_figures_and_no_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("disk", "--legs", "8", "--cycles", "2", "--law", "both", "--json") == ExitCode.OK
    printed = json.loads(capsys.readouterr().out)
    assert printed["system"] == "disk"
    assert [law["law"] for law in printed["laws"]] == ["viscous", "coulomb"]
    assert printed["laws"][0]["frames"] == 400
    assert printed["laws"][0]["distance_m"] == pytest.approx(0.155, abs=0.02)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (("disk", "--legs", "2"), "3 to 50 legs"),
        (("multipod", "--legs", "9"), "6, 8, 10 or 12"),
        (("quadruped", "--legs", "4"), "fixed number of legs"),
        (("disk", "--gait", "tripod"), "--gait"),
        (("disk", "--robot", "x.toml"), "--robot"),
        (("bigant", "--robot", "absent.toml"), "absent.toml"),
        (("disk", "--cycles", "0"), "--cycles"),
        (("disk", "--cycles", "nan"), "--cycles"),
        (("disk", "--cycles", "1e9"), "--cycles"),
        (("disk", "--cycles", "0.001"), "too short"),
        (("quadruped", "--cycles", "0.001"), "at least 2 frames"),
        (("disk", "--out", "x.pdf"), ".html or .png"),
    ],
)
def test_mistakes_are_one_clear_line(
    words: tuple[str, ...],
    part: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*words) == ExitCode.USAGE
    said = capsys.readouterr().err
    assert part in said
    assert said.count("\n") == 1


def test_a_picture_that_cannot_be_written_is_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run("disk", "--out", "absent/x.png") == ExitCode.LOG
    assert "there is no folder absent; make it first" in capsys.readouterr().err


def test_an_unknown_system_is_refused_with_the_choices(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit) as stopped:
        run("centipede")
    assert stopped.value.code == ExitCode.USAGE
    assert "slither" in capsys.readouterr().err


def test_bigant_walks_slower_in_the_slipping_gait() -> None:
    speeds = {}
    for gait in ("tripod", "metachronal"):
        system = build_system("bigant", gait=gait, cycles=1)
        speeds[gait] = predict(system).poses[-1, 0] / system.time_s[-1]
        velocity = system.feet.velocity_m_s[1:-1]
        differences = (system.feet.position_m[2:] - system.feet.position_m[:-2]) / 0.02
        assert differences == pytest.approx(velocity, abs=0.02 * abs(velocity).max())
    assert 0.01 < speeds["metachronal"] < speeds["tripod"] < 0.02


def test_frames_without_an_answer_are_counted_and_leave_gaps_in_the_picture(
    tmp_path: Path,
) -> None:
    system = build_system("stairs", cycles=1)
    position = system.feet.position_m.copy()
    position[50:60, :, 0] += 1.0  # all feet ahead of the centre of mass
    position[70] = np.nan
    prediction = predict(replace(system, feet=FootMotion(position, system.feet.velocity_m_s)))
    rows = dict(prediction_rows([prediction]))
    assert rows["frames without an answer"] == "10: the robot tips, 1: a number is missing"
    draw_predictions([prediction]).savefig(tmp_path / "gaps.png")


def test_nothing_but_gaps_is_an_error() -> None:
    system = build_system("disk", cycles=1)
    away = FootMotion(system.feet.position_m + np.array([1.0, 0, 0]), system.feet.velocity_m_s)
    with pytest.raises(ModelError, match="no frame has an answer: the robot tips"):
        prediction_rows([predict(replace(system, feet=away))])


def test_another_robot_file_is_another_system() -> None:
    system = build_system("bigant", robot_file=OCTOPOD, cycles=1)
    assert system.legs == 8
    assert system.description.startswith("Octopod")
    assert predict(system).poses[-1, 0] > 0.05


@pytest.mark.parametrize(
    "path",
    soaked(
        sorted(EXAMPLES.glob("model_*.py")),
        lambda path: path.stem == "model_quadruped",
        lambda path: path.stem,
    ),
)
def test_examples_run_and_save_their_picture(
    path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = tmp_path / "example.png"
    monkeypatch.setattr(sys, "argv", [str(path), str(out)])
    runpy.run_path(str(path))
    assert capsys.readouterr().out
    assert out.stat().st_size > 10_000
