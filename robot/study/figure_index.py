"""The index page of our figures: pictures by file name, with captions."""

import html
from collections.abc import Sequence
from dataclasses import dataclass

from robot.report.page import page_frame

TITLE = "Figures of the model of slipping"
OTHERS = (
    "The multipods, the quadruped and the disk are drawn by <code>bigant model run</code>, the "
    "sensitivity to naive parameters by <code>bigant model sensitivity</code>."
)


@dataclass(frozen=True, slots=True)
class Row:
    """One entry of the page.

    Attributes:
        title: Heading.
        label: The paper's label.
        file_name: Picture beside the page; empty if there is none.
        caption: Text below it.
        table: Lines of a table in text.
    """

    title: str
    label: str
    file_name: str
    caption: str
    table: tuple[str, ...]


def render_index(source: str, rows: Sequence[Row]) -> str:
    """Return the page.

    Args:
        source: Where the walks come from, one line.
        rows: Entries in order.
    """
    note = (
        f"<h1>{TITLE}</h1>\n"
        f"<p class='note'>Our versions of the figures of Wu, Zhao and Revzen (arXiv:2310.20669). "
        f"{html.escape(source)} Truth red, viscous-Coulomb orange, Coulomb blue, spring support "
        f"purple.</p>\n<p>{OTHERS}</p>"
    )
    return page_frame(TITLE, [note, *(_section(row) for row in rows)])


def _section(row: Row) -> str:
    picture = (
        f"<img src='{html.escape(row.file_name)}' alt='{html.escape(row.title)}'>"
        if row.file_name
        else ""
    )
    table = f"<pre>{html.escape(chr(10).join(row.table))}</pre>" if row.table else ""
    return (
        f"<h2>{html.escape(row.title)} <small>({html.escape(row.label)})</small></h2>\n{table}"
        f"<figure>{picture}<figcaption>{html.escape(row.caption)}</figcaption></figure>"
    )
