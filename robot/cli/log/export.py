"""``bigant log export``: a log as files that other programs read.

trial: NAME.parquet (or .csv, by --out), NAME.toml and the robot file; measured quantities only.
csv, parquet: a table with the columns of --what.
tum: trajectories NAME_estimate.tum, NAME_dead_reckoning.tum and NAME_truth.tum, for evo.
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode

FORMATS = ("trial", "csv", "parquet", "tum")
GROUPS = "joints,commands,forces,model,odometry,truth,loop"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument("--format", choices=FORMATS, required=True)
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="file to write (default: named after the log)"
    )
    parser.add_argument(
        "--what", metavar="A,B,...", help=f"columns of csv and parquet: raw and {GROUPS}; odometry is "
        "dead_reckoning,estimate (default: all but raw)",
    )  # fmt: skip


def run(options: argparse.Namespace) -> ExitCode:
    """Export a log."""
    from robot.report.log_files import ExportRequest, export

    return export(parsed(options, ExportRequest))
