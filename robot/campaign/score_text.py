"""Figures of a checked campaign as lines, as tables for a page, as JSON."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from gap.check.methods import Method, methods
from gap.check.score import Case, Confusion, Figure, gap_declared, named_right

MARKS = {True: "met", False: "MISSED", None: "-"}


def score_lines(
    figures: Sequence[Figure], confusions: Sequence[Confusion], cases: Sequence[Case]
) -> list[str]:
    """Return what is printed."""
    lines = [
        f"{f.name:52s} {_value(f):>7s} {_interval(f):>14s}  n {f.cases:<4d} bar {f.bar:8s} {MARKS[f.met]}"
        for f in figures
    ]
    counted = methods(cases)
    if counted:
        lines += [
            "",
            f"{'':38s} {'one: first':>12s} {'two: recall':>12s} {'precision':>12s} {'no gap':>9s}",
        ]
        lines += [
            f"{m.name:38s} {a:>12s} {b:>12s} {c:>12s} {d:>9s}"
            for m in counted
            for a, b, c, d in [_shares(m)]
        ]
    if confusions:
        lines += ["", "said otherwise than it was:"]
        lines += [f"  {c.case}  {c.truth}: {c.said}{_seen(c.visible)}" for c in confusions]
    return lines


def score_markdown(
    figures: Sequence[Figure], confusions: Sequence[Confusion], cases: Sequence[Case]
) -> str:
    """Return tables of figures, effects and confusions."""
    lines = ["| figure | value | 95 % | cases | bar | |", "|---|---|---|---|---|---|"]
    lines += [
        f"| {f.name} | {_value(f)} | {_interval(f)} | {f.cases} | {f.bar} | {MARKS[f.met]} |"
        for f in figures
    ]
    counted = methods(cases)
    if counted:
        lines += [
            "",
            "| way | one effect: named first | two: recall | precision | nothing wrong: nothing named |",
        ]
        lines += ["|---|---|---|---|---|"]
        lines += [f"| {m.name} | {' | '.join(_shares(m))} |" for m in counted]
    lines += [
        "",
        "| effect | cases | gap declared | named first | named instead |",
        "|---|---|---|---|---|",
    ]
    single = [c for c in cases if c.kind == "single"]
    for effect in sorted({c.truths[0].effect for c in single}):
        own = [c for c in single if c.truths[0].effect == effect]
        wrong = [
            c.answer.named[0].effect if c.answer.named else c.answer.verdict
            for c in own
            if gap_declared(c) and not named_right(c)
        ]
        right = sum(map(named_right, own))
        lines.append(
            f"| `{effect}` | {len(own)} | {sum(map(gap_declared, own))} | {right} | {', '.join(wrong)} |"
        )
    lines += ["", "| case | was | said | change over repeatability |", "|---|---|---|---|"]
    lines += [f"| {c.case} | {c.truth} | {c.said} | {_plain(c.visible)} |" for c in confusions]
    return "\n".join(lines) + "\n"


def score_json(
    figures: Sequence[Figure], confusions: Sequence[Confusion], cases: Sequence[Case]
) -> dict[str, Any]:
    """Return everything as a JSON object; what is not known is null."""
    told = {
        "figures": [asdict(f) for f in figures],
        "confusions": [asdict(c) for c in confusions],
        "methods": [asdict(m) for m in methods(cases)],
        "cases": [asdict(c) for c in cases],
    }
    plain: dict[str, Any] = _known(told)
    return plain


def _shares(m: Method) -> tuple[str, str, str, str]:
    return (
        _share(m.first, m.singles),
        _share(m.hits, m.truths),
        _share(m.hits, m.said),
        _share(m.silent, m.controls),
    )


def _share(hits: int, of: int) -> str:
    return f"{hits / of:.0%}" if of else "-"


def _value(f: Figure) -> str:
    if math.isnan(f.value):
        return "-"
    if not math.isnan(f.low) or "%" in f.bar:
        return f"{f.value:.1%}"
    return f"{f.value:.3g}"


def _interval(f: Figure) -> str:
    return "" if math.isnan(f.low) else f"{f.low:.0%} to {f.high:.0%}"


def _seen(value: float) -> str:
    return "" if math.isnan(value) else f"  ({value:.1f} times repeatability)"


def _plain(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.1f}"


def _known(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _known(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_known(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
