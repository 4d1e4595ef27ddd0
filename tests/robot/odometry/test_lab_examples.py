"""A lab's CSV and ROS 2 bag, as the example writes them, become a page of odometry in three commands."""

import json
import runpy
from pathlib import Path

import pytest

from robot.cli import main as cli
from robot.console.exit_codes import ExitCode
from tests.soaked import THOROUGH

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lab")
    runpy.run_path(str(EXAMPLES / "lab_data.py"))["main"](folder, "tripod", 1.0, 1)
    return folder


@pytest.mark.parametrize(
    ("source", "column_map"),
    [
        pytest.param("lab.csv", "lab_csv", marks=pytest.mark.soak),
        pytest.param("bag", "lab_bag", marks=THOROUGH),
    ],
)
def test_three_commands_from_the_data_to_the_page(
    source: str, column_map: str, lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, page = lab / f"{column_map}.mcap", lab / f"{column_map}.html"
    words = ["import", str(lab / source), "--map", str(lab / f"{column_map}.toml")]
    assert cli.run([*words, "--out", str(log)]) == ExitCode.OK
    said = capsys.readouterr().out
    assert "odometry      yes" in said
    assert "ground truth  yes: positions and attitudes" in said
    assert "forces        no: no sensors" in said
    assert "samples, with the estimate at each" in said
    assert cli.run(["replay", str(log), "--tolerance", "0"]) == ExitCode.OK
    assert "all of them the same in every bit" in capsys.readouterr().out
    assert cli.run(["show", str(log)]) == ExitCode.OK
    said = capsys.readouterr().out
    assert "(true, walking)" in said
    assert "drift of the estimator" in said
    assert cli.run(["odom", str(log), "--compare", "--out", str(page)]) == ExitCode.OK
    assert "judged against the truth in the log" in page.read_text(encoding="utf-8")
    capsys.readouterr()
    assert cli.run(["odom", str(log), "--compare", "--json"]) == ExitCode.OK
    mine = json.loads(capsys.readouterr().out)["ways"][0]
    assert mine["name"] == "estimator"
    assert mine["end_percent"] < 5
    # y up, millimetres and the marker undone: the walk is ahead, not up or aside
    assert 0.05 < float(said_distance(log, capsys)) < 0.3


def said_distance(log: Path, capsys: pytest.CaptureFixture[str]) -> float:
    assert cli.run(["show", str(log), "--json"]) == ExitCode.OK
    return float(json.loads(capsys.readouterr().out)["forward_m"])
