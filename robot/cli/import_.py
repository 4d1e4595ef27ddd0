"""``bigant import``: measured data from anywhere, checked, as logs or trials.

Reads the trial table (.parquet or .csv with NAME.toml beside it), and any other .csv, .parquet or .npz
through a map of its columns: your own file, or one of the maps that come with the program (--maps lists
them). Says what is absent, out of order, repeated, out of range, jumping, stuck, unsigned or empty, and
which faults of the data the diagnosis would see. Nothing is dropped without being listed.
"""

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from record.trial.column_map import ColumnMap
    from record.trial.import_table import Imported
    from robot.cli.import_report import Told

SUFFIXES = (".mcap", ".parquet", ".csv")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
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
    parser.add_argument("--json", action="store_true", help="print the report as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Import tables.

    Raises:
        ConfigError: ``--out`` names no kind of file we write, or there is nothing to import.
        RecordError: A file cannot be read or written, or nothing in the table is known.
    """
    from model.errors import ConfigError, RecordError
    from record.trial.column_map import ColumnMap, find_map, read_column_map
    from robot.cli.import_report import all_lines, lines_of_one, report_json

    if options.maps:
        return _list_maps(as_json=options.json)
    if not options.paths:
        raise ConfigError("TABLE", "name a table to import, or --maps to list the maps")
    given = read_column_map(find_map(options.map)) if options.map is not None else ColumnMap()
    out: Path | None = options.out
    folder = out is not None and not out.suffix
    if out is not None and not folder and out.suffix not in SUFFIXES:
        raise ConfigError(
            "--out", f"must end in .mcap, .parquet or .csv, or be a folder, not {out}"
        )
    if len(options.paths) > 1 and out is not None and not folder:
        raise ConfigError("--out", f"several tables need a folder, not {out}")
    told = _import_all(options.paths, given, out, folder=folder)
    text = json.dumps(report_json(told), indent=2) + "\n"
    if options.report is not None:
        whole = text if options.report.suffix == ".json" else "\n".join(all_lines(told)) + "\n"
        try:
            options.report.write_text(whole, encoding="utf-8")
        except OSError as error:
            raise RecordError(
                f"{options.report} cannot be written: {error.strerror}; choose another --report"
            ) from error
    short = lines_of_one(told[0]) if len(told) == 1 else all_lines(told)
    print(text.rstrip() if options.json else "\n".join(short))
    if out is not None and not options.json:
        print(_written(told, out, folder=folder))
    return ExitCode.OK


def _import_all(
    paths: "Sequence[Path]", given: "ColumnMap", out: Path | None, *, folder: bool
) -> "tuple[Told, ...]":
    from model.errors import RecordError
    from record.trial.import_table import import_tables
    from robot.cli.import_report import Told, data_faults
    from robot.console.progress import ProgressBar

    told = []
    with ProgressBar("import") as bar:
        for number, path in enumerate(paths):

            def tell(share: float, number: int = number, path: Path = path) -> None:
                bar.show((number + share) / len(paths), path.name)

            # reading and writing take about as long
            found = tuple(import_tables(path, given, lambda share: tell(0.5 * share)))
            if len(found) > 1 and out is not None and not folder:
                raise RecordError(
                    f"{path} holds {len(found)} tables; give --out a folder, not {out}"
                )
            for at, one in enumerate(found):
                tell(0.5 + 0.5 * at / len(found))
                lost: tuple[str, ...] = ()
                if out is not None and one.trial is not None:
                    target = out / f"{_stem(one)}.parquet" if folder else out
                    lost = _write(one, target, lambda share: tell(0.5 + 0.5 * share))
                told.append(Told(one.report, data_faults(one.trial), lost))
    return tuple(told)


def _stem(one: "Imported") -> str:
    name = one.report.name
    return f"{one.report.path.stem}-{name}" if name else one.report.path.stem


def _write(one: "Imported", out: Path, tell: "Callable[[float], None]") -> tuple[str, ...]:
    """Write a trial; return what there was no place for."""
    from model.errors import RecordError

    assert one.trial is not None
    if out.resolve() == one.report.path.resolve():
        raise RecordError(f"{out} is the table itself; choose another --out")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordError(
            f"{out.parent} cannot be made: {error.strerror}; choose another"
        ) from error
    if out.suffix == ".mcap":
        from record.log.from_trial import left_out, write_trial_log

        write_trial_log(one.trial, out, tell)
        return left_out(one.trial)
    from record.trial.trial import write_trial

    write_trial(one.trial, out)
    return ()


def _written(told: "Sequence[Told]", out: Path, *, folder: bool) -> str:
    trials = [one for one in told if one.report.kept]
    samples = sum(one.report.kept for one in trials)
    if folder:
        return f"{out}: {len(trials)} trials, {samples} samples"
    lost = told[0].lost
    return f"{out}: {samples} samples" + (
        f"; no place in a log for {', '.join(lost)}" if lost else ""
    )


def _list_maps(*, as_json: bool) -> ExitCode:
    from record.trial.column_map import find_map, map_names, read_column_map

    found = [(name, read_column_map(find_map(name)).about) for name in map_names()]
    if as_json:
        print(json.dumps([{"name": name, **asdict(about)} for name, about in found], indent=2))
        return ExitCode.OK
    for name, about in found:
        print(f"{name:<16} {about.what}\n{'':<16} {about.source}; {about.licence}")
    return ExitCode.OK
