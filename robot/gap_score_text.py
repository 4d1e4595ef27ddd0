"""Figures of a checked campaign as lines, as tables for a page, as JSON."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from gap.score import Case, Confusion, Figure, found, named_right

MARKS = {True: "met", False: "MISSED", None: "-"}


def score_lines(figures: Sequence[Figure], confusions: Sequence[Confusion]) -> list[str]:
    """Return what is printed."""
    lines = [
        f"{f.name:52s} {_value(f):>7s} {_interval(f):>14s}  n {f.cases:<4d} bar {f.bar:8s} {MARKS[f.met]}"
        for f in figures
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
            if found(c) and not named_right(c)
        ]
        right = sum(map(named_right, own))
        lines.append(
            f"| `{effect}` | {len(own)} | {sum(map(found, own))} | {right} | {', '.join(wrong)} |"
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
        "cases": [asdict(c) for c in cases],
    }
    plain: dict[str, Any] = _known(told)
    return plain


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
