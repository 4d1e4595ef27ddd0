"""Write docs/gap_constants.md from ``gap.constants`` and what the benchmark measured (``make docs``).

With ``--check`` compare only.
"""

import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gap import constants
from gap.constants import Constant
from model.parameters.toml_table import parse_toml

PAGE = Path(__file__).resolve().parent / "gap_constants.md"
MEASURED = PAGE.with_suffix(".toml")
Figures = Mapping[str, Any]  # counts and shares of one run of the benchmark
# what is counted, of which kinds of cases, in words
COUNTS = (
    ("first", ("single",), "cause named first and at its joint"),
    ("pairs", ("pair",), "both causes of a pair named"),
    ("healthy", ("control",), "healthy called no gap"),
    ("outside", ("outside", "removed"), "outside the catalogue called unexplained"),
    ("listed_unexplained", ("single", "pair"), "listed but called unexplained"),
)
SHARES = (  # and from which difference on it is told
    ("calibration_error", 0.01, "calibration error"),
    ("log_loss", 0.01, "log loss"),
    ("within_one", 0.02, "numbers within one of their +-"),
    ("within_two", 0.02, "numbers within two of their +-"),
)
MOST = 6  # constants that are named on top

PAGE_TEXT = """# Constants of the diagnosis

Every number that was set by hand and decides an answer of [the diagnosis](gap.md): its verdict, its causes,
their numbers, +- and probabilities. Written by `make docs` from `gap/constants/`; do not edit.

**What is not here.** Numbers that only limit effort (how many candidates are fitted), that are numerical
precision (steps, grids, tolerances), that follow from theory (degrees of freedom, quantiles), or that say
how much data there must be before something is computed. Nor what is told beside the answer (warnings, the
map of where it lies, what runs cannot show, the run that is proposed next), what is checked of a recording
before, and what a simulator takes of a kind of machine (noise of sensors where a file gives none, ranges
of its catalogue). `tests/gap/numbers_elsewhere.toml` lists every such number under its reason, and a test
fails for one that is neither there nor here.

## What half and twice of each do

`python -m benchmarks.gap.constants --jobs 2` sets each constant to half and to twice its value, one at a
time, and diagnoses the same {cases} known cases each time: a tiny machine of three joints in nine realities
(alike its simulator; restless from day to day; one joint more than the others; references at other gaits,
with forces that no effect makes; baseline model errors; few references; none; none and such forces; no
force sensors) and a servo with a pendulum.
Of these, {kinds}. Sizes of causes go down to what hardly shows, so that answers hang on
the constants. As they are, {right} of {cases} answers are right
({counts};
{shares_now}).

Shares whose double would reach 1 ({halfway}) go half of the way to 1 instead;
of `NONE`, a logarithm of odds, the odds are halved and doubled, and `VIBRATES_FASTER` goes half of the way
to the fastest that frames show. The cells say what changes; "-" is: no verdict, no cause and no figure
changes. So few cases show which constants matter, not by how much to change one: one case is {one:.1%}.

**From which figures a row starts.** The figures above are those of run {latest}, the newest. All rows take
more than an hour, so a constant is measured when it is new or when what it acts on changes. The engine was
another one in earlier runs, and a cell compares with the figures of its own run, whose number is in the
last column: where it begins with another count than the one above, that is why. [All runs](#the-runs)
are below.

**What matters most:**

{most}

{idle} constants change no verdict and no cause of these cases either way: {unmoved}.

| constant | value | meaning | chosen | half | twice | run |
|---|---|---|---|---|---|---|
{rows}

### The runs

How answers were in each run, with all constants as they were. A run of which no row is left is not here.

| run | rows | cause first | both of a pair | healthy | outside | calibration error | log loss |
|---|---|---|---|---|---|---|---|
{run_rows}

## The constants of legged robots' channels

No small machine has what these act on. `python -m benchmarks.gap.constants --diagnose CASE ...` diagnoses
a few cases of legged robots again (`CASE` is a folder `CAMPAIGN/cases/NAME`). A case takes half a minute,
so there are few. They are of the sealed set of seed 770373878, labels open: one with a cause that is not
seen (stiction, without force sensors) and a healthy one that is called unexplained, chosen because both
are near a limit. What acts on forces was measured on the second alone. The last rows are of constants of
the table above, on the first.

| cases | as they are |
|---|---|
{few_runs}

| constant | value | meaning | chosen | half | twice | cases |
|---|---|---|---|---|---|---|
{few_rows}

## The constants of probabilities on legged robots

`python -m benchmarks.gap.constants --campaigns DIR ...` makes probabilities and verdicts of saved answers
again; only these constants can be judged without simulating again. Measured on {legged_cases} cases
({legged_kinds}), the sealed set of
seed 770373878 with its labels open, of virtual robots in {realities}.
As they are: {legged_counts};
{legged_shares}.

| constant | half | twice |
|---|---|---|
{legged_rows}
{other_cases}"""


def page() -> str:
    """Return the page."""
    measured = parse_toml(MEASURED.read_text(encoding="utf-8"), MEASURED.name)
    small, legged = measured["small_machines"], measured["legged"]
    before, table, runs = small["unchanged"], small["constants"], small["runs"]
    own = _own_runs(small)  # engines change between runs
    every = {name: one for name, one in vars(constants).items() if isinstance(one, Constant)}
    known = {name: one for name, one in every.items() if name in table}
    rows = [
        f"{_row(name, one, own[name], table[name])} {table[name]['run']} |"
        for name, one in known.items()
    ]
    few = measured["legged_cases"]
    few_own = _own_runs(few)
    few_rows = [
        f"{_row(name, every[name], few_own[name], row)} {few_own[name]['names']} |"
        for name, row in sorted(few["constants"].items(), key=lambda one: one[0] in known)
    ]
    few_runs = {f"| {one['names']} | {_counts(one)} |": None for one in few["runs"].values()}
    robots, legged_table, then = legged["unchanged"], legged["constants"], _own_runs(legged)
    legged_rows = [
        f"| `{name}` | {_cell(then[name], one['half'])} | {_cell(then[name], one['twice'])} |"
        for name, one in legged_table.items()
    ]
    order = sorted(known, key=lambda name: _weight(own[name], table[name]), reverse=True)
    most = [
        f"- `{name}` ({known[name].meaning}): half, {_cell(own[name], table[name]['half'])}; "
        f"twice, {_cell(own[name], table[name]['twice'])}."
        for name in order[:MOST]
    ]
    unmoved = [name for name in known if not any(_moved(table[name][s]) for s in ("half", "twice"))]
    halfway = [
        name
        for name in every
        if _went_halfway(name, (table if name in table else few["constants"])[name])
    ]
    cases = sum(before["cases"].values())
    latest = next(number for number in reversed(runs) if runs[number] == before)
    return PAGE_TEXT.format(
        cases=cases, kinds=_kinds(before), counts=_counts(before), shares_now=_shares(before),
        right=before["right"], latest=latest, one=1.0 / cases, most="\n".join(most),
        run_rows="\n".join(_run_rows(small)), few_runs="\n".join(few_runs),
        few_rows="\n".join(few_rows),
        halfway=_listed(halfway),
        idle=len(unmoved), unmoved=_listed(unmoved), rows="\n".join(rows),
        legged_cases=sum(robots["cases"].values()), legged_kinds=_kinds(robots),
        legged_counts=_counts(robots), legged_shares=_shares(robots), realities=legged["realities"],
        legged_rows="\n".join(legged_rows), other_cases=_other_cases(legged),
    )  # fmt: skip


def _row(name: str, one: Constant, before: Figures, row: Figures) -> str:
    """A constant, and what half and twice of it do."""
    half, twice = (_cell(before, row[side]) for side in ("half", "twice"))
    return f"| `{name}` | {float(one):g} | {one.meaning} | {one.chosen} | {half} | {twice} |"


def _run_rows(section: Figures) -> list[str]:
    """How answers were in each run that rows are of."""
    rows = Counter(str(row["run"]) for row in section["constants"].values())
    return [
        f"| {number} | {rows[number]} | {run['first']} | {run['pairs']} | {run['healthy']} | "
        f"{run['outside']} | {run['calibration_error']:.2f} | {run['log_loss']:.2f} |"
        for number, run in section["runs"].items()
        if rows[number]
    ]


def _other_cases(section: Figures) -> str:
    """Which constants were measured on other cases than most."""
    lines = []
    for number, run in section["runs"].items():
        names = [name for name, row in section["constants"].items() if str(row["run"]) == number]
        if not names or run.get("realities", section["realities"]) == section["realities"]:
            continue
        lines.append(
            f"\n{_listed(names)}: on {sum(run['cases'].values())} other cases, in {run['realities']}; "
            f"as they are: {_counts(run)}; {_shares(run)}.\n"
        )
    return "".join(lines)


def _own_runs(section: Figures) -> dict[str, Figures]:
    """How answers were, unchanged, in the run in which each constant was measured."""
    runs, table = section["runs"], section["constants"]
    return {name: runs[str(row["run"])] for name, row in table.items()}


def _went_halfway(name: str, row: Figures) -> bool:
    """Whether a constant went half of the way to 1 instead of being doubled."""
    usual = name not in {"NONE", "VIBRATES_FASTER"}
    return bool(usual and row["twice"]["at"] < 1.99 * row["value"])


def _shares(before: Figures) -> str:
    return ", ".join(f"{meaning} {before[name]:.2f}" for name, _, meaning in SHARES)


def _cell(before: Figures, after: Figures) -> str:
    """What differs, in words and numbers."""
    words = []
    for name, kinds, meaning in COUNTS:
        if after[name] != before[name]:
            words.append(f"{meaning} {before[name]} to {after[name]} of {_total(before, kinds)}")
    for name, least, meaning in SHARES:
        if abs(after[name] - before[name]) >= least:
            words.append(f"{meaning} {before[name]:.2f} to {after[name]:.2f}")
    sizes = after["visible_sizes"] - 1.0
    if abs(sizes) >= 0.01:
        words.append(f"sizes said to be visible {sizes:+.0%}")
    for name, meaning in (("verdicts", "other verdict"), ("causes", "other causes")):
        if after[name]:
            words.append(f"{meaning} in {after[name]}")
    return "; ".join(words) or "-"


def _weight(before: Figures, row: Figures) -> tuple[int, int]:
    """How much a constant matters: right answers gained or lost, then answers that differ."""
    sides = (row["half"], row["twice"])
    right = max(abs(one["right"] - before["right"]) for one in sides)
    return right, max(one["verdicts"] + one["causes"] for one in sides)


def _moved(side: Figures) -> bool:
    return bool(side["verdicts"] or side["causes"])


def _total(before: Figures, kinds: Sequence[str]) -> int:
    return sum(before["cases"].get(kind, 0) for kind in kinds)


def _counts(before: Figures) -> str:
    words = [
        f"{meaning}: {before[name]} of {total}"
        for name, kinds, meaning in COUNTS
        if (total := _total(before, kinds))
    ]
    return ", ".join(words)


def _kinds(before: Figures) -> str:
    words = {"single": "with one cause", "pair": "with two", "control": "healthy",
             "outside": "with a cause of no catalogue", "removed": "with one taken out of it"}  # fmt: skip
    return ", ".join(
        f"{before['cases'][key]} {own}" for key, own in words.items() if key in before["cases"]
    )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        sys.exit(0 if PAGE.read_text(encoding="utf-8") == page() else "run: make docs")
    PAGE.write_text(page(), encoding="utf-8")
