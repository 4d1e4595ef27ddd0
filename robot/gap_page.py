"""A diagnosis as one self-contained page: the answer first, then what it rests on."""

import html
import math
import re
from collections.abc import Sequence
from pathlib import Path

from gap.ambiguity import why_open
from gap.findings import Diagnosis, NamedCause, Verdict
from gap.interfaces import place_words
from robot.gap_faults import fault_groups
from robot.gap_figures import draw_traces
from robot.gap_page_map import MAP_STYLE, leg_phase_map, stage_bars, stage_leg_map
from robot.report_page import inline_svg, page_frame

MORE_STYLE = """
h1 { font-size: 1.15rem; font-weight: 500; color: var(--faint); }
.verdict { border-left: 0.4rem solid #0072B2; padding: 0.2rem 0 0.2rem 0.8rem; margin: 1rem 0; }
.verdict b { display: block; font-size: 1.5rem; } .verdict span { font-size: 1.1rem; }
.unexplained { border-color: #D55E00; } .ambiguous { border-color: #E69F00; }
.no_gap { border-color: #009E73; }
.facts { display: flex; flex-wrap: wrap; gap: 0.5rem 2rem; margin: 1rem 0; }
.facts div { min-width: 6rem; } .facts b { display: block; font-size: 1.3rem; }
.facts span, .small { color: var(--faint); font-size: 0.85rem; }
.card { border: 1px solid var(--line); border-radius: 8px; padding: 0.6rem 0.9rem; margin: 0.7rem 0;
        break-inside: avoid; }
.card h3 { margin: 0; font-size: 1.05rem; } .card p { margin: 0.3rem 0; }
.card .sure { float: right; font-weight: 700; margin-left: 1rem; }
.warn { border-left: 0.3rem solid #D55E00; padding-left: 0.7rem; }
.traces { display: grid; grid-template-columns: repeat(auto-fit, minmax(20rem, 1fr)); gap: 0.5rem; }
.traces figure { margin: 0; } figure svg { fill: currentColor; background: none !important; }
.wide { overflow-x: auto; } .wide > table td { overflow-wrap: break-word; } thead th { width: auto; }
code { overflow-wrap: anywhere; } summary { cursor: pointer; margin: 1rem 0 0.3rem; font-weight: 600; }
@media (max-width: 40rem) {
  body { margin: 0.5rem auto; padding: 0 0.7rem; } th, td { padding: 0.2rem 0.3rem; font-size: 0.85rem; }
  .traces { grid-template-columns: 1fr; } .facts { gap: 0.4rem 1.2rem; }
  .chain { grid-template-columns: 6.5rem 1fr; } .chain span:nth-child(3n) { grid-column: 1 / 3; }
}
@media print { details > summary { list-style: none; } .card, .chain, .map { break-inside: avoid; } }
"""
HEADLINES = {
    Verdict.EXPLAINED: "Explained",
    Verdict.AMBIGUOUS: "Found, but not told apart",
    Verdict.UNEXPLAINED: "Not explained",
    Verdict.NO_GAP: "No gap",
}
MOST_RIVALS = 5
Rows = Sequence[Sequence[str]]


def diagnosis_page(d: Diagnosis, paths: Sequence[Path]) -> str:
    """Return the page.

    Args:
        d: The diagnosis.
        paths: Files of the trials and the references, in their order.
    """
    body = [
        "<h1>Simulator against measured runs</h1>",
        f"<div class='verdict {d.verdict.value}'><b>{HEADLINES[d.verdict]}</b>"
        f"<span>{html.escape(d.sentence.replace('+-', '±'))}</span></div>",
        _facts(d),
        *(f"<p class='warn'>{html.escape(words)}.</p>" for words in d.warnings),
        _section("Faults of the data", _faults(d, paths)),
        _section("Which effects", _causes(d)),
        _section("What these runs cannot tell apart", _alike(d)),
        _section("What to run next", _next(d)),
        _section("Where it lies", _where(d)),
        _section("Before and after, in a run kept back", _traces(d)),
        _folded("Before and after, every channel", _channels(d)),
        _folded("Smallest sizes that would have shown", _sizes(d)),
        _folded("What simpler ways would have said", _baselines(d)),
        f"<p class='small'>{_made_of(d, paths)}</p>",
    ]
    return page_frame(f"Diagnosis: {d.verdict.value}", body, style=MAP_STYLE + MORE_STYLE)


def _section(title: str, content: str) -> str:
    return f"<h2>{html.escape(title)}</h2>\n{content}" if content else ""


def _folded(title: str, content: str) -> str:
    if not content:
        return ""
    return f"<details><summary>{html.escape(title)}</summary>\n{content}</details>"


def _table(head: Sequence[str], rows: Rows) -> str:
    if not rows:
        return ""
    top = "".join(f"<th scope='col'>{html.escape(one)}</th>" for one in head)
    body = "\n".join(
        "<tr>" + "".join(f"<td>{_cell(text)}</td>" for text in row) + "</tr>" for row in rows
    )
    return f"<div class='wide'><table><thead><tr>{top}</tr></thead>\n<tbody>{body}</tbody></table></div>"


def _cell(text: str) -> str:
    """A name may break behind an underscore or the dot of a file, and nowhere else."""
    return re.sub(r"([_/]|\.(?=[a-z]))", r"\1<wbr>", html.escape(text))


def _percent(value: float) -> str:
    return "?" if math.isnan(value) else f"{value:.0%}"


def _facts(d: Diagnosis) -> str:
    far, found = d.far, []
    if d.verdict is not Verdict.NO_GAP:
        if not math.isnan(far.shrink):
            found.append(
                (
                    _percent(far.shrink),
                    f"of the gap closed on runs kept back [{far.low:.0%}, {far.high:.0%}]",
                )
            )
        found.append((f"{far.before:.2f} → {far.after:.2f}", "RMS difference, in floors"))
        found.append((_percent(d.none), "chance that it is none of the catalogue"))
    found.append((str(len(d.fitted_trials)), "runs fitted"))
    found.append((str(len(d.held_out_trials)), "runs kept back to judge"))
    cells = "".join(
        f"<div><b>{html.escape(big)}</b><span>{html.escape(small)}</span></div>"
        for big, small in found
    )
    return f"<div class='facts'>{cells}</div>"


def _faults(d: Diagnosis, paths: Sequence[Path]) -> str:
    rows = [
        (
            one.kind + (" (severe)" if one.severe else ""),
            one.channel,
            one.where,
            one.evidence,
        )
        for one in fault_groups(d.data_faults, paths)
    ]
    return _table(("fault", "channel", "files", "evidence, in the first"), rows)


def _causes(d: Diagnosis) -> str:
    if d.verdict is Verdict.NO_GAP:
        return ""
    if not d.causes:
        return "<p>No effect of the catalogue reduces it.</p>"
    cards = "\n".join(_card(number, one) for number, one in enumerate(d.causes, 1))
    likely = sorted(d.rivals, key=lambda r: -r.probability)[:MOST_RIVALS]
    rows = [
        (place_words(one.effect, one.joints), f"{one.probability:.2g}")
        for one in likely
        if one.probability > 1e-3
    ]
    rows.append(("none of the catalogue", f"{d.none:.2f}"))
    return f"{cards}\n{_table(('instead', 'probability'), rows)}"


def _card(number: int, one: NamedCause) -> str:
    values = [
        (
            v.name,
            f"{v.value:.3g} ± {v.error:.1g} {v.unit}" + (" (on its bound)" if v.on_bound else ""),
        )
        for v in one.values
    ]
    numbers = "".join(
        f"<div><b>{html.escape(text)}</b><span>{html.escape(name)}</span></div>"
        for name, text in values
    )
    evidence = (
        f"Stage {one.stage}. Closes {_percent(one.shrink)} of the gap (by itself {_percent(one.alone)}, "
        f"on top of the others {_percent(one.last)}); predicts unseen blocks better by {one.nats:.0f} ± "
        f"{one.nats_error:.0f} nats."
    )
    return (
        f"<div class='card'><span class='sure'>{one.probability:.0%} sure</span>"
        f"<h3>{number}. {html.escape(place_words(one.effect, one.joints))}</h3>"
        f"<div class='facts'>{numbers}</div><p>{html.escape(one.physics)}</p>"
        f"<p><b>What to do:</b> {html.escape(one.remedy)}</p>"
        f"<p class='small'>{html.escape(evidence)}</p></div>"
    )


def _alike(d: Diagnosis) -> str:
    rows = [
        (
            place_words(*of),
            place_words(one.effect, one.joints),
            f"{one.separation:.3g}",
            f"{one.behind:.1f} ± {one.error:.1f}",
            why_open(one),
        )
        for one, of in zip(d.ambiguous, d.ambiguous_of, strict=True)
    ]
    return _table(("named", "or", "separation (22 tells)", "nats behind", "why it is open"), rows)


def _next(d: Diagnosis) -> str:
    rows = [
        (
            f"{one.name}: {one.command}" if one.command else one.name,
            " / ".join(one.pair),
            f"{one.separation:.3g}",
            f"{one.minutes:.1f}",
            one.limits,
        )
        for one in d.next
    ]
    table = _table(("run", "tells", "separation a run", "minutes", "mind"), rows)
    if table or not d.ambiguous:
        return table
    return "<p>Ask <code>bigant gap next</code> for the run that would tell them apart.</p>"


def _where(d: Diagnosis) -> str:
    parts = [stage_bars(d)]
    by_phase, by_leg = leg_phase_map(d), stage_leg_map(d)
    note = (
        "<p class='small'>{}, before any cause is added; 1 is what is expected without a gap.</p>"
    )
    if by_leg:
        parts.append(note.format("Energy of the worst channel of each stage and leg") + by_leg)
    if by_phase:
        parts.append(
            note.format("Energy of the worst channel of each leg along the gait") + by_phase
        )
    return "\n".join(parts)


def _traces(d: Diagnosis) -> str:
    figures = draw_traces(d)
    if not figures:
        return ""
    drawn = "".join(
        f"<figure role='img' aria-label='{html.escape(name)}'>"
        f"{_on_paper(inline_svg(figure, str(number)))}</figure>"
        for number, (name, figure) in enumerate(figures.items())
    )
    return f"<div class='traces'>{drawn}</div>"


def _on_paper(svg: str) -> str:
    """Draw what is black in the colour of the page's letters."""
    return svg.replace("stroke: #000000", "stroke: currentColor").replace(
        "fill: #000000", "fill: currentColor"
    )


def _channels(d: Diagnosis) -> str:
    rows = [
        (
            f"{c.channel} {c.joint}".strip(),
            f"{c.before:.3g}",
            f"{c.after:.3g}",
            f"{c.floor:.3g}",
            c.unit,
        )
        for c in sorted(d.far.channels, key=lambda c: -(c.before - c.after) / max(c.floor, 1e-12))
    ]
    return _table(("channel", "RMS before", "after", "floor", "unit"), rows)


def _sizes(d: Diagnosis) -> str:
    rows = [(s.effect, s.parameter, f"{s.size:.3g} {s.unit}") for s in d.detectable]
    return _table(("effect", "number", "smallest size"), rows)


def _baselines(d: Diagnosis) -> str:
    rows = [(b.method, "; ".join(place_words(e, j) for e, j in b.causes)) for b in d.baselines]
    return _table(("way", "would have said"), rows)


def _made_of(d: Diagnosis, paths: Sequence[Path]) -> str:
    judged = ", ".join(paths[i].name for i in d.held_out_trials)
    return html.escape(
        f"Simulator {d.simulator}; floor from {d.floor_source}; judged by {judged}; "
        f"{d.predictions} runs simulated; seed {d.seed}."
    )
