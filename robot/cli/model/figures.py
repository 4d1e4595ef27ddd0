"""``bigant model figures``: our version of every figure of the paper that needs no unpublished data."""

import argparse
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from gaits.names import GAIT_NAMES, METACHRONAL, TRIPOD
from model.errors import ConfigError, RecordError
from robot.console.arguments import seed
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from robot.study.figure_catalog import Entry, Material
    from robot.study.figure_index import Row

ROOT = Path(__file__).resolve().parent.parent.parent.parent
BENCHMARK = ROOT / "docs" / "figures" / "model_benchmark.json"
DOTS_PER_INCH = 130
INDEX, TABLES = "index.html", "tables.txt"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder for pictures and index.html"
    )
    parser.add_argument("--only", action="append", default=[], metavar="NAME",
                        help="draw only this figure; may be given several times")  # fmt: skip
    parser.add_argument("--list", action="store_true", help="list the figures and end")
    for gait in GAIT_NAMES:
        parser.add_argument(f"--{gait}", type=Path, metavar="LOG",
                            help=f"use this log in place of a virtual {gait} walk")  # fmt: skip
    parser.add_argument("--cycles", type=float, default=3.0, metavar="N",
                        help="cycles of each virtual walk (default: 3)")  # fmt: skip
    parser.add_argument("--seed", type=seed, default=0, help="seed of the virtual robot")
    parser.add_argument("--robot", type=Path, metavar="FILE",
                        default=ROOT / "config" / "bigant.toml",
                        help="robot file of the virtual walks (default: config/bigant.toml)")  # fmt: skip
    parser.add_argument("--benchmark", type=Path, metavar="FILE", default=BENCHMARK,
                        help="file of benchmark figures")  # fmt: skip


def run(options: argparse.Namespace) -> ExitCode:
    """Draw the figures asked for.

    Raises:
        ConfigError: A figure that does not exist, no folder, or cycles that are none.
        RecordError: A log or the benchmark file cannot be read, or the folder not written.
    """
    from robot.study.figure_catalog import CATALOG, Material, Sources, choose

    if options.list:
        width = max(len(entry.name) for entry in CATALOG)
        for entry in CATALOG:
            print(f"{entry.name:<{width}}  {entry.title} ({entry.label})")
        return ExitCode.OK
    chosen = choose(options.only)
    if options.out is None:
        raise ConfigError("--out", "is needed: the folder for the pictures")
    if not 0 < options.cycles < float("inf"):
        raise ConfigError("--cycles", f"must be a positive number, not {options.cycles:g}")
    from robot.config.robot_file import load_robot

    given = ((TRIPOD, options.tripod), (METACHRONAL, options.metachronal))
    logs = tuple((gait, path) for gait, path in given if path is not None)
    sources = Sources(
        load_robot(options.robot), options.cycles, options.seed, logs, options.benchmark
    )
    _draw_all(chosen, Material(sources, _Meter()), options.out)
    return ExitCode.OK


class _Meter:
    """Says on stderr how far a virtual walk is, a few times."""

    def __init__(self) -> None:
        self._told = -1

    def __call__(self, share: float) -> None:
        tenth = int(10 * share)
        if tenth != self._told:
            self._told = tenth
            print(f"  the virtual robot walks: {10 * tenth} %", file=sys.stderr)


def _draw_all(chosen: "tuple[Entry, ...]", material: "Material", out: Path) -> None:
    from matplotlib import rc_context

    from robot.report.plots import STYLE
    from robot.study.figure_index import render_index

    rows = []
    try:
        out.mkdir(parents=True, exist_ok=True)
        with rc_context(STYLE):
            for number, entry in enumerate(chosen, start=1):
                rows.append(_draw_one(entry, material, out, f"[{number}/{len(chosen)}]"))
        (out / INDEX).write_text(render_index(_origin(material), rows), encoding="utf-8")
    except OSError as error:
        raise RecordError(
            f"{out} cannot be written: {error.strerror}; choose another --out"
        ) from error
    print(f"index: {out / INDEX}")


def _draw_one(entry: "Entry", material: "Material", out: Path, count: str) -> "Row":
    from robot.study.figure_index import Row

    begin = time.monotonic()
    drawn = entry.draw(material)
    file_name = ""
    if drawn.figure is not None:
        file_name = f"{entry.name}.png"
        drawn.figure.savefig(out / file_name, dpi=DOTS_PER_INCH)
    if drawn.table:
        (out / TABLES).write_text("\n".join(drawn.table), encoding="utf-8")
        file = out / TABLES
    else:
        file = out / file_name
    done = str(file) if file != out else f"no picture: {drawn.caption}"
    print(f"{count} {entry.name}: {done} ({time.monotonic() - begin:.1f} s)")
    return Row(entry.title, entry.label, file_name, drawn.caption, drawn.table)


def _origin(material: "Material") -> str:
    sources = material.sources
    logs = "".join(f"The {gait} walk is the log {path.name}. " for gait, path in sources.logs)
    walks = "Other walks" if logs else "Walks"
    return (
        f"{logs}{walks} are those of the virtual {sources.config.name}, {sources.cycles:g} cycles, seed "
        f"{sources.seed}, true values from its plant."
    )
