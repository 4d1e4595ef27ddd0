"""Lines as wide as the terminal that they are for."""

import shutil
import sys
import textwrap

WIDTH, NARROWEST = 100, 60
COMMAND = "bigant "


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
