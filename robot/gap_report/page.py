"""A diagnosis as one self-contained page: the answer first, then what it rests on."""

import html
import math
from collections.abc import Sequence
from pathlib import Path

from gap.diagnosis.findings import Diagnosis, Verdict
from gap.interfaces import place_words
from gap.rounding import percent_words
from robot.gap_report.faults import fault_groups
from robot.gap_report.figures import draw_traces
from robot.gap_report.page_causes import alike_part, causes_part, next_part
from robot.gap_report.page_map import (
    MAP_STYLE,
    leg_phase_map,
    stage_bars,
    stage_leg_map,
    stage_words,
)
from robot.gap_report.subject import Subject, file_words
from robot.gap_report.words import HEADLINES, headline, size_words, stage_note
from robot.report.page import inline_svg, page_frame, section
from robot.report.page_table import folded, note, table, with_sign

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
.traces figure { margin: 0; } .traces figure svg { min-width: 0; }
figure svg { fill: currentColor; background: none !important; }
.wide { overflow-x: auto; } .wide > table td, .wide > table td:last-child { overflow-wrap: break-word; }
thead th { width: auto; }
code { overflow-wrap: anywhere; } .command span { white-space: nowrap; }
summary { cursor: pointer; margin: 1rem 0 0.3rem; font-weight: 600; }
@media (max-width: 40rem) {
  body { margin: 0.5rem auto; padding: 0 0.7rem; } th, td { padding: 0.2rem 0.3rem; font-size: 0.85rem; }
  .traces { grid-template-columns: 1fr; } .facts { gap: 0.4rem 1.2rem; }
  .chain { grid-template-columns: 6.5rem 1fr; } .chain span:nth-child(3n) { grid-column: 1 / 3; }
}
@media print { details > summary { list-style: none; } .card, .chain, .map { break-inside: avoid; } }
"""
# What a machine's joints are called, and what it does, by the simulator's name.
PLACES = {"servo_bench": "joint", "sliding_body": "body"}
LEG = "leg"


def diagnosis_page(d: Diagnosis, subject: Subject) -> str:
    """Return the page.

    Args:
        d: The diagnosis.
        subject: What was diagnosed.
    """
    gap = d.verdict is not Verdict.NO_GAP
    body = [
        "<h1>Simulator against measured runs</h1>",
        note(_subject_words(subject)),
        f"<div class='verdict {d.verdict.value}'><b>{HEADLINES[d.verdict]}</b>"
        f"<span>{html.escape(with_sign(d.sentence))}</span></div>",
        _facts(d),
        *(f"<p class='warn'>{html.escape(words)}.</p>" for words in d.warnings),
        section("Faults of the data", _faults(d, subject.paths)),
        section("Which effects", causes_part(d)),
        section("What these runs cannot tell apart", alike_part(d)),
        section("Where it lies", _where(d)) if gap else section("Each stage", _calm(d)),
        section(f"Before and after, in {_judged(d)}", _traces(d)),
        section("What to run next", next_part(d)),
        folded("Before and after, every channel", _channels(d)) if gap else "",
        (folded if gap else section)("Smallest sizes that would have shown", _sizes(d)),
        folded("What simpler ways would have said", _baselines(d)),
        f"<p class='small'>{_made_of(d, subject.paths)}</p>",
    ]
    title = f"{headline(d)} | {subject.place} | {file_words(subject.trials)}"
    return page_frame(title, body, style=MAP_STYLE + MORE_STYLE)


def _subject_words(subject: Subject) -> str:
    words = [
        f"{subject.place}. Diagnosed {subject.day.isoformat()}.",
        f"Runs: {file_words(subject.trials)}.",
    ]
    if subject.references:
        words.append(f"Healthy runs: {file_words(subject.references)}.")
    return " ".join(words)


def _judged(d: Diagnosis) -> str:
    return "a run kept back" if d.kept_back == "runs kept back" else d.kept_back


def _facts(d: Diagnosis) -> str:
    far, found = d.far, []
    if d.verdict is not Verdict.NO_GAP:
        if not math.isnan(far.shrink):
            found.append(
                (
                    percent_words(far.shrink),
                    f"of the gap closed [{percent_words(far.low)}, {percent_words(far.high)}]: "
                    f"of its energy above the floor, on {d.kept_back}",
                )
            )
        found.append(
            (f"{far.before:.2f} → {far.after:.2f}", "RMS difference; 1 is the floor, without a gap")
        )
        found.append((percent_words(d.none), "chance that it is none of the catalogue"))
    if set(d.fitted_trials) & set(d.held_out_trials):
        count = len(d.fitted_trials)
        of = "run" if count == 1 else "runs, of each"
        found.append((str(count), f"{of}: fitted to the first two thirds, judged by the last"))
    else:
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
    return table(("fault", "channel", "files", "evidence, in the first"), rows)


def _where(d: Diagnosis) -> str:
    return "\n".join([stage_bars(d), note(stage_note(d)), *_maps(d)])


def _calm(d: Diagnosis) -> str:
    """Where there is no gap: what each stage has, and that none of it stands out."""
    maps = folded("Each part of the runs", "\n".join(_maps(d)))
    return f"<p>Nothing stands out.</p>{stage_words(d)}{maps}"


def _maps(d: Diagnosis) -> list[str]:
    """The maps, each below what it shows, in the words of the machine."""
    place = PLACES.get(d.simulator, LEG)
    by_phase, cyclic = leg_phase_map(d)
    by_leg = stage_leg_map(d)
    part = "third of the run"
    if cyclic:
        part = f"part of the {'gait' if place == LEG else 'motion'}"
    of = "" if place == "body" else f" of each {place}"
    behind = "before any cause is added; 1 is what is expected without a gap."
    parts = []
    if by_leg:
        parts.append(
            note(f"Energy of the worst channel of each stage and {place}, {behind}") + by_leg
        )
    if by_phase:
        parts.append(note(f"Energy of the worst channel{of} in each {part}, {behind}") + by_phase)
    return parts


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
    return table(("channel", "RMS before", "after", "floor", "unit"), rows)


def _sizes(d: Diagnosis) -> str:
    rows = [(s.effect, s.parameter, size_words(s)) for s in d.detectable]
    head = ("effect", "number", "smallest size")
    lead = "Each by itself, where it shows least, as far as it acts in proportion to its size."
    return note(lead) + table(head, rows) if rows else ""


def _baselines(d: Diagnosis) -> str:
    rows = [(b.method, "; ".join(place_words(e, j) for e, j in b.causes)) for b in d.baselines]
    return table(("way", "would have said"), rows)


def _made_of(d: Diagnosis, paths: Sequence[Path]) -> str:
    judged = file_words([paths[i] for i in d.held_out_trials])
    if set(d.fitted_trials) & set(d.held_out_trials):
        judged = f"{d.kept_back} ({judged})"
    return html.escape(
        f"Simulator {d.simulator}; floor from {d.floor_source}; judged by {judged}; "
        f"{d.predictions} runs simulated; seed {d.seed}."
    )
