"""``bigant gap diagnose``: where a simulator differs from measured runs, why, how far it shrinks.

Takes trial tables (.parquet or .csv with NAME.toml beside it) or logs. The machine's file that they name
picks the simulator. With --reference, runs of the same machine believed healthy, the question is what is
new; without, the simulator as it stands is compared with the runs. Some runs are held out and judge. Exit
code 0: a verdict was reached; 1: there is a gap that no effect of the catalogue explains.
"""

import argparse
import os
from pathlib import Path

from robot.console.arguments import parsed, seed
from robot.console.exit_codes import ExitCode
from robot.console.json_output import add_json

CHAIN, MUJOCO = "chain", "mujoco"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("trials", type=Path, nargs="+", metavar="TRIAL")
    parser.add_argument("--reference", type=Path, nargs="+", default=[], metavar="TRIAL",
        help="healthy runs of the same machine; what they show is no news")  # fmt: skip
    parser.add_argument("--joint", action="append", default=[], metavar="NAME",
        help="only this joint of a bench of servos; may be given again")  # fmt: skip
    parser.add_argument("--robot", type=Path, metavar="FILE",
        help="robot file to use for the trials (default: the one beside them)")  # fmt: skip
    add_json(parser, "the diagnosis")
    parser.add_argument("--html", type=Path, metavar="FILE", help="the diagnosis as one page")
    parser.add_argument("--effects", type=Path, metavar="FILE.py",
        help="effects of your own (run as Python: open only files that you trust)")  # fmt: skip
    parser.add_argument("--sim", choices=(CHAIN, MUJOCO), default=CHAIN,
        help="the chain of the model, or the MuJoCo robot (minutes)")  # fmt: skip
    parser.add_argument("--effects-only", type=_names, default=(), metavar="A,B",
        help="with --sim mujoco: effects to try (default: screened by the chain)")  # fmt: skip
    parser.add_argument("--screen", type=_jobs, default=4, metavar="N",
        help="with --sim mujoco: how many effects the chain lets through (default: 4)")  # fmt: skip
    parser.add_argument("--jobs", type=_jobs, default=min(os.cpu_count() or 1, 4), metavar="N",
        help="processes (default: one a core, up to 4)")  # fmt: skip
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of random draws")


def _names(text: str) -> tuple[str, ...]:
    return tuple(name for part in text.split(",") if (name := part.strip()))


def _jobs(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Diagnose."""
    from robot.gap_report.diagnose import DiagnoseRequest, diagnose_runs

    return diagnose_runs(parsed(options, DiagnoseRequest))
