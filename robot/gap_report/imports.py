"""``bigant import``: measured tables checked, written as logs or trials; what is odd there, in words."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from gap.interfaces import DataFault
from model.errors import BigantError, ConfigError, RecordError
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frame import solve_walk
from model.values.arrays import FloatArray
from model.values.estimate import Estimate
from model.values.gravity import STANDARD_GRAVITY
from model.values.tick import Tick
from record.log.from_trial import left_out, write_trial_log
from record.trial.column_map import ColumnMap, find_map, map_names, read_column_map
from record.trial.header import LEGGED
from record.trial.import_run import import_run
from record.trial.import_table import Imported, ImportReport
from record.trial.ros_bag import is_bag, with_topics
from record.trial.trial import Trial, write_trial
from record.whole_file import write_text, writing
from robot.config.robot_file import parse_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import json_text, print_result
from robot.console.program_output import complain
from robot.console.progress import ProgressBar
from robot.console.table import row_lines
from robot.control.tick_estimator import TickEstimator
from robot.gap_report.abilities import (
    NO_ROBOT,
    Ability,
    abilities,
    ability_rows,
    odometry_ability,
    run_simulator,
)
from robot.requests.recorded import ImportRequest

SUFFIXES = (".mcap", ".parquet", ".csv")
READ_SUFFIXES = (".parquet", ".csv", ".npz", ".toml")
SHOWN_ROWS = 10
MOST_ASKED = 3


class TableReport(NamedTuple):
    """What the import found in a table, and the diagnosis in its data; what the file has no place for.

    And what the run can be used for, and whether the estimate was written with it.
    """

    report: ImportReport
    faults: tuple[DataFault, ...]
    lost: tuple[str, ...]
    asked: tuple[Ability, ...] = ()
    estimated: bool = False


def silent(share: float, name: str) -> None:
    """Take the progress of an import, and show nothing."""


def bring_in(request: ImportRequest) -> ExitCode:
    """Import tables, or list the maps that come with the program.

    Raises:
        ConfigError: ``--out`` names no kind of file we write, or there is nothing to import.
        RecordError: A file cannot be read or written, or nothing in the table is known.
    """
    if request.maps:
        return _list_maps(as_json=request.json)
    with ProgressBar("import") as bar:
        reports = imported(request, bar.show)
    out = request.out
    text = json_text(_as_json(reports))
    if request.report is not None:
        whole = text if request.report.suffix == ".json" else "\n".join(all_lines(reports))
        write_text(request.report, whole + "\n", "--report")
    empty = out is not None and not any(one.report.kept for one in reports)
    verdict = ExitCode.VERDICT_FAILED if empty else ExitCode.OK
    if request.json:
        print(text)
        return verdict
    print(*(lines_of_one(reports[0]) if len(reports) == 1 else all_lines(reports)), sep="\n")
    if empty:
        complain(f"{out} is not written: no table has rows that make a trial; see 'short' above")
    elif out is not None:
        print(_written(reports, out, folder=request.folder))
    return verdict


def imported(
    request: ImportRequest, show: Callable[[float, str], None] = silent
) -> tuple[TableReport, ...]:
    """Import tables, write what was asked for, and print nothing.

    Args:
        request: Which tables, by which map, into what.
        show: Gets the share that is done, and the name of the table at work.

    Raises:
        ConfigError: ``--out`` names no kind of file we write, or there is nothing to import.
        RecordError: A file cannot be read or written, or nothing in the table is known.
    """
    out = request.out
    if not request.paths:
        raise ConfigError("TABLE", "name a table to import, or --maps to list the maps")
    for path in request.paths:
        if path.suffix not in READ_SUFFIXES and not is_bag(path):
            raise ConfigError(
                "TABLE", f"must end in {', '.join(READ_SUFFIXES)}, or be a ROS 2 bag, not {path}"
            )
    given = read_column_map(find_map(request.map)) if request.map is not None else ColumnMap()
    if request.topics is not None:
        given = replace(given, bag=with_topics(given.bag, request.topics))
    if out is not None and not request.folder:
        if out.suffix not in SUFFIXES:
            words = f"must end in .mcap, .parquet or .csv, or be a folder, not {out}"
            raise ConfigError("--out", words)
        if len(request.paths) > 1:
            raise ConfigError("--out", f"several tables need a folder, not {out}")
    return _import_all(request, given, show)


def reckoned(trial: Trial) -> FloatArray:
    """Return vx, vy, yaw rate and height that the robot's model makes of measured shafts, (T, 4).

    Raises:
        RecordError: The trial names no robot file.
    """
    if not trial.header.robot_text:
        raise RecordError(f"a clock is aligned by the robot's model: {NO_ROBOT}")
    robot = parse_robot(trial.header.robot_text).parameters
    feet = leg_kinematics(robot).feet(trial.shaft_rad, trial.shaft_rad_s)
    weight_n = robot.body.mass * STANDARD_GRAVITY
    answer = solve_walk(feet, robot.contact, weight_n)
    motion = np.column_stack([answer.velocity_B, answer.height_m])
    known = np.isfinite(feet.position_m).all(axis=(1, 2)) & np.isfinite(feet.velocity_m_s).all(
        axis=(1, 2)
    )
    motion[~known] = np.nan
    return motion


def _import_all(
    request: ImportRequest, given: ColumnMap, show: Callable[[float, str], None]
) -> tuple[TableReport, ...]:
    out = request.out
    reports: list[TableReport] = []
    for number, path in enumerate(request.paths):

        def tell(share: float, number: int = number, path: Path = path) -> None:
            show((number + share) / len(request.paths), path.name)

        # reading and writing take about as long
        tables = tuple(import_run(path, given, lambda share: tell(0.5 * share), reckoned))
        if len(tables) > 1 and out is not None and not request.folder:
            raise RecordError(f"{path} holds {len(tables)} tables; give --out a folder, not {out}")
        for at, one in enumerate(tables):
            tell(0.5 + 0.5 * at / len(tables))
            lost: tuple[str, ...] = ()
            estimated = False
            if out is not None and one.trial is not None:
                target = out / f"{_name_of(one.report)}.parquet" if request.folder else out
                lost, estimated = _write(
                    one, one.trial, target, lambda share: tell(0.5 + 0.5 * share)
                )
            few = len(reports) < MOST_ASKED  # runs of one machine can mostly answer the same
            asked = abilities(one.trial) if one.trial is not None and few else ()
            reports.append(TableReport(one.report, data_faults(one.trial), lost, asked, estimated))
    return tuple(reports)


def _write(
    one: Imported, trial: Trial, out: Path, tell: Callable[[float], None]
) -> tuple[tuple[str, ...], bool]:
    """Write a trial; return what there was no place for, and whether the estimate is with it."""
    if out.resolve() == one.report.path.resolve():
        raise RecordError(f"{out} is the table itself; choose another --out")
    with writing(out.parent):
        out.parent.mkdir(parents=True, exist_ok=True)
    if out.suffix != ".mcap":
        write_trial(trial, out)
        return (), False
    estimator = estimator_of(trial)
    estimate = None if estimator is None else _by(estimator)
    write_trial_log(trial, out, tell, estimate)
    return left_out(trial), estimator is not None


def _by(estimator: TickEstimator) -> Callable[[Tick], Estimate]:
    return lambda tick: estimator.step(tick.sensed)


def estimator_of(trial: Trial) -> TickEstimator | None:
    """Return the estimator of a trial's robot; None if it cannot run, or the robot file switches it off."""
    if trial.header.kind != LEGGED or not odometry_ability(trial).answered:
        return None
    config = parse_robot(trial.header.robot_text)
    return TickEstimator(config) if config.estimator.enabled else None


def _written(reports: Sequence[TableReport], out: Path, *, folder: bool) -> str:
    trials = [one for one in reports if one.report.kept]
    samples = sum(one.report.kept for one in trials)
    if folder:
        return f"{out}: {len(trials)} trials, {samples} samples"
    lost = f"; a log cannot store {', '.join(reports[0].lost)}" if reports[0].lost else ""
    estimated = ", with the estimate at each" if reports[0].estimated else ""
    return f"{out}: {samples} samples{estimated}{lost}"


def _list_maps(*, as_json: bool) -> ExitCode:
    """List the maps that come with the program."""
    maps = [(name, read_column_map(find_map(name)).about) for name in map_names()]
    rows: list[tuple[str, str]] = []
    for name, about in maps:
        rows += [(name, about.what), ("", f"{about.source}; {about.licence}")]
    values = [{"name": name, **asdict(about)} for name, about in maps]
    print_result(values, row_lines(rows), as_json=as_json)
    return ExitCode.OK


def data_faults(trial: Trial | None) -> tuple[DataFault, ...]:
    """Return the faults that the simulator of the trial's machine sees; none without a machine's file."""
    if trial is None or not trial.header.robot_text:
        return ()
    try:
        return run_simulator(trial).check(trial)
    except BigantError:
        return ()  # a machine's file that cannot be simulated says so when it is diagnosed


def _as_json(reports: Sequence[TableReport]) -> object:
    """The report of one table, or of each of several under ``tables``."""
    each = [
        {
            **asdict(one.report),
            "faults": one.faults,
            "can_be_asked": [ability._asdict() for ability in one.asked],
            "estimated": one.estimated,
        }
        for one in reports
    ]
    return each[0] if len(each) == 1 else {"tables": each}


def lines_of_one(one: TableReport, most_rows: int | None = SHOWN_ROWS) -> list[str]:
    """Return one table's report; rows beyond ``most_rows`` are counted."""
    report = one.report
    head = (
        f"{report.path}: {report.rows} rows, {report.kept} kept, {len(report.dropped)} dropped, "
        f"{len(report.columns)} columns"
    )
    shown = report.dropped[:most_rows]
    rows = [("dropped", f"row {item.row}: {item.reason}") for item in shown]
    if len(report.dropped) > len(shown):
        rows.append(("dropped", f"{len(report.dropped) - len(shown)} more, all in --report FILE"))
    for finding in report.findings:
        row = f", first in row {finding.first_row}" if finding.first_row else ""
        count = f" x{finding.count}{row}" if finding.count else ""
        rows.append((finding.kind, f"{finding.column}{count}".lstrip() + f": {finding.detail}"))
    rows += [("fault", f"{_fault(fault)}: {fault.evidence}") for fault in one.faults]
    can = row_lines(ability_rows(one.asked)) if one.asked else []
    return [head, *(row_lines(rows) if rows else ["no problem found"]), *can]


def all_lines(reports: Sequence[TableReport]) -> list[str]:
    """Return the report of several tables: each kind of finding once, with how often and an example."""
    if len(reports) == 1:
        return lines_of_one(reports[0], None)
    tables = [one.report for one in reports]
    files = len({table.path for table in tables})
    head = (
        f"{files} files, {len(tables)} tables: {sum(t.rows for t in tables)} rows, "
        f"{sum(t.kept for t in tables)} kept, {sum(len(t.dropped) for t in tables)} dropped"
    )
    rows = [
        ("dropped", f"{_name_of(table)} row {item.row}: {item.reason}")
        for table in tables
        for item in table.dropped[:SHOWN_ROWS]
    ]
    odd = [
        (kind, column, number, words)
        for number, one in enumerate(reports)
        for kind, column, words in (
            *((f.kind, f.column, f.detail) for f in one.report.findings),
            *(("fault", _fault(f), f.evidence) for f in one.faults),
        )
    ]
    for kind, column in dict.fromkeys((kind, column) for kind, column, _, _ in odd):
        own = [(number, words) for k, c, number, words in odd if (k, c) == (kind, column)]
        count = len({number for number, _ in own})  # a table may have one kind several times
        where = f"in all {count}" if count == len(reports) else f"in {count} of {len(reports)}"
        first, example = own[0]
        if len({words for _, words in own}) > 1:
            example = f"{_name_of(tables[first])}: {example}"
        rows.append((kind, f"{column} {where}: {example}".lstrip()))
    return [head, *(row_lines(rows) if rows else []), *_asked_of_all(reports)]


def _asked_of_all(reports: Sequence[TableReport]) -> list[str]:
    """What the runs can be used for: each answer once, with how often."""
    asked = [one.asked for one in reports if one.asked]
    counts = Counter(row for each in asked for row in ability_rows(each))
    rows = [(label, f"{words} ({n} of {len(asked)})") for (label, words), n in counts.items()]
    if rows and len(asked) < len(reports):
        rows.insert(0, ("uses", f"looked at in {len(asked)} of {len(reports)} tables only:"))
    return row_lines(rows) if rows else []


def _name_of(report: ImportReport) -> str:
    """The name of a table: of its file, and which of the file's tables it is."""
    return f"{report.path.stem}-{report.name}" if report.name else report.path.stem


def _fault(one: DataFault) -> str:
    return f"{one.kind} {one.channel}" + (" (severe)" if one.severe else "")
