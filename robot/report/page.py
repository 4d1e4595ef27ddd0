"""The frame and style of every HTML report: self-contained, readable on a phone, in the dark and on paper.

A report is ``page_frame(title, parts)`` with parts made by the functions here. Nothing is loaded from
anywhere. What is wider than a phone (tables, pictures) scrolls sideways inside its own box; the page
does not.
"""

import html
import io
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import RecordError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLE = """
:root { color-scheme: light dark; --ink: #1a1a1a; --paper: #ffffff; --faint: #5f5f5f; --line: #dddddd;
        --good: #00745a; --warn: #8a5a00; --bad: #b33c00; --accent: #0072b2; --panel: #f5f6f7;
        --shade: rgba(0, 0, 0, 0.3); }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e8; --paper: #16181b; --faint: #a6a6a6; --line: #3a3d42;
          --good: #4cc9a0; --warn: #f0b43c; --bad: #ff8a4c; --accent: #56b4e9; --panel: #202327;
          --shade: rgba(255, 255, 255, 0.35); }
  figure img { background: #ffffff; border-radius: 6px; }
}
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
       max-width: 60rem; margin: 2rem auto; padding: 0 1rem; overflow-wrap: break-word; }
h1 { font-size: 1.5rem; line-height: 1.25; margin-bottom: 0; }
h2 { font-size: 1.1rem; margin: 2rem 0 0.5rem; } h2 small { font-weight: 400; color: var(--faint); }
.note, figcaption, footer { color: var(--faint); margin-top: 0.2rem; }
.verdict { font-size: 1.25rem; border-left: 0.4rem solid var(--accent); padding: 0.4rem 0 0.4rem 0.8rem; }
.verdict.pass { border-color: var(--good); } .verdict.warn { border-color: var(--warn); }
.verdict.fail { border-color: var(--bad); }
.scroll { overflow-x: auto; }
/* A shade at the edge behind which a table or a picture goes on; at its end, paper moves over the shade. */
.scroll, div.wide, figure { background:
  linear-gradient(to right, var(--paper) 35%, transparent) 0 0 / 3rem 100% no-repeat local,
  linear-gradient(to left, var(--paper) 35%, transparent) 100% 0 / 3rem 100% no-repeat local,
  linear-gradient(to right, var(--shade), transparent) 0 0 / 0.9rem 100% no-repeat scroll,
  linear-gradient(to left, var(--shade), transparent) 100% 0 / 0.9rem 100% no-repeat scroll; }
@media print { .scroll, div.wide, figure { background: none; } }
table { border-collapse: collapse; width: 100%; }
th { text-align: left; font-weight: 500; color: var(--faint); vertical-align: top; }
th[scope=row] { width: 16rem; }
th, td { padding: 0.25rem 0.5rem; border-bottom: 1px solid var(--line); vertical-align: top; }
td { font-variant-numeric: tabular-nums; } td.number, th.number { text-align: right; }
table:not(.wide) td:last-child { overflow-wrap: anywhere; }
td.pass, td.warn, td.fail, td.skip, td.short { white-space: nowrap; }
td.pass, .verdict.pass { color: var(--good); } td.warn, .verdict.warn { color: var(--warn); }
td.fail, .verdict.fail { color: var(--bad); } td.skip { color: var(--faint); }
td.pass, td.warn, td.fail { font-weight: 600; }
code { font-size: 0.9em; }
pre { overflow-x: auto; font-size: 0.8rem; background: var(--panel); padding: 0.6rem; }
figure { margin: 0.5rem 0; overflow-x: auto; }
figure svg, figure img { display: block; width: 100%; height: auto; }
figure svg { fill: currentColor; }
@media (max-width: 40rem) {
  body { margin: 1rem auto; } th[scope=row] { width: 7.5rem; }
  figure svg, figure img { min-width: 40rem; }
  table.wide { min-width: 40rem; } body > table { display: block; overflow-x: auto; }
}
@media print {
  :root { color-scheme: light; --ink: #000000; --paper: #ffffff; --faint: #444444; --line: #bbbbbb;
          --good: #00543f; --warn: #6b4600; --bad: #8c2f00; --panel: #ffffff; }
  body { margin: 0; max-width: none; font-size: 11pt; } .scroll, figure, pre { overflow: visible; }
  pre { white-space: pre-wrap; } figure, tr { break-inside: avoid; } h2 { break-after: avoid; }
  details::details-content { display: block; content-visibility: visible; }
}
"""
# More cells in a row than this do not fit a phone; the table then scrolls instead of breaking words.
NARROW_CELLS = 3
# Coordinates in a picture that matplotlib writes with six digits: of long curves, all but scales.
PATH = re.compile(r'(<path d="|points=")([^"]*)"')
SPACES = re.compile(r"\s+")
LONG_NUMBER = re.compile(r"-?\d+\.\d+")
SHORT = re.compile(r"[-\d.]+ \S{1,4}")
# What is black, white or grey in a picture takes the page's colours: it must be seen in the dark, too.
PAGE_COLOURS = (
    ("#000000", "currentColor"),
    ("#333333", "currentColor"),
    ("#dddddd", "var(--line)"),
    ("#ffffff", "var(--paper)"),
    ("#555555", "var(--faint)"),
)
MARKS = frozenset({"pass", "warn", "fail", "skip"})


def page_frame(title: str, parts: Iterable[str], *, style: str = "") -> str:
    """Return a whole page.

    Args:
        title: What the browser shows; the heading is a part like the others (``heading``).
        parts: HTML of the page in its order; empty ones are left out.
        style: Rules of this report alone, behind the common ones.
    """
    body = "\n".join(part for part in parts if part)
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>\n"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        "<link rel='icon' href='data:,'>\n"
        f"<title>{html.escape(title)}</title>\n<style>{STYLE}{style}</style></head>\n"
        f"<body>{body}\n</body></html>\n"
    )


def heading(title: str, note: str = "") -> str:
    """Return the page's heading and a line below it."""
    below = f"\n<p class='note'>{html.escape(note)}</p>" if note else ""
    return f"<h1>{html.escape(title)}</h1>{below}"


def section(title: str, content: str) -> str:
    """Return content under a heading; nothing if there is none."""
    return f"<h2>{html.escape(title)}</h2>\n{content}" if content else ""


def rows_table(rows: Sequence[tuple[str, str]]) -> str:
    """Return a table of labels with their texts."""
    lines = "\n".join(
        f"<tr><th scope='row'>{html.escape(label)}</th><td>{html.escape(text.replace('+-', '±'))}</td></tr>"
        for label, text in rows
    )
    return f"<div class='scroll'><table class='rows'>{lines}</table></div>" if rows else ""


def grid_table(
    head: Sequence[str], rows: Sequence[Sequence[str]], numbers: Sequence[int] = ()
) -> str:
    """Return a table with a heading; a cell that is a verdict (pass, warn, fail, skip) is coloured.

    Args:
        head: Name of each column.
        rows: Texts.
        numbers: Columns that are set to the right.
    """
    if not rows:
        return ""

    def kind(at: int, text: str) -> str:
        names = [*(["number"] if at in numbers else []), *([text] if text in MARKS else [])]
        if SHORT.fullmatch(text):
            names.append("short")  # a number stays on one line with its unit
        return f" class='{' '.join(names)}'" if names else ""

    top = "".join(
        f"<th scope='col'{kind(i, '')}>{html.escape(one)}</th>" for i, one in enumerate(head)
    )
    body = "\n".join(
        "<tr>" + "".join(f"<td{kind(i, c)}>{html.escape(c)}</td>" for i, c in enumerate(row)) + "</tr>"
        for row in rows
    )  # fmt: skip
    wide = " class='wide'" if len(head) > NARROW_CELLS else ""
    return (
        f"<div class='scroll'><table{wide}><thead><tr>{top}</tr></thead>\n"
        f"<tbody>{body}</tbody></table></div>"
    )


def pictures(figures: "dict[str, Figure]") -> list[str]:
    """Return each picture under its title."""
    return [
        section(
            name,
            f"<figure role='img' aria-label='{html.escape(name, quote=True)}'>"
            f"{inline_svg(figure, str(number))}</figure>",
        )
        for number, (name, figure) in enumerate(figures.items())
    ]


def render_page(
    title: str, note: str, rows: Sequence[tuple[str, str]], figures: "dict[str, Figure]"
) -> str:
    """Return a page of one table and pictures.

    Args:
        title: Heading.
        note: One line below it.
        rows: Label and text of each row of the table.
        figures: Pictures by title.
    """
    return page_frame(title, [heading(title, note), rows_table(rows), *pictures(figures)])


def write_page(path: Path, text: str, option: str = "--html") -> None:
    """Write a page.

    Raises:
        RecordError: It cannot be written.
    """
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise RecordError(
            f"{path} cannot be written: {error.strerror}; choose another {option}"
        ) from error


def _rounded(path: re.Match[str]) -> str:
    """Places of a path to a tenth of a point, which no eye sees, in a third of the letters."""
    text = LONG_NUMBER.sub(lambda number: f"{float(number[0]):.1f}".removesuffix(".0"), path[2])
    return f'{path[1]}{SPACES.sub(" ", text).strip()}"'


def inline_svg(figure: "Figure", number: str) -> str:
    """Return a picture as SVG; ids are made the page's own, or the first picture's clips win."""
    import matplotlib as mpl

    buffer = io.StringIO()
    # Text stays text (small, searchable, and a test can see whether it overlaps) and ids do not change from
    # run to run; both are read when a picture is saved, not when it is drawn.
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "bigant"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None}, transparent=True)
    text = buffer.getvalue()
    svg = PATH.sub(_rounded, text[text.index("<svg") :])
    for fixed, of_page in PAGE_COLOURS:
        for property_ in ("stroke", "fill"):
            svg = svg.replace(f"{property_}: {fixed}", f"{property_}: {of_page}")
    svg = re.sub(r'\bid="([^"]+)"', rf'id="f{number}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#f{number}-\1)", svg)
    return re.sub(r'xlink:href="#([^"]+)"', rf'xlink:href="#f{number}-\1"', svg)
