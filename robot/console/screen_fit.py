"""Text made to fit a terminal, and one redrawn in place: nothing wraps, nothing scrolls."""

import contextlib
import os
import re
import shutil
import sys
import textwrap
from collections.abc import Sequence
from typing import TextIO

from robot.console.printable import printable_screen, terminal_of

ESCAPE = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")
KEY_GAP = "  "
DOTS = "..."
WIDTH, NARROWEST = 100, 60  # of lines of text
COMMAND = "bigant "
CLEAR, HOME = "\x1b[2J\x1b[H", "\x1b[H"
CLEAR_TO_END_OF_LINE, CLEAR_BELOW = "\x1b[K", "\x1b[J"


def terminal_size(stream: TextIO) -> os.terminal_size:
    """Return columns and rows of the terminal behind a stream; 80 by 24 where there is none."""
    try:
        size = os.get_terminal_size(stream.fileno())
    except (OSError, ValueError):  # no terminal, or no file at all
        return shutil.get_terminal_size()
    return size if size.columns > 0 and size.lines > 0 else shutil.get_terminal_size()


def columns_of(stream: TextIO) -> int | None:
    """Return the columns of a terminal; None where a line may be as long as it is: a file, a pipe."""
    return terminal_size(stream).columns if stream.isatty() else None


def shortened(text: str, columns: int) -> str:
    """Return plain text of at most so many letters; dots stand for what was cut."""
    if len(text) <= columns:
        return text
    return text[: max(0, columns - len(DOTS))] + DOTS[: max(0, columns)]


def clipped(line: str, columns: int) -> str:
    """Return a line whose visible letters are at most so many; colours are kept, and end."""
    parts, left, at = [], columns, 0
    for escape in ESCAPE.finditer(line):
        letters = line[at : escape.start()][:left]
        parts += [letters, escape[0]]
        left, at = left - len(letters), escape.end()
    return "".join([*parts, line[at:][:left]])


def key_lines(text: str, columns: int) -> list[str]:
    """Return a line of keys as several, broken between keys, and inside one only at a space."""
    lines = [""]
    for key in text.split(KEY_GAP):
        pieces = [key] if len(key) <= columns else key.split(" ")
        for number, piece in enumerate(pieces):
            gap = KEY_GAP if number == 0 else " "
            longer = f"{lines[-1]}{gap}{piece}" if lines[-1] else piece
            if len(longer) <= columns or not lines[-1]:
                lines[-1] = longer
            else:
                lines.append(piece.lstrip())
    return lines


def fitted(
    title: str, body: Sequence[str], tail: Sequence[str], size: os.terminal_size
) -> list[str]:
    """Return a screen of at most so many lines and columns.

    Where it is too high, empty lines go first, then the end of the body; the title and the tail
    (what is wrong, and the keys) stay as long as there is any room.

    Args:
        title: First line.
        body: What is shown.
        tail: What has to be seen.
        size: Of the terminal.
    """
    lines = [title, *body, *tail]
    if len(lines) > size.lines:
        last = [line for line in tail if line][: max(0, size.lines - 1)]
        room = max(0, size.lines - 1 - len(last))
        lines = [title, *[line for line in body if line][:room], *last]
    return [clipped(line, size.columns) for line in lines]


def terminal_width() -> int:
    """Return how wide lines may be: the terminal's width within limits; without a terminal, the widest."""
    if not sys.stdout.isatty():
        return WIDTH
    return min(max(shutil.get_terminal_size().columns, NARROWEST), WIDTH)


def wrapped(line: str, width: int) -> list[str]:
    """A line that is too long as several, set in below its first; a command line stays whole."""
    if len(line) <= width or line.lstrip().startswith(COMMAND):
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    # a value stays with its error; a sentence goes on below its first letter, a list item behind its number
    kept = line.strip().replace(" +- ", "\xa0+-\xa0")
    deeper = 0 if kept[0].isupper() else 3 if kept[0].isdigit() else 2
    behind = indent + deeper * " "
    pieces = textwrap.wrap(
        kept, width, initial_indent=indent, subsequent_indent=behind, break_long_words=False,
        break_on_hyphens=False,
    )  # fmt: skip
    return [piece.replace("\xa0", " ") for piece in pieces]


class Screen:
    """A terminal that is redrawn in place.

    Args:
        out: The terminal.
    """

    def __init__(self, out: TextIO) -> None:
        self._out = terminal_of(out)
        self._before = CLEAR

    @property
    def columns(self) -> int:
        """How wide the terminal is now."""
        return terminal_size(self._out).columns

    def draw(self, title: str, body: Sequence[str], tail: Sequence[str]) -> None:
        """Draw one screen; the arguments are those of ``fitted``, but a long line of the tail is broken.

        Raises:
            OSError: The terminal went away.
        """
        size = terminal_size(self._out)
        broken = [
            piece
            for line in map(printable_screen, tail)
            for piece in _tail_lines(line, size.columns)
        ]
        # no line end behind the last line: it would scroll the title away
        lines = fitted(printable_screen(title), [*map(printable_screen, body)], broken, size)
        text = (CLEAR_TO_END_OF_LINE + "\r\n").join(lines)
        self._write(self._before + HOME + text + CLEAR_TO_END_OF_LINE + CLEAR_BELOW)
        self._before = ""

    def leave(self) -> None:
        """Begin a line below the screen for what is printed next; a terminal that went away is no error."""
        with contextlib.suppress(OSError):
            self._write("\r\n")

    def _write(self, text: str) -> None:
        self._out.write(text)
        self._out.flush()


def _tail_lines(line: str, columns: int) -> list[str]:
    return [line] if ESCAPE.search(line) else key_lines(line, columns)
