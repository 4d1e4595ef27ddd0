"""Thirty-one robots of somebody else's simulator: ``python -m benchmarks.gap.apart --out DIR [--jobs 2]``.

Makes runs and references, imports them, diagnoses each case, and counts. The runs take about 8 minutes of
one core, and each of 34 diagnoses 1 to 3. What is in DIR already is not made again.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.gap.apart.answers import answer_all, questions_of
from benchmarks.gap.apart.cases import CASES, REFERENCE_RUNS, Case
from benchmarks.gap.apart.files import make_runs
from benchmarks.gap.apart.score import Answered, case_rows, counts, read_answers
from record.earlier_file import earlier_files
from record.whole_file import write_text
from robot.console.json_output import json_text
from robot.console.table import Column, table_lines


@dataclass(frozen=True, slots=True)
class Request:
    """What to do: cases, where everything goes, diagnoses at a time."""

    cases: tuple[Case, ...]
    out: Path
    jobs: int


def main() -> None:
    """Make the runs, diagnose the cases, and print what was right."""
    request = _request()
    try:
        _make_and_judge(request)
    except KeyboardInterrupt:
        raise SystemExit("interrupted; the same command goes on from here") from None


def _make_and_judge(request: Request) -> None:
    runs = [run for case in request.cases for run in case.runs]
    make_runs(request.out, [*REFERENCE_RUNS, *runs], tell)
    questions = questions_of(request.cases)
    answer_all(request.out, questions, request.jobs, tell)
    _report(read_answers(request.out, questions), request.out / "score.json")


def tell(line: str) -> None:
    """Say what is going on, apart from the table."""
    print(line, file=sys.stderr, flush=True)


def _request() -> Request:
    names = [case.name for case in CASES]
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap.apart", description=__doc__)
    parser.add_argument(
        "--out", type=Path, required=True, help="folder for runs and answers", metavar="DIR"
    )
    parser.add_argument(
        "--cases", nargs="+", choices=names, default=names, metavar="CASE",
        help=f"these only, {names[0]} to {names[-1]} (default: all)",
    )  # fmt: skip
    parser.add_argument("--jobs", type=int, default=1, help="diagnoses at a time (default 1)")
    given = parser.parse_args()
    cases = tuple(case for case in CASES if case.name in given.cases)
    return Request(cases, given.out.resolve(), given.jobs)


def _report(answered: Sequence[Answered], kept: Path) -> None:
    rows, counted = list(case_rows(answered)), counts(answered)
    columns = [Column(name) for name in ("case", "what is wrong", "verdict", "named")]
    print("\n".join(table_lines(columns, rows)), end="\n\n")
    table = [(one.question, one.words) for one in counted]
    print("\n".join(table_lines([Column("question"), Column("answer")], table)))
    with earlier_files(overwrite=True, notify=tell):
        write_text(kept, json_text({"counts": counted, "cases": rows}) + "\n")


if __name__ == "__main__":
    main()
