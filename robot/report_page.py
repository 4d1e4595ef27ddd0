"""One self-contained page: a table and pictures, readable on a phone, in dark mode and in print."""

import html
import io
import re
from collections.abc import Sequence

from matplotlib.figure import Figure

STYLE = """
:root { color-scheme: light dark; --ink: #1a1a1a; --paper: #ffffff; --faint: #6b6b6b; --line: #dddddd; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e8; --paper: #16181b; --faint: #9a9a9a; --line: #3a3d42; }
  figure svg { background: #ffffff; border-radius: 6px; }
}
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
       max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: 0; } h2 { font-size: 1.1rem; margin-top: 2rem; }
.note { color: var(--faint); margin-top: 0.2rem; }
table { border-collapse: collapse; width: 100%; }
th { text-align: left; font-weight: 500; color: var(--faint); width: 16rem; vertical-align: top; }
th, td { padding: 0.25rem 0.5rem; border-bottom: 1px solid var(--line); }
td { font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
figure { margin: 0.5rem 0; overflow-x: auto; } figure svg { width: 100%; height: auto; }
@media (max-width: 40rem) { th { width: 8rem; } }
@media print { body { margin: 0; } figure { break-inside: avoid; } }
"""


def render_page(
    title: str, note: str, rows: Sequence[tuple[str, str]], figures: dict[str, Figure]
) -> str:
    """Return the page.

    Args:
        title: Heading.
        note: One line below it.
        rows: Label and text of each row of the table.
        figures: Pictures by title.
    """
    table = "\n".join(
        f"<tr><th scope='row'>{html.escape(label)}</th><td>{html.escape(text)}</td></tr>"
        for label, text in rows
    )
    pictures = "\n".join(
        f"<h2>{html.escape(name)}</h2>\n<figure role='img' aria-label='{html.escape(name)}'>"
        f"{inline_svg(figure, str(number))}</figure>"
        for number, (name, figure) in enumerate(figures.items())
    )
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>\n"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style></head>\n"
        f"<body><h1>{html.escape(title)}</h1>\n<p class='note'>{html.escape(note)}</p>\n"
        f"<table>{table}</table>\n{pictures}\n</body></html>\n"
    )


def inline_svg(figure: Figure, number: str) -> str:
    """Return a picture as SVG; ids are made the page's own, or the first picture's clips win."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    text = buffer.getvalue()
    svg = text[text.index("<svg") :]
    svg = re.sub(r'\bid="([^"]+)"', rf'id="f{number}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#f{number}-\1)", svg)
    return re.sub(r'xlink:href="#([^"]+)"', rf'xlink:href="#f{number}-\1"', svg)
