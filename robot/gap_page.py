"""A diagnosis as one self-contained page."""

import html
import math
from collections.abc import Sequence
from pathlib import Path

from gap.findings import Diagnosis, Verdict
from gap.verdict import cause_words, place_words
from robot.gap_figures import draw_diagnosis
from robot.report_page import STYLE, inline_svg

MORE_STYLE = """
.verdict { font-size: 1.25rem; border-left: 0.4rem solid #0072B2; padding: 0.4rem 0 0.4rem 0.8rem; }
.verdict.unexplained { border-color: #D55E00; } .verdict.ambiguous { border-color: #E69F00; }
.verdict.no_gap { border-color: #009E73; }
thead th { width: auto; } td.number { text-align: right; }
meter { width: 6rem; }
"""
Rows = Sequence[Sequence[str]]


def diagnosis_page(d: Diagnosis, paths: Sequence[Path]) -> str:
    """Return the page.

    Args:
        d: The diagnosis.
        paths: Files of the trials and the references, in their order.
    """
    figures = draw_diagnosis(d)
    body = [
        "<h1>Simulator against measured runs</h1>",
        f"<p class='note'>simulator {html.escape(d.simulator)}; {len(d.fitted_trials)} runs fitted, "
        f"{len(d.held_out_trials)} kept back to judge; floor from {d.floor_source}</p>",
        f"<p class='verdict {d.verdict.value}'>{html.escape(d.sentence)}</p>",
        *(f"<p>Note: {html.escape(words)}.</p>" for words in d.warnings),
        _section("Data faults", _faults(d, paths)),
        _section("Which effects", _causes(d)),
        _section("What these runs cannot tell apart", _alike(d)),
        _section("What to run next", _next(d)),
    ]
    body += [
        f"<h2>{html.escape(name)}</h2>\n<figure role='img' aria-label='{html.escape(name)}'>"
        f"{inline_svg(figure, str(number))}</figure>"
        for number, (name, figure) in enumerate(figures.items())
    ]
    body += [
        _section("Before and after on runs kept back", _channels(d)),
        _section("Smallest sizes that would have shown", _sizes(d)),
        _section("What simpler ways would have said", _baselines(d)),
    ]
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>\n"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        f"<title>Diagnosis: {d.verdict.value}</title>\n<style>{STYLE}{MORE_STYLE}</style></head>\n"
        f"<body>{chr(10).join(part for part in body if part)}\n</body></html>\n"
    )


def _section(title: str, table: str) -> str:
    return f"<h2>{html.escape(title)}</h2>\n{table}" if table else ""


def _table(head: Sequence[str], rows: Rows) -> str:
    if not rows:
        return ""
    top = "".join(f"<th scope='col'>{html.escape(one)}</th>" for one in head)
    body = "\n".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table><thead><tr>{top}</tr></thead>\n<tbody>{body}</tbody></table>"


def _percent(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.0%}"


def _faults(d: Diagnosis, paths: Sequence[Path]) -> str:
    rows = [
        (
            fault.kind + (" (severe)" if fault.severe else ""),
            fault.channel,
            paths[one.trial].name,
            fault.evidence,
        )
        for one in d.data_faults
        for fault in one.faults
    ]
    return _table(("fault", "channel", "file", "evidence"), rows)


def _causes(d: Diagnosis) -> str:
    if d.verdict is Verdict.NO_GAP:
        return ""
    rows = [
        (
            cause_words(one),
            one.stage,
            f"{one.probability:.2f}",
            _percent(one.shrink),
            f"{one.nats:.0f} +- {one.nats_error:.0f} nats on unseen blocks; alone {_percent(one.alone)}, "
            f"last in {_percent(one.last)}",
            f"{one.physics} {one.remedy}",
        )
        for one in d.causes
    ]
    rows += [
        (f"{place_words(one.effect, one.joints)} instead", "", f"{one.probability:.2g}", "", "", "")
        for one in sorted(d.rivals, key=lambda r: -r.probability)[:5]
        if one.probability > 1e-3
    ]
    rows.append(("none of the catalogue", "", f"{d.none:.2f}", "", "", ""))
    return _table(
        ("cause", "stage", "probability", "closes", "evidence", "what it is, what to do"), rows
    )


def _alike(d: Diagnosis) -> str:
    rows = [
        (
            place_words(*of),
            place_words(one.effect, one.joints),
            f"{one.separation:.3g}",
            f"{one.behind:.1f} +- {one.error:.1f}",
        )
        for one, of in zip(d.ambiguous, d.ambiguous_of, strict=True)
    ]
    return _table(("named", "or", "separation (22 tells)", "nats behind"), rows)


def _next(d: Diagnosis) -> str:
    rows = [
        (one.name, " / ".join(one.pair), f"{one.separation:.3g}", f"{one.minutes:.1f}", one.limits)
        for one in d.next
    ]
    return _table(("run", "tells", "separation a run", "minutes", "mind"), rows)


def _channels(d: Diagnosis) -> str:
    rows = [
        (
            f"{c.channel} {c.joint}".strip(),
            f"{c.before:.3g}",
            f"{c.after:.3g}",
            f"{c.floor:.3g}",
            c.unit,
        )
        for c in d.far.channels
    ]
    return _table(("channel", "RMS before", "after", "floor", "unit"), rows)


def _sizes(d: Diagnosis) -> str:
    rows = [(s.effect, s.parameter, f"{s.size:.3g} {s.unit}") for s in d.detectable]
    return _table(("effect", "number", "smallest size"), rows)


def _baselines(d: Diagnosis) -> str:
    rows = [(b.method, "; ".join(place_words(e, j) for e, j in b.causes)) for b in d.baselines]
    return _table(("way", "would have said"), rows)
