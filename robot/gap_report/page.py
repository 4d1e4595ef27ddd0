"""A diagnosis as one self-contained page: the answer first, then what it rests on."""

import math
from collections.abc import Sequence
from pathlib import Path

from gap.diagnosis.findings import Diagnosis, NamedCause, Verdict
from gap.experiments.next_run import NextRun
from gap.interfaces import place_words
from gap.rounding import percent_words, value_words
from robot.gap_report.figures import draw_traces
from robot.gap_report.page_map import gap_maps, stage_bars, stage_rows
from robot.gap_report.words import (
    ENOUGH,
    HEADLINES,
    LEGGED_SIMULATORS,
    NOT_LEGGED,
    Subject,
    common_pair,
    fault_groups,
    file_words,
    headline,
    likely_rivals,
    pair_words,
    size_words,
    stage_note,
)
from robot.report.page import render
from robot.report.pictures import inline_svg

MOST_RIVALS = 5
MOST_NEXT = 5


def diagnosis_page(d: Diagnosis, subject: Subject) -> str:
    """Return the page.

    Args:
        d: The diagnosis.
        subject: What was diagnosed.
    """
    channels = sorted(d.far.channels, key=lambda c: -(c.before - c.after) / max(c.floor, 1e-12))
    return render(
        "diagnosis.html",
        d=d,
        title=f"{headline(d)} | {subject.place} | {file_words(subject.trials)}",
        subject=_subject_words(subject),
        verdict=HEADLINES[d.verdict],
        gap=d.verdict is not Verdict.NO_GAP,
        numbers=_facts(d),
        faults=[
            (one.kind + " (severe)" * one.severe, one.channel, one.where, one.evidence)
            for one in fault_groups(d.data_faults, subject.paths)
        ],
        cards=[_card(one) for one in d.causes],
        rivals=[
            (place_words(*one.of), place_words(one.effect, one.joints), f"{one.probability:.2f}")
            for one in likely_rivals(d)[:MOST_RIVALS]
        ],
        enough=ENOUGH,
        alike=[
            (
                place_words(*one.of),
                place_words(one.effect, one.joints),
                f"{one.separation:.3g}",
                value_words(one.behind, one.behind_error),
                one.why,
            )
            for one in d.ambiguous
        ],
        stages=stage_bars(d),
        calm=stage_rows(d),
        stage_note=stage_note(d),
        maps=gap_maps(d),
        judged="a held-out run" if d.kept_back == "runs kept back" else d.kept_back,
        traces=[
            (name, inline_svg(figure, str(number)))
            for number, (name, figure) in enumerate(draw_traces(d).items())
        ],
        next=_next(d),
        legged=d.simulator in LEGGED_SIMULATORS,
        not_legged=NOT_LEGGED,
        channels=[
            (
                f"{c.channel} {c.joint}".strip(),
                *(f"{value:.3g}" for value in (c.before, c.after, c.floor)),
                c.unit,
            )
            for c in channels
        ],
        sizes=[(s.effect, s.parameter, size_words(s)) for s in d.detectable],
        baselines=[
            (b.method, "; ".join(place_words(e, j) for e, j in b.causes)) for b in d.baselines
        ],
        made_of=_made_of(d, subject.paths),
    )


def _subject_words(subject: Subject) -> str:
    words = f"{subject.place}. Diagnosed {subject.day.isoformat()}. "
    words += f"Runs: {file_words(subject.trials)}."
    if subject.references:
        words += f" Healthy runs: {file_words(subject.references)}."
    return words


def _facts(d: Diagnosis) -> list[tuple[str, str]]:
    """The few numbers at the top, each with what it is a number of."""
    far, facts = d.far, []
    if d.verdict is not Verdict.NO_GAP:
        if not math.isnan(far.shrink):
            low, high = percent_words(far.low), percent_words(far.high)
            about = f"of its energy above the floor, on {d.kept_back}"
            facts.append((percent_words(far.shrink), f"of the gap closed [{low}, {high}]: {about}"))
        change = f"{far.before:.2f} → {far.after:.2f}"
        facts.append((change, "RMS difference; 1 is the floor, without a gap"))
        facts.append((percent_words(d.none), "chance that it is none of the catalogue"))
    count = len(d.fitted_trials)
    if set(d.fitted_trials) & set(d.held_out_trials):
        of = "run" if count == 1 else "runs, of each"
        facts.append((str(count), f"{of}: fitted to the first two thirds, judged by the last"))
    else:
        facts.append((str(count), "runs fitted"))
        facts.append((str(len(d.held_out_trials)), "held-out runs, which judge"))
    return facts


def _card(one: NamedCause) -> dict[str, object]:
    """A cause: its numbers, what is done about it, and what speaks for it."""
    return {
        "sure": f"{one.probability:.0%}",
        "place": place_words(one.effect, one.joints),
        "numbers": [
            (value_words(v.value, v.error, v.unit), v.name + " (on its bound)" * v.on_bound)
            for v in one.values
        ],
        "physics": one.physics,
        "remedy": one.remedy,
        "evidence": (
            f"Stage {one.stage}. Closes {percent_words(one.shrink)} of the gap (by itself "
            f"{percent_words(one.alone)}, on top of the others {percent_words(one.last)}; energy above the "
            f"floor); predicts held-out blocks better by {one.nats:.0f} ± {one.nats_error:.0f} nats."
        ),
    }


def _next(d: Diagnosis) -> dict[str, object]:
    """The best discriminating runs."""
    shown = d.next[:MOST_NEXT]
    pair = common_pair(shown)
    limits = any(one.limits for one in shown)

    def row(one: NextRun) -> list[object]:  # its first cell is a name with a command
        between = [] if pair else [pair_words(one)]
        figures = [f"{one.separation:.3g}", str(one.runs), f"{one.minutes:.1f}"]
        return [one, *between, *figures, *([one.limits or "-"] if limits else [])]

    return {
        "lead": (f"Each distinguishes {pair}. " if pair else "")
        + f"The separation is that of one run; {ENOUGH} is enough. The best is first.",
        "head": ("run", *(() if pair else ("distinguishes",)), "separation", "runs", "minutes",
                 *(("caution",) if limits else ())),
        "rows": [row(one) for one in shown],
        "more": len(d.next) - len(shown),
    }  # fmt: skip


def _made_of(d: Diagnosis, paths: Sequence[Path]) -> str:
    judged = file_words([paths[i] for i in d.held_out_trials])
    if set(d.fitted_trials) & set(d.held_out_trials):
        judged = f"{d.kept_back} ({judged})"
    return (
        f"Simulator {d.simulator}; floor from {d.floor_source}; judged by {judged}; "
        f"{d.predictions} runs simulated; seed {d.seed}."
    )
