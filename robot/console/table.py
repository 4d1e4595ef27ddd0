"""Numbers and tables as text: a dash for what is not known, columns as wide as what is in them."""

import math
import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

GAP = "  "
LEAST_ROOM = 20
UNKNOWN = "-"
MINUS_ZERO = re.compile(r"-[0.]+%?")


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a table.

    Attributes:
        name: Its heading.
        form: How its numbers are written, such as ``.2f``; a column without a form holds texts, set to the
            left.
        width: Letters that it fills at least: a table that is drawn again and again must not jump.
    """

    name: str
    form: str = ""
    width: int = 0


def number_text(value: float, digits: int, width: int = 0) -> str:
    """Return a number with so many decimals, set to the right of ``width`` letters.

    Args:
        value: The number; NaN and infinity become a dash.
        digits: Decimals.
        width: Letters to fill at least.
    """
    return f"{formed(float(value), f'.{digits}f'):>{width}}"


def formed(value: object, form: str) -> str:
    """Return a cell: a number in a form, never -0; a dash for None, NaN and infinity."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return UNKNOWN
    if not form or not isinstance(value, int | float):
        return str(value)
    text = f"{value:{form}}"
    return text.removeprefix("-") if MINUS_ZERO.fullmatch(text) else text


def table_lines(
    columns: Sequence[Column], rows: Sequence[Sequence[object]], indent: str = ""
) -> list[str]:
    """Return a table with its heading; without any name of a column, only its rows.

    Args:
        columns: What each column is.
        rows: Texts and numbers, one a column; None and NaN are dashes.
        indent: In front of each line.
    """
    cells = [
        [formed(value, one.form) for one, value in zip(columns, row, strict=True)] for row in rows
    ]
    names = [one.name for one in columns]
    lines = [names, *cells] if any(names) else cells
    widths = [
        max(one.width, *(len(line[at]) for line in lines), 0) for at, one in enumerate(columns)
    ]
    return [
        indent
        + GAP.join(
            f"{text:>{width}}" if one.form else f"{text:<{width}}"
            for text, width, one in zip(line, widths, columns, strict=True)
        ).rstrip()
        for line in lines
    ]


def markdown_lines(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a table for a page of the documentation."""
    first, *others = [f"| {' | '.join(cells)} |" for cells in (head, *rows)]
    return [first, "|" + "---|" * len(head), *others]


def row_lines(rows: Sequence[tuple[str, str]], columns: int | None = None) -> list[str]:
    """Return labels with their texts; a text that is too long goes on below itself.

    Args:
        rows: Label and text.
        columns: Letters of a line; None: as long as it is.
    """
    width = max(len(label) for label, _ in rows)
    room = None if columns is None else max(LEAST_ROOM, columns - width - len(GAP))
    lines = []
    for label, text in rows:
        parts = [text] if room is None else textwrap.wrap(text, room) or [""]
        lines += [
            f"{head:<{width}}{GAP}{part}"
            for head, part in zip_longest((label,), parts, fillvalue="")
        ]
    return lines
