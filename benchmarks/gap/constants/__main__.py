"""What half and twice of each constant does: ``python -m benchmarks.gap.constants [--campaigns DIR ...]``.

Writes ``docs/gap_constants.toml``, from which ``make docs`` makes the page. Every change is judged in a
process of its own (``judged``): on known cases of small machines (``toy_cases``, ``servo_cases``), or, with
``--campaigns``, on the saved answers of campaigns whose labels are open, for probabilities, or, with
``--diagnose``, on a few of their cases, diagnosed again (``legged_cases``).
"""

import argparse
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from benchmarks.gap.constants.changes import (
    OF_LEGGED,
    OF_PROBABILITIES,
    half_and_twice,
    known,
)
from benchmarks.gap.constants.figures import JudgedCase, counts, differences
from benchmarks.gap.constants.judged import as_they_are, judged
from bigant.one_thread import one_thread
from model.parameters.toml_table import parse_toml
from record.toml_file import toml_text

PAGE_DATA = Path(__file__).resolve().parents[3] / "docs" / "gap_constants.toml"
HEAD = ("Written by python -m benchmarks.gap.constants; docs/gap_constants.md explains it.",)
Row = dict[str, float | int]


def main() -> None:
    """Judge every change and write what it does."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap.constants", description=__doc__)
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--only", nargs="+", default=[], help="these constants; others stay")
    parser.add_argument("--out", type=Path, default=PAGE_DATA, help="file to write")
    parser.add_argument(
        "--campaigns", type=Path, nargs="+", default=[], help="judge their saved answers again"
    )
    parser.add_argument(
        "--diagnose",
        type=Path,
        nargs="+",
        default=[],
        help="diagnose these cases: CAMPAIGN/cases/NAME",
    )
    request = parser.parse_args()
    one_thread()
    section, names = "small_machines", [one for one in known() if one not in OF_LEGGED]
    if request.campaigns:
        section, names = "legged", list(OF_PROBABILITIES)
    elif request.diagnose:
        section, names = "legged_cases", list(OF_LEGGED)
    names = request.only or names
    measured = _measured(names, request.campaigns, request.diagnose, request.jobs)
    earlier = _earlier(request.out)
    old = earlier.get(section, {}) if request.only else {}
    # a row is compared with how answers were in its own run: engines change between runs
    runs = old.get("runs", {})
    own = measured["unchanged"]
    if request.diagnose:
        own = {
            **own,
            "names": ", ".join(f"{one.parents[1].name} {one.name}" for one in request.diagnose),
        }
    if request.campaigns:
        own = {**own, "realities": ", ".join(one.name for one in request.campaigns)}
        if old:  # most rows are of the cases before
            measured["unchanged"] = old["unchanged"]
        measured["realities"] = old.get("realities", own["realities"])
    same = [number for number, run in runs.items() if run == own]
    number = same[-1] if same else str(len(runs) + 1)
    rows = {name: {**row, "run": int(number)} for name, row in measured["constants"].items()}
    measured["constants"] = {**old.get("constants", {}), **rows}
    measured["runs"] = {**runs, number: own}
    request.out.write_text(toml_text({**earlier, section: measured}, HEAD), encoding="utf-8")


def _earlier(out: Path) -> dict[str, Any]:
    """What is in the file already."""
    return parse_toml(out.read_text(encoding="utf-8"), out.name) if out.is_file() else {}


def _measured(
    names: Sequence[str], campaigns: Sequence[Path], cases: Sequence[Path], jobs: int
) -> dict[str, Any]:
    """Figures as they are, and of each constant at half and at twice its value."""
    values = known()
    changes = [change for name in names for change in half_and_twice(name, values[name])]
    table: dict[str, dict[str, Any]] = {name: {"value": values[name]} for name in names}
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        before = pool.submit(as_they_are, campaigns, cases).result()
        unchanged = {**_rounded(asdict(counts(before))), "cases": _kinds(before)}
        print("as they are:", unchanged, flush=True)
        answers = pool.map(partial(judged, before=before, cases=cases), changes)
        for change, row in zip(changes, _rows(answers, before), strict=True):
            side = "half" if change.value < values[change.name] else "twice"
            table[change.name][side] = {"at": round(change.value, 6), **row}
            print(change.name, side, row, flush=True)
    return {"unchanged": unchanged, "constants": table}


def _rows(answers: Iterable[list[JudgedCase]], before: list[JudgedCase]) -> Iterator[Row]:
    for after in answers:
        yield _rounded({**asdict(counts(after)), **asdict(differences(after, before))})


def _kinds(cases: Sequence[JudgedCase]) -> dict[str, int]:
    return dict(sorted(Counter(one.checked.kind for one in cases).items()))


def _rounded(row: Row) -> Row:
    return {
        name: value if isinstance(value, int) else round(value, 4) for name, value in row.items()
    }


if __name__ == "__main__":
    main()
