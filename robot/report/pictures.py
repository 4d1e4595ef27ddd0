"""Figures as pictures in a page, and as separate files."""

import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from record.whole_file import whole_file, write_text
from robot.report.moving import moving_json
from robot.report.page import PagePicture, Section, report_page
from robot.report.thinning import kept_rows

# Coordinates in a picture that matplotlib writes with six digits: of long curves, all but scales.
PATH = re.compile(r'(<path d="|points=")([^"]*)"')
SPACES = re.compile(r"\s+")
LONG_NUMBER = re.compile(r"-?\d+\.\d+")
# What is black, white or grey in a picture takes the page's colours: it must be seen in the dark, too.
PAGE_COLOURS = (
    ("#000000", "currentColor"),
    ("#333333", "currentColor"),
    ("#dddddd", "var(--line)"),
    ("#ffffff", "var(--paper)"),
    ("#555555", "var(--faint)"),
)
DOTS_PER_INCH = 130


def write_report(
    out: Path,
    title: str,
    note: str,
    rows: Sequence[tuple[str, str]],
    figures: Mapping[str, Figure],
    sentence: str = "",
) -> tuple[Path, ...]:
    """Write pictures with a table below them as a page, or the pictures alone as PNGs; return the files.

    Args:
        out: .html, or .png: each picture then becomes a file of its own, NAME-TITLE.png.
        title: Heading.
        note: One line below it.
        rows: Label and text of each row of the table.
        figures: Pictures by title; a page begins with the first.
        sentence: The outcome, below that one.

    Raises:
        RecordError: A file cannot be written.
    """
    if out.suffix != ".png":
        first, *others = pictures(figures)
        parts = [*others, Section("Numbers", rows)]
        write_text(out, report_page(title, note, parts, lead=first.picture, verdict=sentence))
        return (out,)
    return save_pictures(out, figures)


def save_pictures(out: Path, figures: Mapping[str, Figure]) -> tuple[Path, ...]:
    """Write each picture to a PNG of its own, NAME-TITLE.png beside ``out``; return the files.

    Raises:
        RecordError: A file cannot be written.
    """
    saved = []
    for name, figure in figures.items():
        target = out.with_name(f"{out.stem}-{name.lower().replace(' ', '-')}.png")
        with whole_file(target) as part:
            figure.savefig(part, dpi=DOTS_PER_INCH)
        saved.append(target)
    return tuple(saved)


def pictures(figures: Mapping[str, Figure]) -> list[Section]:
    """Return each picture under its title."""
    return [
        Section(name, picture=page_picture(figure, name, str(number)))
        for number, (name, figure) in enumerate(figures.items())
    ]


def page_picture(figure: Figure, name: str, number: str, says: str = "") -> PagePicture:
    """Return a figure as a still picture with plots to take its place; its curves are thinned for both."""
    plots = moving_json(figure)
    for ax in figure.axes:
        most = round(float(ax.get_window_extent().width))  # a point for each of its pixels
        for line in ax.lines:
            x, y = (np.asarray(one, dtype=np.float64) for one in line.get_data())
            rows = kept_rows(x, y, most)
            line.set_data(x[rows], y[rows])
    return PagePicture(name, inline_svg(figure, number), plots, says)


def inline_svg(figure: Figure, number: str) -> str:
    """Return a picture as SVG whose ids begin with ``fNUMBER-``: two pictures of a page share none."""
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


def _rounded(path: re.Match[str]) -> str:
    """Places of a path to a tenth of a point, which no eye sees, in a third of the letters."""
    text = LONG_NUMBER.sub(lambda number: f"{float(number[0]):.1f}".removesuffix(".0"), path[2])
    return f'{path[1]}{SPACES.sub(" ", text).strip()}"'
