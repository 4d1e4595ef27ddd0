"""``bigant model figures``: our version of every figure of the paper that needs no unpublished data."""

import argparse
from pathlib import Path

from gaits.names import GAIT_NAMES
from robot.console.arguments import ROOT, add_robot, parsed, seed
from robot.console.exit_codes import ExitCode


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
    add_robot(parser, "robot file of the virtual walks (default: config/bigant.toml)")
    parser.add_argument("--benchmark", type=Path, metavar="FILE", help="file of benchmark figures",
                        default=ROOT / "docs" / "figures" / "model_benchmark.json")  # fmt: skip


def run(options: argparse.Namespace) -> ExitCode:
    """Draw the figures asked for."""
    from robot.study.figure_catalog import FiguresRequest, draw_figures

    return draw_figures(parsed(options, FiguresRequest))
