"""Every figure and table of the paper that we can draw without its unpublished data."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from matplotlib import rc_context
from matplotlib.figure import Figure

from gaits.names import METACHRONAL, TRIPOD
from model.errors import ConfigError
from record.log.blocks.read import read_log
from record.whole_file import whole_file, write_text, writing
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.exit_codes import ExitCode
from robot.console.progress import StatusLine
from robot.console.table import Column, table_lines
from robot.report.page import render
from robot.report.pictures import DOTS_PER_INCH
from robot.report.plots import STYLE
from robot.requests.model import ModelFiguresRequest
from robot.study import (
    figures_errors,
    figures_examples,
    figures_forces,
    figures_search,
    figures_walk,
)
from robot.study.figures_runtime import draw_parallel, draw_runtime, read_benchmark
from robot.study.walk_comparison import WalkComparison, compare_walk
from robot.study.walk_errors import error_table
from robot.virtual.rehearsal import Progress
from robot.virtual.walk import walk_in_memory

TABLE_NOTE = (
    "RMS over all walking frames. Spread: the true values about their mean. Laws apart: viscous "
    "against Coulomb. The paper states relative figures only (its sensitivity to naive parameters: "
    "see `bigant model sensitivity`), a slip of -51.8 to 111.8 mm/s in the metachronal gait (5 to "
    "95 %), and that the laws are closer to each other than to the robot."
)


@dataclass(slots=True)
class Material:
    """What the figures are made of: virtual walks, or the logs in their place, and a benchmark file.

    Walks are made or read when a figure first asks for them. The benchmark file need not exist.
    """

    config: RobotConfig
    cycles: float
    seed: int
    logs: Mapping[str, Path]
    benchmark: Path
    progress: Progress
    _walks: dict[str, WalkComparison] = field(default_factory=dict)

    def walk(self, gait: str) -> WalkComparison:
        """Return the walk of a gait under both laws.

        Raises:
            RecordError: The log cannot be read.
            ModelError: It holds no walk, or the virtual robot stopped.
        """
        if gait not in self._walks:
            if gait in self.logs:
                log = read_log(self.logs[gait])
            else:
                log = walk_in_memory(
                    self.config, gait, cycles=self.cycles, seed=self.seed, progress=self.progress
                )
            self._walks[gait] = compare_walk(log)
        return self._walks[gait]


class Drawn(NamedTuple):
    """What is drawn for an entry of the index: a figure with our numbers beside the paper's, or a table.

    There is no figure where the entry is a table or its data are missing.
    """

    figure: Figure | None
    caption: str
    table: tuple[str, ...] = ()


class Entry(NamedTuple):
    """A figure that can be drawn: its name (also of its file), heading, and label in the paper."""

    name: str
    title: str
    label: str
    draw: Callable[[Material], Drawn]


def _plain(draw: Callable[[], tuple[Figure, str]]) -> Callable[[Material], Drawn]:
    return lambda _: Drawn(*draw())


def _of_walk(
    draw: Callable[[WalkComparison], tuple[Figure, str]], gait: str
) -> Callable[[Material], Drawn]:
    return lambda material: Drawn(*draw(material.walk(gait)))


def _tables(material: Material) -> Drawn:
    tables = [error_table(material.walk(gait)) for gait in (TRIPOD, METACHRONAL)]
    return Drawn(None, TABLE_NOTE, tuple(line for table in tables for line in (*table, "")))


CATALOG = (
    Entry("line", "One dimension: median and mean", "fig:1d_ex", _plain(figures_examples.draw_line)),
    Entry("force-field", "Two dimensions: total force over body velocity", "fig:fxy",
          _plain(figures_examples.draw_force_field)),
    Entry("friction-error", "Error of the ansatz around a slip velocity", "fig:Fv-Fc",
          _plain(figures_examples.draw_friction_error)),
    Entry("friction-family", "From Coulomb's law to the ansatz", "eqn:h2",
          _plain(figures_examples.draw_friction_family)),
    Entry("search-flat", "Search for the contacts, flat robot", "fig:robot_2d",
          _plain(figures_search.draw_search_line)),
    Entry("search-hexapod", "Search for the contacts, hexapod", "fig:search_3d",
          _plain(figures_search.draw_search_space)),
    Entry("tripod", "Tripod walk", "fig:FTbigAnt", _of_walk(figures_walk.draw_walk, TRIPOD)),
    Entry("tripod-forces", "Forces of all feet, tripod", "fig:tripod-all",
          _of_walk(figures_forces.draw_all_feet, TRIPOD)),
    Entry("tripod-errors", "Error distributions, tripod", "fig:err",
          _of_walk(figures_errors.draw_error_distributions, TRIPOD)),
    Entry("metachronal", "Metachronal gait: shafts, friction, forces", "fig:slipping_gait",
          _of_walk(figures_forces.draw_slipping_gait, METACHRONAL)),
    Entry("metachronal-walk", "Metachronal walk (not drawn in the paper)", "sec:results",
          _of_walk(figures_walk.draw_walk, METACHRONAL)),
    Entry("metachronal-forces", "Forces of all feet, metachronal", "fig:slipping-all",
          _of_walk(figures_forces.draw_all_feet, METACHRONAL)),
    Entry("metachronal-errors", "Error distributions of planar forces, metachronal",
          "fig:slipping_err", _of_walk(figures_errors.draw_planar_force_errors, METACHRONAL)),
    Entry("tables", "Errors, both laws and both gaits", "sec:results", _tables),
    Entry("runtime", "Run time against legs", "fig:run_time",
          lambda material: Drawn(*draw_runtime(read_benchmark(material.benchmark)))),
    Entry("parallel", "Parallel overhead", "fig:parallel",
          lambda material: Drawn(*draw_parallel(read_benchmark(material.benchmark)))),
)  # fmt: skip


INDEX, TABLES = "index.html", "tables.txt"
TITLE = "Figures of the model of slipping"


def draw_figures(request: ModelFiguresRequest) -> ExitCode:
    """List the figures, or draw those asked for.

    Raises:
        ConfigError: A figure that does not exist, no folder, or cycles that are none.
        RecordError: A log or the benchmark file cannot be read, or the folder not written.
    """
    if request.list:
        names = [(entry.name, f"{entry.title} ({entry.label})") for entry in CATALOG]
        print(*table_lines((Column(""), Column("")), names), sep="\n")
        return ExitCode.OK
    known = [entry.name for entry in CATALOG]
    for name in request.only:
        if name not in known:
            raise ConfigError("--only", f"{name!r} is no figure; choose from {', '.join(known)}")
    chosen = [entry for entry in CATALOG if not request.only or entry.name in request.only]
    out = request.out
    if out is None:
        raise ConfigError("--out", "is needed: the folder for the pictures")
    if not 0 < request.cycles < float("inf"):
        raise ConfigError("--cycles", f"must be a positive number, not {request.cycles:g}")
    given = ((TRIPOD, request.tripod), (METACHRONAL, request.metachronal))
    with StatusLine() as line, writing(out), rc_context(STYLE):
        out.mkdir(parents=True, exist_ok=True)
        material = Material(
            load_robot(request.robot),
            request.cycles,
            request.seed,
            {gait: path for gait, path in given if path is not None},
            request.benchmark,
            lambda share: line.say(f"the virtual robot walks: {100 * share:.0f} %"),
        )
        entries = []
        for number, entry in enumerate(chosen, start=1):
            began = time.monotonic()
            drawn = entry.draw(material)
            picture, done = "", f"no picture: {drawn.caption}"
            if drawn.figure is not None:
                picture = f"{entry.name}.png"
                done = str(out / picture)
                with whole_file(out / picture) as part:
                    drawn.figure.savefig(part, dpi=DOTS_PER_INCH)
            if drawn.table:
                done = str(out / TABLES)
                write_text(out / TABLES, "\n".join(drawn.table))
            line.clear()
            spent_s = time.monotonic() - began
            print(f"[{number}/{len(chosen)}] {entry.name}: {done} ({spent_s:.1f} s)")
            entries.append((entry, drawn, picture))
        page = render("figures.html", title=TITLE, source=_origin(material), entries=entries)
        write_text(out / INDEX, page)
    print(f"index: {out / INDEX}")
    return ExitCode.OK


def _origin(made: Material) -> str:
    logs = "".join(f"The {gait} walk is the log {path.name}. " for gait, path in made.logs.items())
    return (
        f"{logs}{'Other walks' if logs else 'Walks'} are those of the virtual {made.config.name}, "
        f"{made.cycles:g} cycles, seed {made.seed}, true values from its plant."
    )
