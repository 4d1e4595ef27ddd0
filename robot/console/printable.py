"""Text from files, names and the network made safe for a terminal: control characters are written out."""

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any, TextIO, cast

COLOUR = re.compile(r"(\x1b\[[0-9;]*m)")
# All that moves the cursor, changes colours or turns the direction of writing, and what is no character
# at all (a file's name may hold any byte); line ends and tabs stay.
UNSAFE = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff]"
)


def printable(text: str) -> str:
    """Return a text whose control characters are written out, as Python writes them in its strings."""
    return UNSAFE.sub(lambda one: one[0].encode("unicode_escape").decode("ascii"), text)


def printable_screen(line: str) -> str:
    """Return a line of a screen of ours, which may hold colours."""
    pieces = COLOUR.split(line)
    return "".join(one if at % 2 else printable(one) for at, one in enumerate(pieces))


class _PrintableStream:
    """Standard output whose texts are made printable; a screen writes to the ``terminal`` behind it."""

    def __init__(self, terminal: TextIO) -> None:
        self.terminal = terminal

    def write(self, text: str) -> int:
        """Write a text."""
        return self.terminal.write(printable(text))

    def __getattr__(self, name: str) -> Any:  # everything else is the stream's own
        return getattr(self.terminal, name)


@contextmanager
def printable_output() -> Iterator[None]:
    """Make everything that the block prints on standard output printable."""
    with redirect_stdout(cast("TextIO", _PrintableStream(sys.stdout))):
        yield


def terminal_of(stream: TextIO) -> TextIO:
    """Return the stream that a screen moves the cursor of."""
    return stream.terminal if isinstance(stream, _PrintableStream) else stream
