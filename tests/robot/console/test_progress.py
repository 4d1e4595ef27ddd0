"""The line that says how far a long reading is."""

import io
import os
import sys
from pathlib import Path

import pytest

from record.log.damage import Pass
from record.log.salvage import read_records
from robot.console import progress
from robot.console.progress import ProgressBar, ProgressLine
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


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_line_on_a_terminal_is_shortened_and_never_wraps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "FIRST_S", 0.0)
    monkeypatch.setattr(progress, "TERMINAL_S", 0.0)
    monkeypatch.setattr(progress, "terminal_size", lambda _stream: os.terminal_size((60, 24)))
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    ProgressBar("diagnosis").show(0.35, "what each effect would do to every one of the runs")
    path = tmp_path / f"{'long' * 20}.mcap"
    write_log(path, 60)
    done = Pass()
    with ProgressLine(f"reading {path}", done):
        assert sum(1 for _ in read_records(path, done)) > 60
    lines = terminal.getvalue().split("\r")
    assert max(map(len, lines)) < 60
    assert any(line.startswith("diagnosis [") and line.endswith("...") for line in lines)
    assert any(line.startswith("reading /") and line.endswith(" %") for line in lines)
