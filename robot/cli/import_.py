"""``bigant import``: measured data from anywhere, checked, as logs or trials.

Reads the trial table (.parquet or .csv with NAME.toml beside it), and any other .csv, .parquet or .npz
through a map of its columns: your own file, or one of the maps that come with the program (--maps lists
them). Says what is absent, out of order, repeated, out of range, jumping, stuck, unsigned or empty, and
which faults of the data the diagnosis would see. Nothing is dropped without being listed.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_json, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("paths", type=Path, nargs="*", metavar="TABLE",
        help=".parquet, .csv, .npz, or NAME.toml; several with --out FOLDER")  # fmt: skip
    parser.add_argument("--map", "--columns", dest="map", metavar="NAME|MAP.toml",
        help="which of its columns is which of ours")  # fmt: skip
    parser.add_argument(
        "--maps", action="store_true", help="list the maps that come with the program"
    )
    parser.add_argument(
        "--out", type=Path, metavar="FILE|FOLDER", help="log (.mcap) or trial (.parquet, .csv) to write, "
        "or a folder for a trial (.parquet) of each table; without it, only the report",
    )  # fmt: skip
    parser.add_argument(
        "--report", type=Path, metavar="FILE", help="the whole report (.json, or text)"
    )
    add_json(parser, "the report")


def run(options: argparse.Namespace) -> ExitCode:
    """Import tables, or list the maps."""
    if options.maps:
        from robot.gap_report.imports import list_maps

        return list_maps(as_json=options.json)
    from robot.gap_report.imports import ImportRequest, bring_in

    return bring_in(parsed(options, ImportRequest))
