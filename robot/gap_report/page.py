"""A diagnosis as one self-contained page: the answer first, then what it rests on."""

import math
from collections.abc import Sequence
from datetime import date
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.answer.named_cause import NamedCause
from gap.diagnosis.comparison.how_far import Trace
from gap.experiments.next_run import NextRun
from gap.interfaces import place_words
from gap.rounding import percent_words, value_words
from robot.gap_report.page_map import gap_maps, stage_bars, stage_rows
from robot.gap_report.words import (
    AGAIN,
    BOUND,
    ENOUGH,
    LEGGED_SIMULATORS,
    NOT_LEGGED,
    common_pair,
    fault_groups,
    file_words,
    headline,
    held_out_words,
    joint_sizes,
    judged_by_parts,
    likely_rivals,
    pair_words,
    rms_words,
    size_words,
    stage_note,
    verdict_words,
    why_a_gap,
)
from robot.report.packed import packed_floats, script_json
from robot.report.page import render
from robot.report.pictures import page_picture
from robot.report.plots import PREDICTED, STYLE

MOST_RIVALS = 5
MOST_NEXT = 5
AFTER, AFTER_NAME = "#009E73", "with the causes"
NOT_COMPARED = "#808080"
SIZE_IN = (4.8, 2.1)  # as wide as a phone, so that its letters are of a size to be read there
LEAST_SEEN = 0.005
FACTORS = {"m": (1e3, "mm"), "m/s": (1e3, "mm/s"), "rad": (1e3, "mrad"), "rad/s": (1e3, "mrad/s")}


def diagnosis_page(
    d: Diagnosis,
    machine: str,
    day: date,
    trials: Sequence[Path],
    references: Sequence[Path] = (),
    unseen: Sequence[str] = (),
) -> str:
    """Return the page of a diagnosis of a ``machine`` made on a ``day``, with the files of its runs.

    ``unseen`` says in lines what these runs cannot show.
    """
    runs = file_words(trials)
    healthy = f" Healthy runs: {file_words(references)}." if references else ""
    paths = (*trials, *references)
    faults = fault_groups(d.data_faults, paths)
    channels = sorted(d.far.channels, key=lambda c: -(c.before - c.after) / max(c.floor, 1e-12))
    return render(
        "diagnosis.html",
        d=d,
        title=f"{headline(d)} | {machine} | {runs}",
        subject=f"{machine}. Diagnosed {day.isoformat()}. Runs: {runs}.{healthy}",
        unseen=[line.strip() for line in unseen],
        verdict=verdict_words(d),
        mood="unexplained" if d.severe_channels else d.verdict.value,
        gap=d.verdict is not Verdict.NO_GAP,
        numbers=_facts(d),
        severe=[
            (one.kind, one.channel, one.where, one.evidence, f"{one.remedy}, {AGAIN}")
            for one in faults
            if one.severe
        ],
        faults=[
            (one.kind, one.channel, one.where, one.evidence) for one in faults if not one.severe
        ],
        cards=[_card(one, acted_on=one in d.acted_on) for one in d.causes],
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
        stage_note="; ".join(filter(None, (why_a_gap(d), stage_note(d)))),
        maps=gap_maps(d),
        judged=d.held_out,
        traces=[
            page_picture(figure, name, str(number))
            for number, (name, figure) in enumerate(draw_traces(d).items())
        ],
        switches=_switches(d),
        next=_next(d),
        legged=d.simulator in LEGGED_SIMULATORS,
        not_legged=NOT_LEGGED,
        channels=[
            (
                f"{c.channel} {c.joint}".strip(),
                *(rms_words(value) for value in (c.before, c.after, c.floor)),
                c.unit,
            )
            for c in channels
        ],
        sizes=[(s.place, s.parameter, size_words(s)) for s in d.detectable],
        baselines=[
            (b.method, "; ".join(place_words(e, j) for e, j in b.causes)) for b in d.baselines
        ],
        made_of=(
            f"Simulator {d.simulator}; baseline from {d.floor_source}; tested on "
            f"{held_out_words(d, paths, 3)}; {d.false_alarm_words}; {d.predictions} runs simulated; "
            f"seed {d.seed}."
        ),
    )


def _facts(d: Diagnosis) -> list[tuple[str, str]]:
    """The few numbers at the top, each with what it is a number of."""
    far, facts = d.far, []
    if d.verdict is not Verdict.NO_GAP:
        if not math.isnan(far.shrink) and d.causes:
            low, high = percent_words(far.low), percent_words(far.high)
            about = f"of its energy above the baseline, on {d.held_out} ({d.interval_words})"
            facts.append(
                (percent_words(far.shrink), f"of the gap explained [{low}, {high}]: {about}")
            )
        change = f"{rms_words(far.before, '.2f')} → {rms_words(far.after, '.2f')}"
        about = "; ".join(filter(None, ("1 is the baseline, without a gap", far.fed_words)))
        facts.append((change, f"RMS difference; {about}"))
        facts.append((percent_words(d.none), "probability that the cause is not in the catalogue"))
    count = len(d.fitted_trials)
    if judged_by_parts(d):
        of = "run" if count == 1 else "runs, of each"
        facts.append((str(count), f"{of}: fitted on the first two thirds, tested on the last"))
    else:
        facts.append((str(count), "runs fitted"))
        facts.append((str(len(d.held_out_trials)), "held-out runs for testing"))
    return facts


def _card(one: NamedCause, *, acted_on: bool) -> dict[str, object]:
    """A cause: its numbers, what is done about it if it is likely one, and what speaks for it."""
    head, rows = joint_sizes(one)
    numbers = [
        (value_words(v.value, v.error, v.unit), v.name + BOUND * v.on_bound) for v in one.values
    ]
    return {
        "sure": f"{one.probability:.0%}",
        "place": ", ".join(filter(None, (place_words(one.effect, one.joints), one.form_words))),
        "numbers": () if rows else numbers,
        "joints": (head, rows),
        "physics": one.physics,
        "remedy": one.remedy if acted_on else "",
        "evidence": (
            f"Stage {one.stage}. {_explains(one)}Predicts held-out blocks better by {one.nats:.0f} ± "
            f"{one.nats_error:.0f} nats."
            + (f" {one.vibration.words.capitalize()}." if one.vibration else "")
        ),
    }


def _explains(one: NamedCause) -> str:
    """How much of the gap it explains; empty where that is not known."""
    if math.isnan(one.shrink):
        return ""
    return (
        f"Explains {percent_words(one.shrink)} of the gap (alone {percent_words(one.alone)}, added last "
        f"{percent_words(one.last)}; energy above the baseline). "
    )


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


def draw_traces(d: Diagnosis) -> dict[str, Figure]:
    """Draw the channels that the causes change most, in a held-out run, by name."""
    with mpl.rc_context({**STYLE, "font.size": 8}):
        return {
            f"{t.channel} {t.joint}".strip(): _trace(t, d.verdict is not Verdict.NO_GAP)
            for t in shown_traces(d)
        }


def shown_traces(d: Diagnosis) -> list[Trace]:
    """Return the channels that are drawn, those that the causes change most first."""
    return [one for one in d.far.traces if _changed(one)] or list(d.far.traces)


def _switches(d: Diagnosis) -> str:
    """What the script of the switches needs: every set of causes with its RMS and its curves, as JSON."""
    if not d.causes or d.verdict is Verdict.NO_GAP:
        return ""
    content = {
        "causes": [place_words(one.effect, one.joints) for one in d.causes],
        "sets": d.far.sets,
        "rms": [None if math.isnan(one) else one for one in d.far.rms],
        "curve": AFTER_NAME,
        "curves": [packed_floats(_in_unit(t)[0] * t.each) for t in shown_traces(d)],
    }
    return script_json(content)


def _in_unit(trace: Trace) -> tuple[float, str]:
    """Factor and name of the unit that a channel is drawn in."""
    return FACTORS.get(trace.unit, (1.0, trace.unit))


def _changed(trace: Trace) -> bool:
    """Whether the causes make a difference that an eye can see."""
    change = np.nanmax(np.abs(trace.after - trace.before), initial=0.0)
    low, high = (
        np.nanmin(trace.measured, initial=np.inf),
        np.nanmax(trace.measured, initial=-np.inf),
    )
    return bool(change > LEAST_SEEN * (high - low))


def _trace(trace: Trace, gap: bool) -> Figure:
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    figure.patch.set_alpha(0.0)
    ax = figure.subplots()
    ax.patch.set_alpha(0.0)
    factor, unit = _in_unit(trace)
    lines = [
        (trace.measured, "black", "-", 1.6, "measured"),
        (trace.before, PREDICTED, ":", 1.2, "simulator before" if gap else "simulator"),
    ]
    if gap:
        lines.append((trace.after, AFTER, "--", 1.2, AFTER_NAME))
    for values, colour, style, width, label in lines:
        ax.plot(trace.time_s, factor * values, color=colour, ls=style, lw=width, label=label)
    if not trace.compared.all():
        ax.fill_between(
            trace.time_s, 0.0, 1.0, where=~trace.compared, transform=ax.get_xaxis_transform(),
            color=NOT_COMPARED, alpha=0.25, lw=0, label="not compared",
        )  # fmt: skip
    ax.set_ylabel(f"{trace.channel} {trace.joint} [{unit}]".replace("  ", " "))
    ax.set_xlabel("time [s]")
    columns = 3 if trace.compared.all() else 2
    figure.legend(loc="outside upper center", ncols=columns, frameon=False, fontsize=8)
    return figure
