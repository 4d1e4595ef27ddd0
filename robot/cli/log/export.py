"""``bigant log export``: a log as files that other programs read.

trial: NAME.parquet (or .csv, by --out), NAME.toml and the robot file; measured quantities only.
csv, parquet: a table with the columns of --what.
tum: trajectories NAME_estimate.tum, NAME_dead_reckoning.tum and NAME_truth.tum, for evo.
"""

import argparse
from pathlib import Path

from robot.console.exit_codes import ExitCode

FORMATS = ("trial", "csv", "parquet", "tum")
GROUPS = "joints,commands,forces,model,odometry,truth,loop"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument("--format", choices=FORMATS, required=True, dest="kind")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="file to write (default: named after the log)"
    )
    parser.add_argument(
        "--what", metavar="A,B,...", help=f"columns of csv and parquet: raw and {GROUPS}; odometry is "
        "dead_reckoning,estimate (default: all but raw)",
    )  # fmt: skip


def run(options: argparse.Namespace) -> ExitCode:
    """Export a log.

    Raises:
        ConfigError: Options that do not fit each other.
        RecordError: A file cannot be read or written.
    """
    from model.errors import ConfigError
    from record.log.columns import check_groups
    from record.log.export import export_table, export_trial, export_tum
    from record.log.reader import LogContents
    from robot.console.progress import ProgressLine

    path, kind = options.path, options.kind
    if options.what is not None and kind not in {"csv", "parquet"}:
        raise ConfigError("--what", f"chooses columns of csv and parquet; {kind} has its own")
    out = _target(path, kind, options.out)
    contents = LogContents()
    with ProgressLine(f"reading {path}", contents.progress):
        if kind == "trial":
            written = export_trial(path, out, contents)
        elif kind == "tum":
            written = export_tum(path, out, contents)
        else:
            groups = check_groups(options.what if options.what is not None else GROUPS)
            written = export_table(path, out, groups, contents)
    if contents.damage:
        print(f"{path}: {contents.damage}")
    for file in written:
        print(f"{file.path}" + (f": {file.rows} rows" if file.rows else ""))
    if not written:
        print(f"{path} holds no pose that is known")
        return ExitCode.VERDICT_FAILED
    return ExitCode.OK


def _target(path: Path, kind: str, out: Path | None) -> Path:
    from model.errors import ConfigError

    suffixes = {"trial": (".parquet", ".csv"), "csv": (".csv",), "parquet": (".parquet",)}
    if kind == "tum":
        return out if out is not None else path.with_suffix("")
    if out is None:
        stem = path.stem + "_trial" if kind == "trial" else path.stem
        return path.with_name(stem + suffixes[kind][0])
    if out.suffix not in suffixes[kind]:
        raise ConfigError(
            "--out", f"must end in {' or '.join(suffixes[kind])} for {kind}, not {out}"
        )
    return out
