"""The command on small trials on disk: its answer, its files, its exit codes."""

import argparse
import io
import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from gap.diagnosis.answer.findings import TrialFaults
from gap.interfaces import DataFault
from model.errors import ConfigError
from model.motion.filters import play
from record.trial.trial import write_trial
from robot.cli.main import run
from robot.console.arguments import add_arguments
from robot.console.json_output import check_json, to_stdout
from robot.gap_report.words import fault_groups
from robot.requests.campaign import CampaignScoreRequest
from robot.requests.gap import GapDiagnoseRequest
from tests.gap.bench_trials import IDEAL, servo_trial
from tests.robot.browser import without_scripts

if TYPE_CHECKING:
    from _typeshed import DataclassInstance


def write_bench(folder: Path, width: float, count: int = 4) -> list[str]:
    paths = []
    for number in range(count):
        rng = np.random.default_rng(number)
        t = np.arange(1000) / 50.0
        command = 0.6 * np.sin(2 * np.pi * (0.15 + 0.05 * number) * t)
        shaft = play(command, width, 0.0) + 0.001 * rng.standard_normal(len(t))
        path = folder / f"run{number}.csv"
        write_trial(servo_trial(IDEAL, command, shaft), path)
        paths.append(str(path))
    return paths


def test_a_servo_with_play(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = write_bench(tmp_path, 0.03)
    page, told = tmp_path / "d.html", tmp_path / "d.json"
    arguments = ["gap", "diagnose", *paths, "--html", str(page), "--json", str(told), "--jobs", "1"]
    assert run(arguments) == 0
    out = capsys.readouterr().out
    assert out.startswith(
        "fitted to run0.csv, run1.csv, run2.csv; held out for testing: run3.csv\n"
    )
    assert "\n\nEXPLAINED\n" in out
    assert "play at arm (width_rad 0.03" in out
    found = json.loads(told.read_text())
    assert found["causes"][0]["effect"] == "play"
    assert found["causes"][0]["parameters"]["width_rad"] == pytest.approx(0.03, rel=0.05)
    assert found["gap"]["after"] < 0.3
    text = without_scripts(page.read_text())
    assert "play at arm" in text
    assert text.count("<svg") == 1  # the only channel, before and after
    for title in ("Explained", "Which effects", "What to do:", "Where it lies", "Before and after"):
        assert title in text
    assert "prefers-color-scheme: dark" in text
    assert "max-width: 40rem" in text
    assert "@media print" in text
    assert not re.search(r"(src|href)=.https?:", text), (
        "a page of its own needs nothing from elsewhere"
    )


@pytest.mark.usefixtures("words_only")
def test_files_are_written_though_nobody_reads_what_is_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Gone(io.StringIO):
        def write(self, _: str) -> int:
            raise BrokenPipeError

    paths = write_bench(tmp_path, 0.0)
    page, answer = tmp_path / "d.html", tmp_path / "d.json"
    monkeypatch.setattr(sys, "stdout", Gone())  # as with `| head -1`
    asked = ["gap", "diagnose", *paths, "--html", str(page), "--json", str(answer), "--jobs", "1"]
    assert run(asked) == 0
    assert json.loads(answer.read_text())["verdict"] == "no_gap"
    assert "</html>" in page.read_text()


@pytest.mark.parametrize(
    "asked", [["--json"], pytest.param(["--json", "-"], marks=pytest.mark.soak)]
)
def test_json_to_stdout_is_nothing_but_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], asked: list[str]
) -> None:
    paths = write_bench(tmp_path, 0.0)
    assert run(["gap", "diagnose", *paths, "--jobs", "2", *asked]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "no_gap"
    assert found["causes"] == []


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (["nothing.csv"], "nothing"),
        (["RUN", "--html", "page.pdf"], "--html"),
        (["RUN", "--effects", "mine.py"], "--effects"),
        (["RUN", "--json", "no/such/folder/d.json"], "there is no folder"),
        (["RUN", "--json", "RUN"], "is no JSON"),
    ],
)
def test_mistakes_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], wrong: list[str], words: str
) -> None:
    paths = write_bench(tmp_path, 0.0, 1)
    arguments = [paths[0] if word == "RUN" else word for word in wrong]
    assert run(["gap", "diagnose", *arguments, "--jobs", "1"]) != 0
    err = capsys.readouterr().err.strip().splitlines()[-1]
    assert words in err


def test_a_fault_of_many_files_is_one_row() -> None:
    lost = [
        DataFault("magnitude_only", "torque_nm", f"{n} samples", severe=False) for n in range(4)
    ]
    bad = DataFault("unit", "shaft_rad", "in degrees", severe=True)
    faults = (
        *(TrialFaults(number, (fault,)) for number, fault in enumerate(lost)),
        TrialFaults(3, (lost[3], bad)),
    )
    groups = fault_groups(faults, [Path(f"run{number}.csv") for number in range(4)])
    assert [(one.kind, len(one.files)) for one in groups] == [("unit", 1), ("magnitude_only", 4)]
    assert groups[1].where == "run0.csv, run1.csv and 2 more"
    assert groups[1].evidence == "0 samples"


def test_a_run_behind_json_is_not_overwritten_and_an_old_answer_is(tmp_path: Path) -> None:
    (path,) = write_bench(tmp_path, 0.0, 1)
    before = Path(path).read_bytes()
    header = Path(path).with_suffix(".toml")
    for precious in (Path(path), header):
        with pytest.raises(ConfigError, match="is no JSON"):
            check_json(precious)
    assert Path(path).read_bytes() == before
    old = tmp_path / "old.json"
    for text in ('{"verdict": "no_gap"}', ""):
        old.write_text(text)
        check_json(old)
    check_json(tmp_path / "new.json")
    check_json(None)


@pytest.mark.parametrize("command", [GapDiagnoseRequest, CampaignScoreRequest])
def test_json_without_a_file_prints(command: "type[DataclassInstance]") -> None:
    parser = argparse.ArgumentParser()
    add_arguments(parser, command)
    assert parser.parse_args(["runs"]).json is None
    assert to_stdout(parser.parse_args(["runs", "--json"]).json)
    assert to_stdout(parser.parse_args(["runs", "--json", "-"]).json)
    assert parser.parse_args(["runs", "--json", "d.json"]).json == Path("d.json")
