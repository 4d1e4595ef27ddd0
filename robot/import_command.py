"""``bigant import``: measured data from anywhere, checked, as a log or a trial.

Reads the trial table (.parquet or .csv with NAME.toml beside it), and any other table through a map of its
columns. Says what is absent, out of order, repeated, out of range, jumping or stuck. Nothing is dropped
without being listed.
"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from robot.exit_codes import ExitCode

if TYPE_CHECKING:
    from record.import_table import ImportReport
    from record.trial import Trial

SHOWN_ROWS = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("path", type=Path, metavar="TABLE", help=".parquet, .csv, or NAME.toml")
    parser.add_argument(
        "--columns", type=Path, metavar="MAP.toml", help="which of its columns is which of ours"
    )
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help="log (.mcap) or trial (.parquet, .csv) to write; "
        "without it, only the report",
    )  # fmt: skip
    parser.add_argument(
        "--report", type=Path, metavar="FILE", help="the whole report (.json, or text)"
    )
    parser.add_argument("--json", action="store_true", help="print the report as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Import a table.

    Raises:
        ConfigError: ``--out`` names no kind of file we write.
        RecordError: A file cannot be read or written, or nothing in the table is known.
    """
    from model.errors import ConfigError, RecordError
    from record.column_map import ColumnMap, read_column_map
    from record.import_table import import_table
    from record.trial_log import left_out
    from robot.plain_json import plain

    out: Path | None = options.out
    if out is not None and out.suffix not in {".mcap", ".parquet", ".csv"}:
        raise ConfigError("--out", f"must end in .mcap, .parquet or .csv, not {out}")
    given = read_column_map(options.columns) if options.columns is not None else ColumnMap()
    trial, report = import_table(options.path, given)
    text = json.dumps(plain(asdict(report)), indent=2) + "\n"
    if options.report is not None:
        whole = text if options.report.suffix == ".json" else "\n".join(_lines(report, None)) + "\n"
        try:
            options.report.write_text(whole, encoding="utf-8")
        except OSError as error:
            raise RecordError(
                f"{options.report} cannot be written: {error.strerror}; choose another --report"
            ) from error
    print(text.rstrip() if options.json else "\n".join(_lines(report, SHOWN_ROWS)))
    if out is not None:
        _write(trial, out, report)
        if not options.json:
            lost = left_out(trial) if out.suffix == ".mcap" else ()
            print(
                f"{out}: {report.kept} samples"
                + (f"; no place in a log for {', '.join(lost)}" if lost else "")
            )
    return ExitCode.OK


def _write(trial: "Trial", out: Path, report: "ImportReport") -> None:
    from model.errors import RecordError
    from record.trial import write_trial
    from record.trial_log import write_trial_log
    from robot.drive import software

    if out.resolve() == report.path.resolve():
        raise RecordError(f"{out} is the table itself; choose another --out")
    if out.suffix == ".mcap":
        write_trial_log(trial, out, software())
    else:
        write_trial(trial, out)


def _lines(report: "ImportReport", most_rows: int | None) -> list[str]:
    lines = [
        f"{report.path}: {report.rows} rows, {report.kept} kept, {len(report.dropped)} dropped, "
        f"{len(report.columns)} columns"
    ]
    shown = report.dropped[:most_rows]
    lines += [f"dropped   row {item.row}: {item.reason}" for item in shown]
    if len(report.dropped) > len(shown):
        lines.append(f"dropped   {len(report.dropped) - len(shown)} more, all in --report FILE")
    for finding in report.findings:
        row = f", first in row {finding.first_row}" if finding.first_row else ""
        count = f" x{finding.count}{row}" if finding.count else ""
        name = f" {finding.column}" if finding.column else ""
        lines.append(f"{finding.kind:<9}{name}{count}: {finding.detail}")
    if not report.findings and not report.dropped:
        lines.append("nothing odd found")
    return lines
