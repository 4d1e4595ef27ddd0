"""The line that says how far a long reading is."""

from pathlib import Path

import pytest

from record.salvage import Pass, read_records
from robot import progress
from robot.progress import ProgressLine
from tests.record.test_log import write_log


def test_a_long_reading_says_how_far_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "FIRST_S", 0.0)
    monkeypatch.setattr(progress, "FILE_S", 0.0)
    path = tmp_path / "log.mcap"
    write_log(path, 60)
    done = Pass()
    with ProgressLine("reading it", done):
        assert sum(1 for _ in read_records(path, done)) > 60
    captured = capsys.readouterr()
    lines = captured.err.splitlines()
    percents = [int(line.removeprefix("reading it: ").removesuffix(" %")) for line in lines]
    assert percents[0] == 0
    assert percents == sorted(percents)
    assert percents[-1] > 90
    assert captured.out == "", "what a program reads stays clean"


def test_a_short_reading_says_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(progress, "FIRST_S", 1e9)  # short, however slow the machine
    path = tmp_path / "log.mcap"
    write_log(path, 5)
    done = Pass()
    with ProgressLine("reading it", done):
        assert sum(1 for _ in read_records(path, done)) > 5
    assert capsys.readouterr().err == ""
