"""Figures of a checked campaign as lines, as tables for a page, as JSON."""

import math
from collections.abc import Sequence

from gap.check.cases import CheckedCase, gap_declared, named_right
from gap.check.methods import Method, methods
from gap.check.score import Confusion, Figure
from robot.console.table import Column, markdown_lines, table_lines

SCORES = tuple(Column("", form) for form in ("", "s", "s", "", "d", "", ""))
METHODS = (
    Column(""), Column("one: first", "s"), Column("two: recall", "s"), Column("precision", "s"),
    Column("no gap", "s"),
)  # fmt: skip
SEEN = "  ({:.1f} times repeatability)"
MARKS = {True: "met", False: "MISSED", None: "-"}


def score_lines(
    figures: Sequence[Figure], confusions: Sequence[Confusion], cases: Sequence[CheckedCase]
) -> list[str]:
    """Return what is printed."""
    scores = [
        (f.name, figure_value(f), _interval(f), "n", f.cases, f"bar {f.bar}", MARKS[f.met])
        for f in figures
    ]
    lines = table_lines(SCORES, scores)
    counted = methods(cases)
    if counted:
        lines += ["", *table_lines(METHODS, [(m.name, *_shares(m)) for m in counted])]
    if confusions:
        lines += ["", "wrong answers, by case, with what was wrong and what was named:"]
        lines += [
            f"  {c.case}  {c.truth}: {c.said}{_times(c.visible, SEEN)}{too_small_words(c)}"
            for c in confusions
        ]
    return lines


def too_small_words(one: Confusion) -> str:
    """Return words for true effects too small to be seen by the answer's own account, "" for none."""
    return f"  (too small to be seen: {', '.join(one.too_small)})" if one.too_small else ""


def score_markdown(
    figures: Sequence[Figure], confusions: Sequence[Confusion], cases: Sequence[CheckedCase]
) -> str:
    """Return tables of figures, effects and confusions."""
    rows = [
        (f.name, figure_value(f), _interval(f), str(f.cases), f.bar, MARKS[f.met]) for f in figures
    ]
    lines = markdown_lines(("figure", "value", "95 %", "cases", "bar", ""), rows)
    counted = methods(cases)
    if counted:
        head = ("method", "one effect: named first", "two: recall", "precision",
                "nothing wrong: nothing named")  # fmt: skip
        lines += ["", *markdown_lines(head, [(m.name, *_shares(m)) for m in counted])]
    effects = []
    single = [c for c in cases if c.kind == "single"]
    for effect in sorted({c.truths[0].effect for c in single}):
        own = [c for c in single if c.truths[0].effect == effect]
        wrong = [
            c.answer.named[0].effect if c.answer.named else c.answer.verdict
            for c in own
            if gap_declared(c) and not named_right(c)
        ]
        counts = (len(own), sum(map(gap_declared, own)), sum(map(named_right, own)))
        effects.append((f"`{effect}`", *map(str, counts), ", ".join(wrong)))
    head = ("effect", "cases", "gap declared", "named first", "named instead")
    lines += ["", *markdown_lines(head, effects)]
    wrongs = [(c.case, c.truth, c.said, _times(c.visible, "{:.1f}")) for c in confusions]
    lines += ["", *markdown_lines(("case", "true", "named", "change over repeatability"), wrongs)]
    return "\n".join(lines) + "\n"


def _shares(m: Method) -> tuple[str, str, str, str]:
    return (
        _share(m.first, m.singles),
        _share(m.hits, m.truths),
        _share(m.hits, m.said),
        _share(m.silent, m.controls),
    )


def _share(hits: int, of: int) -> str:
    return f"{hits / of:.0%}" if of else "-"


def figure_value(f: Figure) -> str:
    """Return a figure as it is printed."""
    if math.isnan(f.value):
        return "-"
    if not math.isnan(f.low) or "%" in f.bar:
        return f"{f.value:.1%}"
    return f"{f.value:.3g}{_by_chance(f)}"


def _by_chance(f: Figure) -> str:
    return "" if math.isnan(f.by_chance) else f" ({f.by_chance:.2f} by chance, p {f.p:.2f})"


def _interval(f: Figure) -> str:
    return "" if math.isnan(f.low) else f"{f.low:.0%} to {f.high:.0%}"


def _times(value: float, form: str) -> str:
    return "" if math.isnan(value) else form.format(value)
