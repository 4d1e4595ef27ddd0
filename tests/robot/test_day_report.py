"""``bigant report``: every run of a day has its row, and none is lost."""

import json
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from gap.diagnosis.answer.findings import Verdict
from model.values.arrays import readonly
from record.trial.trial import write_trial
from robot.cli import main as cli
from robot.day import gap as day_gap
from robot.day.gap import gap_of_day
from robot.day.runs import DayRun, logs_of, read_runs_of_day
from robot.day.text import day_lines, day_sentence
from robot.gap_report.trials import read_trials


@pytest.fixture(scope="module")
def day(short_walk: Path, cycle_walk: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two walks, a file that is no log, and one that is cut off."""
    folder = tmp_path_factory.mktemp("day")
    shutil.copyfile(short_walk, folder / "short.mcap")
    shutil.copyfile(cycle_walk, folder / "cycle.mcap")
    (folder / "broken.mcap").write_bytes(b"\x00" * 2000)
    (folder / "notes.txt").write_text("not a log")
    return folder


@pytest.fixture(scope="module")
def runs(day: Path) -> tuple[DayRun, ...]:
    return read_runs_of_day(logs_of([day]), lambda _at, _path: None)


def test_every_log_has_a_row_and_one_that_cannot_be_read_its_reason(
    runs: tuple[DayRun, ...],
) -> None:
    assert [one.path.name for one in runs] == ["cycle.mcap", "short.mcap", "broken.mcap"]
    cycle, short, broken = runs
    assert cycle.summary is not None
    assert short.summary is not None
    assert broken.summary is None
    assert "broken.mcap" in broken.reason
    assert cycle.summary.cycles == pytest.approx(1.0, abs=0.05)
    true_error = 100 * cycle.summary.estimate_walk_drift_m / cycle.summary.distance_m
    assert cycle.end_error == pytest.approx(true_error)
    assert cycle.end_words == "completed"
    assert cycle.health_words == "ok"
    assert not cycle.fault_words
    assert not cycle.stopped_by_fault


def test_the_table_says_what_was_not_asked_and_what_was_not_read(
    runs: tuple[DayRun, ...],
) -> None:
    told = "\n".join(day_lines(runs, gap_of_day(runs, (), 1, lambda _w, _s: None), 80))
    assert told.startswith("2 runs, 2 with walking: ")
    assert "1 run could not be read." in " ".join(told.split())
    assert "gap: not compared with earlier runs; add --reference FOLDER" in told
    assert "not read" in told
    table = [line for line in told.splitlines() if line.startswith(("run ", "cycle", "short"))]
    assert len(table) == 3
    assert max(map(len, table)) <= 80


@pytest.mark.usefixtures("words_only")
def test_a_page_names_every_run_and_links_to_its_page(
    day: Path, runs: tuple[DayRun, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    beside, out = day / "cycle.html", tmp_path / "monday.html"
    beside.write_text("a page")
    try:
        assert cli.run(["report", str(day), "--out", str(out)]) == 0
    finally:
        beside.unlink()
    assert f"page: {out}" in capsys.readouterr().out
    page = out.read_text(encoding="utf-8")
    assert day_sentence(runs) in page
    assert "/cycle.html'>cycle</a>" in page
    assert "short.html" not in page, "it has no page yet"
    assert "<span>show</span>" in page, "but a command that makes one"
    assert "does not begin like an MCAP file" in page
    assert not (day / "report.html").exists()


def test_json_has_every_run(day: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["report", str(day), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [one["summary"] is None for one in told["runs"]] == [False, False, True]
    assert told["runs"][2]["reason"]
    assert told["gap"]["verdict"] is None
    assert not list(day.glob("*.html"))


def test_without_a_readable_log_the_exit_code_is_1_and_a_wrong_folder_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["report", str(tmp_path / "absent.mcap"), "--json"]) == 1
    assert "absent.mcap" in json.loads(capsys.readouterr().out)["runs"][0]["reason"]
    assert cli.run(["report", str(tmp_path)]) == 4
    assert "holds no logs (.mcap)" in capsys.readouterr().err
    (tmp_path / "a.mcap").write_bytes(b"")
    assert (
        cli.run(["report", str(tmp_path), "--reference", str(tmp_path / "a.mcap"), "--json"]) == 1
    )
    assert (
        json.loads(capsys.readouterr().out)["gap"]["words"] == "no run of the day can be compared"
    )
    assert cli.run(["report", str(tmp_path), "--out", str(tmp_path / "a.pdf")]) == 2


def test_the_gap_is_of_all_whole_runs_of_the_day_together(
    runs: tuple[DayRun, ...], monkeypatch: pytest.MonkeyPatch, day: Path, tmp_path: Path
) -> None:
    (walk,) = read_trials((day / "cycle.mcap",))
    earlier = tmp_path / "earlier.parquet"
    write_trial(replace(walk, shaft_rad=readonly(walk.shaft_rad + 1e-4)), earlier)
    asked: list[Any] = []

    def diagnosed(read: Any, simulator: Any, request: Any, progress: Any) -> Any:
        asked.append((read, request))
        words = {"headline": "NO GAP", "sentence": "No gap."}
        return SimpleNamespace(verdict=Verdict.NO_GAP, **words)

    monkeypatch.setattr(day_gap, "diagnosis_of", diagnosed)
    monkeypatch.setattr(day_gap, "simulator_of", lambda read, request: None)
    references: Sequence[Path] = (earlier, day / "broken.mcap")
    gap = gap_of_day(runs, references, 1, lambda _w, _s: None)
    ((read, request),) = asked
    assert [one.name for one in request.trials] == ["cycle.mcap", "short.mcap"]
    assert request.reference == (earlier,)
    assert (len(read.trials), len(read.references)) == (2, 1)
    assert gap.verdict == "NO GAP"
    assert [path.name for path, _ in gap.left_out] == ["broken.mcap"]
    assert "gap: NO GAP. No gap." in "\n".join(day_lines(runs, gap, 80))
    again = gap_of_day(runs, (day / "cycle.mcap",), 1, lambda _w, _s: None)
    assert "cycle.mcap is given twice" in again.words


def test_without_a_run_that_can_be_read_there_is_no_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "broken.mcap").write_bytes(bytes(2000))
    assert cli.run(["report", str(tmp_path)]) == 1
    assert "1 run could not be read" in " ".join(capsys.readouterr().out.split())
    assert not list(tmp_path.glob("*.html"))
