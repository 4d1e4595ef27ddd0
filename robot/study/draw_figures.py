"""``bigant model figures``: every figure of the catalog, drawn into a folder with an index page."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib import rc_context

from gaits.names import METACHRONAL, TRIPOD
from model.errors import ConfigError
from record.whole_file import writing
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.progress import StatusLine
from robot.console.table import Column, table_lines
from robot.report.page import render
from robot.report.pictures import DOTS_PER_INCH
from robot.report.plots import STYLE
from robot.study.figure_catalog import CATALOG, Drawn, Entry, Material, Sources, choose

INDEX, TABLES = "index.html", "tables.txt"
TITLE = "Figures of the model of slipping"
Shown = tuple[Entry, Drawn, str]  # with the name of the picture beside the page; empty for none


@dataclass(frozen=True, slots=True)
class FiguresRequest:
    """What ``bigant model figures`` was asked for."""

    out: Path | None
    only: list[str]
    list: bool
    tripod: Path | None
    metachronal: Path | None
    cycles: float
    seed: int
    robot: Path
    benchmark: Path


def draw_figures(request: FiguresRequest) -> ExitCode:
    """List the figures, or draw those asked for.

    Raises:
        ConfigError: A figure that does not exist, no folder, or cycles that are none.
        RecordError: A log or the benchmark file cannot be read, or the folder not written.
    """
    if request.list:
        names = [(entry.name, f"{entry.title} ({entry.label})") for entry in CATALOG]
        print(*table_lines((Column(""), Column("")), names), sep="\n")
        return ExitCode.OK
    chosen = choose(request.only)
    out = request.out
    if out is None:
        raise ConfigError("--out", "is needed: the folder for the pictures")
    if not 0 < request.cycles < float("inf"):
        raise ConfigError("--cycles", f"must be a positive number, not {request.cycles:g}")
    given = ((TRIPOD, request.tripod), (METACHRONAL, request.metachronal))
    logs = tuple((gait, path) for gait, path in given if path is not None)
    robot = load_robot(request.robot)
    sources = Sources(robot, request.cycles, request.seed, logs, request.benchmark)
    with StatusLine() as line, writing(out), rc_context(STYLE):
        out.mkdir(parents=True, exist_ok=True)
        material = Material(
            sources, lambda share: line.say(f"the virtual robot walks: {100 * share:.0f} %")
        )
        rows = []
        for number, entry in enumerate(chosen, start=1):
            began = time.monotonic()
            row, done = _draw(entry, material, out)
            line.clear()
            spent_s = time.monotonic() - began
            print(f"[{number}/{len(chosen)}] {entry.name}: {done} ({spent_s:.1f} s)")
            rows.append(row)
        (out / INDEX).write_text(render_index(_origin(sources), rows), encoding="utf-8")
    print(f"index: {out / INDEX}")
    return ExitCode.OK


def _draw(entry: Entry, material: Material, out: Path) -> tuple[Shown, str]:
    """Draw an entry; return its part of the index, and the file or why there is none."""
    drawn = entry.draw(material)
    file_name, done = "", f"no picture: {drawn.caption}"
    if drawn.figure is not None:
        file_name = f"{entry.name}.png"
        drawn.figure.savefig(out / file_name, dpi=DOTS_PER_INCH)
        done = str(out / file_name)
    if drawn.table:
        (out / TABLES).write_text("\n".join(drawn.table), encoding="utf-8")
        done = str(out / TABLES)
    return (entry, drawn, file_name), done


def _origin(sources: Sources) -> str:
    logs = "".join(f"The {gait} walk is the log {path.name}. " for gait, path in sources.logs)
    return (
        f"{logs}{'Other walks' if logs else 'Walks'} are those of the virtual {sources.config.name}, "
        f"{sources.cycles:g} cycles, seed {sources.seed}, true values from its plant."
    )


def render_index(source: str, entries: Sequence[Shown]) -> str:
    """Return the index page.

    Args:
        source: Where the walks come from, one line.
        entries: Each with what was drawn and the name of its file, in order.
    """
    return render("figures.html", title=TITLE, source=source, entries=entries)
