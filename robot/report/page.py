"""Every HTML report: self-contained, readable on a phone, in the dark, on paper and without scripts.

Markup, style and scripts stand in ``templates/``; Python gives them texts and pictures. Nothing is loaded
from anywhere. What is wider than a phone (tables, still pictures) scrolls sideways inside its own box; the
page does not.
"""

import html
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

MARKS = frozenset({"pass", "warn", "fail", "skip"})
SHORT = re.compile(r"[-\d.]+ \S{1,4}")
LONG_WORD = re.compile(r"\S{8,}")
BREAKS = re.compile(r"([_/]|\.(?=[a-z]))")
PLOT, REPLAY = "<figure class='plot'>", "<figure class='replay'>"
SWITCHES = "<div class='switches'>"
LIVE = "id='live'"
END = "</body></html>"
LIBRARY = "<script class='library'>"


@dataclass(frozen=True, slots=True)
class PagePicture:
    """A picture of a page: still, and what takes its place where scripts run.

    Attributes:
        name: What it shows, in a few words.
        svg: The still picture.
        moving: What the script of its kind draws, as JSON.
        says: What it shows, in a sentence or two; below it.
        kind: ``plot``, drawn by moving.js, or ``replay``, drawn by replay.js.
    """

    name: str
    svg: str
    moving: str
    says: str = ""
    kind: str = "plot"


@dataclass(frozen=True, slots=True)
class PageLink:
    """A cell of a table that is more than a text: a name with a link, or with a command.

    Attributes:
        name: What it is called.
        command: What to type; empty for nothing.
        link: Where a click leads, relative to the page; empty for nowhere.
    """

    name: str
    command: str = ""
    link: str = ""


@dataclass(frozen=True, slots=True)
class Section:
    """A part of a report; left out where it has neither rows nor facts nor a picture.

    Attributes:
        title: Heading; empty for none.
        rows: Texts: a label and its text each, or with ``head`` one a column.
        head: Names of the columns.
        numbers: Columns that are set to the right.
        picture: A picture.
        facts: A few numbers, set large, each with what it is a number of.
    """

    title: str
    rows: Sequence[Sequence[str | PageLink]] = ()
    head: Sequence[str] = ()
    numbers: Sequence[int] = ()
    picture: PagePicture | None = None
    facts: Sequence[tuple[str, str]] = ()


def report_page(
    title: str,
    note: str,
    sections: Sequence[Section],
    *,
    lead: PagePicture | None = None,
    verdict: str = "",
    kind: str = "",
    footer: str = "",
) -> str:
    """Return a page of tables and pictures.

    Args:
        title: Heading, and what the browser shows.
        note: One line below it.
        sections: Parts in their order. A cell of a table that is a verdict (pass, warn, fail, skip) is
            coloured.
        lead: The picture that the page begins with; None for none.
        verdict: The outcome in one sentence, below that picture; empty for none.
        kind: pass, warn or fail: the colour of the verdict.
        footer: Last line; empty for none.
    """
    return render("report.html", title=title, note=note, sections=sections, lead=lead,
                  verdict=verdict, kind=kind, footer=footer)  # fmt: skip


def render(template: str, **values: object) -> str:
    """Return a page made of a template; texts in it are escaped.

    Args:
        template: File in ``templates/``.
        values: What it names.
    """
    page: str = _templates().get_template(template).render(values)
    return page.replace(END, f"{_scripts(page)}{END}") if PLOT in page or REPLAY in page else page


def live_page(title: str) -> str:
    """Return the page of a run that goes on, whose server sends events; see ``robot.view.browser``."""
    return render("live.html", title=title)


def with_shared_library(page: str, file: str) -> str:
    """Return a page whose plots are drawn by a library in a separate file, for folders of many pages."""
    if LIBRARY not in page:
        return page
    before, rest = page.split(LIBRARY, 1)
    return f"{before}<script src='{html.escape(file)}'></script>{rest.split('</script>', 1)[1]}"


def script(name: str) -> str:
    """Return a script of ours in ``templates/``."""
    return (files("robot.report") / "templates" / name).read_text(encoding="utf-8")


def _scripts(page: str) -> str:
    """The scripts that a page needs, and no others."""
    scripts = []
    if PLOT in page:
        from robot.report.moving import library  # loaded only when a page is written

        scripts.append(f"{LIBRARY}{library()}</script>")
    names = ["moving.js"]
    names += [
        name
        for name, mark in (("replay.js", REPLAY), ("switches.js", SWITCHES), ("live.js", LIVE))
        if mark in page
    ]
    return "\n".join([*scripts, *(f"<script>{script(name)}</script>" for name in names), ""])


@cache
def _templates() -> Any:  # loaded only when a page is written
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("robot.report"), autoescape=True, undefined=StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.filters |= {"signed": signed, "breakable": _breakable, "kinds": _kinds}
    return environment


def signed(text: str) -> str:
    """Write +- as one sign, on one line with its numbers."""
    return text.replace(" +- ", "\xa0±\xa0").replace("+-", "±")


def _breakable(text: str) -> str:
    """A cell as HTML: a long name may break behind an underscore, a slash or the dot of a file."""
    words = html.escape(signed(text))
    return LONG_WORD.sub(lambda word: BREAKS.sub(r"\1<wbr>", word[0]), words)


def _kinds(text: str, number: bool) -> str:
    """Classes of a cell."""
    names = [*(["number"] if number else []), *([text] if text in MARKS else [])]
    if SHORT.fullmatch(text):
        names.append("short")  # a number stays on one line with its unit
    return " ".join(names)
