"""Text of others cannot move the cursor, rename the window or turn the direction of writing."""

from pathlib import Path

import pytest

from drivers.ati.discovery import DiscoveredUnit, answer, parse_answer
from robot.cli.main import run
from robot.console.printable import printable, printable_screen

RENAME = "\x1b]0;mine\x07"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (RENAME, "\\x1b]0;mine\\x07"),
        ("a\rb\x9b2J", "a\\rb\\x9b2J"),
        ("\u202egpj.exe", "\\u202egpj.exe"),
        ("not a character: \udcff", "not a character: \\udcff"),
        ("two\nlines,\ta tab, \u00e4 and \u4e2d", "two\nlines,\ta tab, \u00e4 and \u4e2d"),
    ],
)
def test_control_characters_are_written_out(text: str, shown: str) -> None:
    assert printable(text) == shown


def test_a_screen_keeps_colours_only() -> None:
    assert printable_screen("\x1b[31mred\x1b[0m\x1b[2J") == "\x1b[31mred\x1b[0m\\x1b[2J"


def test_names_of_files_are_printed_safely(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / f"robot{RENAME}.urdf"
    assert run(["robot", "export", "--urdf", str(out)]) == 0
    assert run(["show", f"{RENAME}.mcap"]) == 4
    with pytest.raises(SystemExit):
        run(["show", "a.mcap", f"--no{RENAME}"])
    shown = capsys.readouterr()
    assert "\x1b" not in shown.out + shown.err
    assert "\\x1b]0;mine" in shown.out
    assert "\\x1b]0;mine" in shown.err


def test_a_unit_on_the_network_gives_letters_only() -> None:
    unit = DiscoveredUnit("192.0.2.1", "00:11:22:33:44:55", "Wireless F/T" + RENAME, "\x1b[2Jlab")
    parsed = parse_answer(answer(unit))
    assert parsed is not None
    assert parsed.text == "Wireless F/T]0;mine"
    assert parsed.location == "[2Jlab"
