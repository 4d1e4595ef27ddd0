"""Text that fits a terminal, and what a busy computer is told."""

import os

import pytest

from gaits.catalog import make_gaits
from robot.config.robot_file import load_robot
from robot.console.screen_fit import clipped, fitted, key_lines, shortened
from robot.control.modes import GaitBook
from robot.report.summary_text import busy_words
from robot.run.teleop import help_line
from robot.view.screen import BOLD, RESET

ROBOT = load_robot().parameters
KEYS = help_line(GaitBook.of(make_gaits(ROBOT), ROBOT.servo))


@pytest.mark.parametrize("columns", [20, 60, 80, 200])
def test_keys_break_between_words_and_none_is_lost(columns: int) -> None:
    lines = key_lines(KEYS, columns)
    assert max(map(len, lines)) <= columns
    assert " ".join(lines).split() == KEYS.split()
    assert (len(lines) == 1) is (columns >= len(KEYS))


def test_a_colour_takes_no_room_and_ends_where_the_line_is_cut() -> None:
    line = f"{BOLD}abcdef{RESET}gh"
    assert clipped(line, 8) == line
    assert clipped(line, 3) == f"{BOLD}abc{RESET}"


def test_what_is_shortened_says_so() -> None:
    assert shortened("abcdefgh", 8) == "abcdefgh"
    assert shortened("abcdefghi", 8) == "abcde..."
    assert len(shortened("abcdefghi", 2)) == 2


def test_title_and_tail_stay_when_the_body_does_not_fit() -> None:
    body, tail = ["a", "", "b", "c"], ["", "fault", "keys"]
    size = os.terminal_size((80, 9))
    assert fitted("title", body, tail, size) == ["title", *body, *tail]
    size = os.terminal_size((80, 5))
    assert fitted("title", body, tail, size) == ["title", "a", "b", "fault", "keys"]


@pytest.mark.parametrize(
    ("missed", "ticks", "virtual", "words"),
    [
        (
            39,
            1604,
            True,
            ("39 of 1643 periods never ran", "--virtual-time", "bigant check --computer"),
        ),
        (39, 1604, False, ("39 of 1643 periods never ran", "bigant check --computer")),
    ],
)
def test_a_busy_computer_is_named_with_what_to_do(
    missed: int, ticks: int, virtual: bool, words: tuple[str, ...]
) -> None:
    told = busy_words(missed, ticks, virtual=virtual)
    assert "\n" not in told
    assert [word for word in words if word not in told] == []
    assert ("--virtual-time" in told) is virtual


def test_a_computer_that_keeps_up_is_told_nothing() -> None:
    assert busy_words(20, 980, virtual=True) == ""
    assert busy_words(0, 0, virtual=True) == ""
