"""Figures of realities as lines and as tables for a page: a row a reality, a mark at every bar missed."""

import math
from collections.abc import Mapping, Sequence

from gap.check.calibration import LeftOut
from gap.check.realities import BOTH, BOTH_LARGE_ENOUGH, FIRST, LARGE_ENOUGH, RealityFigures
from gap.check.score import Confusion, Figure
from robot.campaign.score_text import figure_value, too_small_words
from robot.console.table import Column, markdown_lines, table_lines

SHORT = {
    FIRST: "first", LARGE_ENOUGH: "large", "or in its declared group": "group",
    "stage right, of detected": "stage",
    "healthy called no_gap": "healthy", BOTH: "pairs", BOTH_LARGE_ENOUGH: "large pairs",
    "outside: unexplained": "outside", "AUROC of none of these": "AUROC",
    "listed, called unexplained": "unexpl.", "calibration error": "calib.",
    "number within one of its +-": "1 +-", "number within two of its +-": "2 +-",
}  # fmt: skip
MISSED = " *"
JUDGED = ("reality", "rows", "error now", "error fitted", "loss now", "loss fitted")


def reality_lines(
    rows: Sequence[RealityFigures],
    together: RealityFigures,
    worst: RealityFigures,
    left_out: tuple[Sequence[LeftOut], Sequence[LeftOut]],
    confused: Mapping[str, Sequence[Confusion]],
) -> list[str]:
    """Return what is printed."""
    head = _head(rows[0])
    lines = table_lines(
        tuple(Column(name) for name in head), [_row(row) for row in (*rows, together)]
    )
    bars = ", ".join(f"{_short(figure)} {figure.bar}" for figure in rows[0].figures)
    lines += [f"bars: {bars}; missed ones are marked *", f"worst: {_worst(worst)}"]
    for title, judged in zip(_TITLES, left_out, strict=True):
        if judged:
            lines += ["", title, *table_lines(_JUDGED, _judged(judged))]
    wrong = [(name, one) for name, own in confused.items() for one in own]
    if wrong:
        lines += ["", "wrong answers, by reality and case, with what was wrong and what was named:"]
        lines += [
            f"  {name} {one.case}  {one.truth}: {one.said}{too_small_words(one)}"
            for name, one in wrong
        ]
    return lines


def reality_markdown(
    rows: Sequence[RealityFigures],
    together: RealityFigures,
    worst: RealityFigures,
    left_out: tuple[Sequence[LeftOut], Sequence[LeftOut]],
) -> str:
    """Return tables for a page."""
    bars = ("bar", "", *(figure.bar for figure in rows[0].figures))
    table = [_row(row) for row in (*rows, together)]
    lines = [
        *markdown_lines(_head(rows[0]), [*table, bars]),
        "",
        f"Worst: {_worst(worst)}.",
    ]
    for title, judged in zip(_TITLES, left_out, strict=True):
        if judged:
            cells = [tuple(_cell(value) for value in row) for row in _judged(judged)]
            lines += ["", f"{title}:", "", *markdown_lines(JUDGED, cells)]
    return "\n".join(lines) + "\n"


_TITLES = (
    "none of these, by constants fitted on all other realities",
    "causes named, by a curve fitted on all other realities",
)
_JUDGED = tuple(
    Column(name, form) for name, form in zip(JUDGED, ("", "d", *[".3f"] * 4), strict=True)
)


def _head(row: RealityFigures) -> tuple[str, ...]:
    return ("reality", "cases", *(_short(figure) for figure in row.figures))


def _short(figure: Figure) -> str:
    return SHORT.get(figure.name, figure.name)


def _row(row: RealityFigures) -> tuple[str, ...]:
    return (row.name, str(row.cases), *(_figure(one) for one in row.figures))


def _figure(one: Figure) -> str:
    whole = one.bar == "0" and not math.isnan(one.value)
    value = f"{one.value:.0f}" if whole else figure_value(one)
    of = f" of {one.cases}" if not math.isnan(one.low) else ""
    return value + of + (MISSED if one.met is False else "")


def _worst(worst: RealityFigures) -> str:
    missed = ", ".join(worst.missed) or "nothing"
    return f"{worst.name}, which misses {len(worst.missed)} of {len(worst.figures)} bars: {missed}"


def _judged(judged: Sequence[LeftOut]) -> list[tuple[str, int, float, float, float, float]]:
    return [(o.name, o.cases, o.error_now, o.error, o.loss_now, o.loss) for o in judged]


def _cell(value: object) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)
