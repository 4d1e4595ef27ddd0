"""What an import found, in words and for a program."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache

import numpy as np

from gap.interfaces import DataFault, Simulator
from model.errors import BigantError
from record.trial.header import TrialHeader
from record.trial.import_table import ImportReport
from record.trial.table_file import Column
from record.trial.trial import Trial, build_trial
from robot.console.json_output import plain

SHOWN_ROWS = 10


@dataclass(frozen=True, slots=True)
class Told:
    """One table's report.

    Attributes:
        report: What the import found.
        faults: What the diagnosis would find wrong with the data; empty where no machine is named.
        lost: What the written file has no place for.
    """

    report: ImportReport
    faults: tuple[DataFault, ...]
    lost: tuple[str, ...]


def data_faults(trial: Trial | None) -> tuple[DataFault, ...]:
    """Return the faults that the simulator of the trial's machine sees; none without a machine's file."""
    if trial is None or not trial.header.robot_text:
        return ()
    try:
        return _simulator(trial.header).check(trial)
    except BigantError:
        return ()  # a machine's file that cannot be simulated says so when it is diagnosed


@lru_cache(maxsize=1)
def _simulator(header: TrialHeader) -> Simulator:
    from robot.gap_report.trials import simulator_for  # 50 MB, for tables that name a machine

    return simulator_for([build_trial(header, (Column("time_s", np.zeros(0)),))], None)


def report_json(told: Sequence[Told]) -> object:
    """Return the report of one table, or of each of several under ``tables``."""
    each = [
        plain({**asdict(one.report), "faults": [asdict(f) for f in one.faults]}) for one in told
    ]
    return each[0] if len(each) == 1 else {"tables": each}


def lines_of_one(told: Told, most_rows: int | None = SHOWN_ROWS) -> list[str]:
    """Return one table's report; rows beyond ``most_rows`` are counted."""
    report = told.report
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
    lines += [f"fault     {_fault(one)}: {one.evidence}" for one in told.faults]
    if len(lines) == 1:
        lines.append("nothing odd found")
    return lines


def all_lines(told: Sequence[Told]) -> list[str]:
    """Return the report of several tables: each kind of finding once, with how often and an example."""
    if len(told) == 1:
        return lines_of_one(told[0], None)
    reports = [one.report for one in told]
    files = len({report.path for report in reports})
    lines = [
        f"{files} files, {len(told)} tables: {sum(r.rows for r in reports)} rows, "
        f"{sum(r.kept for r in reports)} kept, {sum(len(r.dropped) for r in reports)} dropped"
    ]
    lines += [
        f"dropped   {_name(report)} row {item.row}: {item.reason}"
        for report in reports
        for item in report.dropped[:SHOWN_ROWS]
    ]
    found: list[tuple[str, str, str, str]] = []
    for one in told:
        found += [(f.kind, f.column, _name(one.report), f.detail) for f in one.report.findings]
        found += [("fault", _fault(f), _name(one.report), f.evidence) for f in one.faults]
    for kind, column in dict.fromkeys((kind, column) for kind, column, _, _ in found):
        own = [(where, words) for k, c, where, words in found if (k, c) == (kind, column)]
        where = f"in all {len(told)}" if len(own) == len(told) else f"in {len(own)} of {len(told)}"
        alike = len({words for _, words in own}) == 1
        example = own[0][1] if alike else f"{own[0][0]}: {own[0][1]}"
        lines.append(f"{kind:<9}{f' {column}' if column else ''} {where}: {example}")
    return lines


def _name(report: ImportReport) -> str:
    return f"{report.path.stem}-{report.name}" if report.name else report.path.stem


def _fault(one: DataFault) -> str:
    return f"{one.kind} {one.channel}" + (" (severe)" if one.severe else "")
