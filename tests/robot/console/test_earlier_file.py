"""Nothing that was measured is lost to the next run, and no half a file looks whole."""

import json
from pathlib import Path

import pytest

from model.errors import RecordError
from record.whole_file import check_room, whole_file
from robot.cli.main import run
from robot.console.program_output import keep_earlier


def test_an_earlier_file_gets_the_next_free_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.b.mcap"
    assert keep_earlier(path) is None
    path.touch()
    assert keep_earlier(path) is None  # empty: nothing to lose
    for number in (1, 2):
        path.write_text(f"run {number}")
        assert keep_earlier(path) == tmp_path / f"a.b.{number}.mcap"
        assert not path.exists()
    assert (tmp_path / "a.b.1.mcap").read_text() == "run 1"
    assert f"the earlier {path} is now {tmp_path / 'a.b.2.mcap'}" in capsys.readouterr().err


def test_a_drive_keeps_the_log_that_was_there(tmp_path: Path) -> None:
    log = tmp_path / "run.mcap"
    words = ["drive", "--readonly", "--virtual-time", "--duration", "0.2", "--log", str(log)]
    assert run(words) == 0
    first = log.read_bytes()
    assert run(words) == 0
    assert (tmp_path / "run.1.mcap").read_bytes() == first
    assert log.exists()


def test_a_corrected_robot_file_replaces_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "robot.toml"
    out.write_text("mine")
    diagnosis = tmp_path / "d.json"
    diagnosis.write_text(json.dumps({}))
    assert run(["gap", "apply", str(diagnosis), "--out", str(out)]) == 2
    assert "exists; choose another name" in capsys.readouterr().err
    assert out.read_text() == "mine"


def test_a_file_is_whole_or_not_there(tmp_path: Path) -> None:
    out = tmp_path / "video.gif"
    with whole_file(out) as part:
        part.write_text("whole")
        assert part.suffix == ".gif"
        assert not out.exists()
    assert out.read_text() == "whole"

    def fail() -> None:
        with whole_file(out) as part:
            part.write_text("hal")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert out.read_text() == "whole"
    assert [one.name for one in tmp_path.iterdir()] == ["video.gif"]


@pytest.mark.parametrize(
    ("name", "said"), [("no/such/a.json", "there is no folder"), ("folder", "is a folder")]
)
def test_what_cannot_be_written_is_refused_before_any_work(
    tmp_path: Path, name: str, said: str
) -> None:
    (tmp_path / "folder").mkdir()
    with pytest.raises(RecordError, match=said):
        check_room(tmp_path / name, "--json")
    check_room(tmp_path / "new.json", "--json")
    check_room(None, "--json")
