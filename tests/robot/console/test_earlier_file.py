"""Nothing that was measured is lost to the next run, and no half a file looks whole."""

import json
import os
from dataclasses import fields
from pathlib import Path

import pytest

from model.errors import RecordError
from record.earlier_file import earlier_files, keep_earlier
from record.whole_file import check_room, whole_file, write_text
from robot.cli.commands import COMMANDS, request_of
from robot.cli.main import run
from robot.console.arguments import WRITES


def test_an_earlier_file_gets_the_next_free_name(tmp_path: Path) -> None:
    path, notes = tmp_path / "a.b.mcap", list[str]()
    assert keep_earlier(path) is None
    path.touch()
    assert keep_earlier(path) is None  # empty: nothing to lose
    with earlier_files(overwrite=False, notify=notes.append):
        for number in (1, 2):
            path.write_text(f"run {number}")
            assert keep_earlier(path) == tmp_path / f"a.b.{number}.mcap"
            assert not path.exists()
    assert (tmp_path / "a.b.1.mcap").read_text() == "run 1"
    assert notes[1] == f"note: the earlier {path} is now {tmp_path / 'a.b.2.mcap'}"


def test_the_same_content_is_left_alone_and_other_content_is_kept(tmp_path: Path) -> None:
    path, notes = tmp_path / "a.html", list[str]()
    with earlier_files(overwrite=False, notify=notes.append):
        for text in ("one", "one", "two", "two"):
            write_text(path, text)
    assert path.read_text() == "two"
    assert (tmp_path / "a.1.html").read_text() == "one"
    assert sorted(one.name for one in tmp_path.iterdir()) == ["a.1.html", "a.html"]
    assert len(notes) == 1


def test_a_link_keeps_what_it_points_to(tmp_path: Path) -> None:
    (tmp_path / "data.txt").write_text("measured")
    (tmp_path / "latest.txt").symlink_to(tmp_path / "data.txt")
    write_text(tmp_path / "latest.txt", "new")
    assert (tmp_path / "data.txt").read_text() == "measured"
    assert (tmp_path / "latest.txt").read_text() == "new"


def test_devices_are_written_to_and_pipes_are_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_text(Path("/dev/null"), "gone")
    assert not Path("/dev/null").is_file()
    os.mkfifo(tmp_path / "pipe.mcap")
    with pytest.raises(RecordError, match="is a pipe"):
        write_text(tmp_path / "pipe.mcap", "waits for ever")
    words = ["drive", "--readonly", "--virtual-time", "--duration", "0.2"]
    assert run([*words, "--log", str(tmp_path / "pipe.mcap")]) == 4
    assert "is a pipe" in capfd.readouterr().err


def test_overwrite_replaces_what_was_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "robot.urdf"
    export = ["robot", "export", "--urdf", str(out)]
    out.write_text("mine")
    assert run([*export, "--overwrite"]) == 0
    assert [one.name for one in tmp_path.iterdir()] == ["robot.urdf"]
    assert run(export) == 0  # the same again
    assert [one.name for one in tmp_path.iterdir()] == ["robot.urdf"]
    assert not capsys.readouterr().err
    out.write_text("mine again")
    assert run(export) == 0
    assert (tmp_path / "robot.1.urdf").read_text() == "mine again"
    assert f"the earlier {out} is now {tmp_path / 'robot.1.urdf'}" in capsys.readouterr().err


def test_every_command_that_names_an_output_has_overwrite() -> None:
    # a campaign goes on with what is there; the others refuse what is there
    refuse = {"campaign make", "gap demo", "gap apply", "servo backup", "servo zero"}
    outputs = {"out", "save", "html", "report", "csv", "urdf", "log", "markdown", "robot_out"}
    for command in COMMANDS:
        request = request_of(command)
        names = {one.name for one in fields(request) if one.type is not bool}
        assert getattr(request, WRITES) == (bool(names & outputs) and command not in refuse), (
            command
        )


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
