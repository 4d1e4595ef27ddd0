"""What half and twice of each constant does to known cases: ``python -m benchmarks.gap_constants``.

Writes ``docs/gap_constants.toml``, from which ``make docs`` makes the page. Every change is judged in a
process of its own (``judged``), on the same cases (``toy_cases``, ``servo_cases``).
"""

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path

from benchmarks.gap_constants.changes import UNCHANGED, Change, half_and_twice, known
from benchmarks.gap_constants.figures import counts, differences
from benchmarks.gap_constants.judged import judged
from bigant.one_thread import one_thread
from record.toml_file import toml_text

PAGE_DATA = Path(__file__).resolve().parents[2] / "docs" / "gap_constants.toml"
Row = dict[str, float | int]


def main() -> None:
    """Judge every change and write what it does."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap_constants", description=__doc__)
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument(
        "--only", nargs="*", default=[], help="print these constants, write nothing"
    )
    parser.add_argument("--out", type=Path, default=PAGE_DATA, help="file to write")
    request = parser.parse_args()
    one_thread()
    names = request.only or list(known())
    values = {name: known()[name] for name in names}
    changes = [change for name in names for change in half_and_twice(name, values[name])]
    table: dict[str, dict[str, object]] = {name: {"value": values[name]} for name in names}
    with ProcessPoolExecutor(
        request.jobs, mp_context=get_context("spawn"), max_tasks_per_child=1
    ) as pool:
        rows = _rows(pool, changes)
        before = next(rows)
        print("as they are", before, flush=True)
        for change, row in zip(changes, rows, strict=True):
            side = "half" if change.value < values[change.name] else "twice"
            table[change.name][side] = {"value": change.value, **row}
            print(change.name, side, row, flush=True)
    if not request.only:
        request.out.write_text(toml_text({"unchanged": before, **table}), encoding="utf-8")


def _rows(pool: ProcessPoolExecutor, changes: list[Change]) -> Iterator[Row]:
    """Yield the figures without any change, and then with each."""
    answers = pool.map(judged, [UNCHANGED, *changes])
    before = next(answers)
    kinds = [one.checked.kind for one in before]
    yield {
        **_rounded(asdict(counts(before))),
        **{f"cases_{k}": kinds.count(k) for k in sorted(set(kinds))},
    }
    for after in answers:
        yield _rounded({**asdict(counts(after)), **asdict(differences(after, before))})


def _rounded(row: Row) -> Row:
    return {
        name: value if isinstance(value, int) else round(value, 4) for name, value in row.items()
    }


if __name__ == "__main__":
    main()
