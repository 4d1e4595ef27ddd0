"""A diagnosis as lines for a terminal: the answer first, then what it rests on."""

import math
import shlex
from collections.abc import Sequence
from pathlib import Path

from gap.diagnosis.answer.findings import Diagnosis, Verdict, improves
from gap.diagnosis.answer.named_cause import NamedCause
from gap.interfaces import place_words
from gap.rounding import percent_words
from robot.console.json_output import to_stdout
from robot.console.screen_fit import WIDTH, wrapped
from robot.console.table import Column, table_lines
from robot.gap_report.words import (
    AGAIN,
    LEGGED_SIMULATORS,
    NOT_LEGGED,
    changed_channels,
    common_pair,
    fault_groups,
    few,
    held_out_words,
    joint_sizes,
    pair_words,
    rms_words,
    size_words,
    stage_note,
    whole_words,
    why_a_gap,
)

BAR = 20
FIXED = 48  # columns of the table of stages besides its bars
MOST_CHANNELS = 6
MOST_SIZES = 12
MOST_NEXT = 3
MOST_JOINTS = 12
LOOK_THERE = (
    "what to do: look for what the catalogue does not have, where most of the gap is (below); an effect of "
    "your own can be tried with --effects FILE.py"
)
TO_APPLY = "to apply: write the diagnosis with --json d.json, then: bigant gap apply d.json"


def summary_lines(
    d: Diagnosis, paths: Sequence[Path], width: int = WIDTH, json: Path | None = None
) -> list[str]:
    """Return the lines, none longer than ``width`` but command lines, which are there to be copied.

    The paths are those of the trials and the references, in their order; ``json`` is the file of the
    diagnosis, None if it is not written.
    """
    severe, faults = _faults(d, paths)
    lines = [d.headline, *severe, d.sentence, *_to_do(d, json), "", *faults]
    if d.verdict is not Verdict.NO_GAP:
        lines += [why_a_gap(d), "", *_where(d, width), "", *_causes(d), "", *_how_far(d)]
    else:
        lines += _sizes(d)
    lines += _next(d)
    if d.warnings:
        lines += ["", *(f"note: {words}" for words in d.warnings)]
    if d.standing:
        lacks = ", ".join(place_words(one.effect, one.joints) for one in d.standing)
        lines.append(f"baseline model errors, also in healthy runs: {lacks}")
    judges = held_out_words(d, paths, MOST_CHANNELS)
    lines.append(f"held out for testing: {judges}; baseline from {d.floor_source}")
    lines.append(d.false_alarm_words)
    spaced = [line for i, line in enumerate(lines) if line or (i and lines[i - 1])]
    return [piece for line in spaced for piece in wrapped(line, width)]


def _to_do(d: Diagnosis, json: Path | None) -> list[str]:
    """What a person does now, before any figures; nothing about causes that cannot be trusted."""
    if d.verdict is Verdict.NO_GAP or d.severe_channels:
        return []
    legged, lines = d.simulator in LEGGED_SIMULATORS, []
    for one in d.acted_on:
        about = "" if len(d.causes) == 1 else f" about {place_words(one.effect, one.joints)}"
        lines.append(f"what to do{about}: {one.remedy}")
    if d.change is not None:
        lines.append(f"what to do, before and after a run: {d.change.remedy}")
    if d.verdict is Verdict.UNEXPLAINED and not lines and not d.hunts_for_nothing:
        lines.append(LOOK_THERE)
    if d.verdict is Verdict.AMBIGUOUS:
        run = "bigant gap next" if legged else NOT_LEGGED
        lines.append(f"run that settles it: {run}")
    if legged and d.causes and d.verdict is not Verdict.UNEXPLAINED:
        written = json is not None and not to_stdout(json)
        lines += (
            ["to apply:", f"  bigant gap apply {shlex.quote(str(json))}"] if written else [TO_APPLY]
        )
    return lines


def _faults(d: Diagnosis, paths: Sequence[Path]) -> tuple[list[str], list[str]]:
    """Severe faults of the data with what to do about them, and the others."""
    groups = fault_groups(d.data_faults, paths)
    severe = [one for one in groups if one.severe]
    first: list[str] = []
    for number, one in enumerate(severe[:MOST_CHANNELS], 1):
        first.append(f"  {number}. {one.kind} {one.channel} in {one.where}: {one.evidence}")
        first.append(f"     what to do: {one.remedy}, {AGAIN}")
    first += _more(len(severe))
    rows = [
        f"  {one.kind} {one.channel} in {one.where}: {one.evidence}"
        for one in groups
        if not one.severe
    ]
    others = [*rows[:MOST_CHANNELS], *_more(len(rows))]
    return (
        ["severe faults of the data:", *first, ""] if first else [],
        [f"{'other ' if first else ''}data faults:", *others, ""] if others else [],
    )


def _more(count: int) -> list[str]:
    """How many faults are not shown, as a line if there are any."""
    return [f"  and {count - MOST_CHANNELS} more, in --json"] if count > MOST_CHANNELS else []


def _where(d: Diagnosis, width: int) -> list[str]:
    room = min(BAR, width - FIXED)
    columns = (
        Column("stage"), Column("of gap", "s"), Column("", width=room),
        Column("by itself", ".3g"), Column("end to end", ".3g"),
    )  # fmt: skip
    rows = [
        (
            one.stage,
            percent_words(one.share),
            "#" * round(room * one.share),
            one.own,
            one.end_to_end,
        )
        for one in d.where.stages
        if not math.isnan(one.own)
    ]
    lines = ["where (energy over its expected value; 1 is no gap):"]
    lines += table_lines(columns, rows, "  ")
    lines += _joints(d)
    for cell in d.where.cells[:3]:
        phase = f" at phase {cell.phase:.2f}" if not math.isnan(cell.phase) else ""
        place = f" {cell.joint}" if cell.joint else ""
        lines.append(
            f"  {cell.channel}{place}{phase}: off by {cell.mean:+.2g} times its baseline (p {cell.p:.3f})"
        )
    if stage_note(d):
        lines.append(f"  {stage_note(d)}")
    return lines


def _joints(d: Diagnosis) -> list[str]:
    """Each joint's part of the gap: those that are measured in one channel together."""
    if len(d.where.joints) < 2 or not any(one.share > 0.0 for one in d.where.joints):
        return []
    groups: dict[str, list[str]] = {}
    for one in d.where.joints:
        size = "" if math.isnan(one.rms) else f" ({one.rms:.3g} {one.unit})"
        groups.setdefault(one.channel, []).append(f"{one.joint} {percent_words(one.share)}{size}")
    head = "joints, by" if len(groups) == 1 else "by"
    return [f"  {head} {name}: {few(shown, MOST_JOINTS)}" for name, shown in groups.items()]


def _causes(d: Diagnosis) -> list[str]:
    if not d.causes:
        return [f"which: {d.no_cause_words}"]
    lines = ["which:"]
    for number, one in enumerate(d.causes, 1):
        head, rows = joint_sizes(one)
        lines.append(f"  {number}. {place_words(one.effect, one.joints) if rows else one.words}")
        lines += table_lines([Column(name) for name in head], rows, "     ") if rows else []
        lines.append(f"     probability {one.probability:.2f}, stage {one.stage}{_share(one)}")
        lines.append(f"     {one.physics}")
        lines += [f"     {one.vibration.words}"] if one.vibration else []
    for rival in d.ambiguous:
        place = place_words(rival.effect, rival.joints)
        named = place_words(*rival.of)
        apart = f"  or {place} instead of {named} ({rival.why})"
        alike = f"  indistinguishable from {named}: {place} ({rival.why})"
        lines.append(apart if rival.is_distinguished else alike)
    lines.append(f"  none of the catalogue: probability {d.none:.2f}")
    return lines


def _share(one: NamedCause) -> str:
    if math.isnan(one.shrink):
        return ""
    alone, last = percent_words(one.alone), percent_words(one.last)
    return f", explains {percent_words(one.shrink)} (alone {alone}, added last {last})"


def _how_far(d: Diagnosis) -> list[str]:
    far, fed = d.far, [f"  {d.far.fed_words}"] if d.far.fed_words else []
    if not d.causes:
        return [
            f"how far: no cause is named, so nothing is explained; RMS over all channels "
            f"{rms_words(far.before)} of its baseline on {d.held_out}",
            *fed,
        ]
    change = f"RMS {rms_words(far.before)} -> {rms_words(far.after)} of its baseline"
    if math.isnan(far.after):
        return [
            f"how far: not known, as the simulation with {whole_words(d)} breaks down on {d.held_out}",
            *fed,
        ]
    if math.isnan(far.shrink):
        return [
            f"how far: on {d.held_out} the gap is too small to measure how much is explained; {change}",
            *fed,
        ]
    low, high = percent_words(far.low), percent_words(far.high)
    share = f"{percent_words(far.shrink)} [{low}, {high}]"
    if improves(far.shrink):
        what = f"{share} of the gap, as energy above the baseline, is explained on {d.held_out}"
    else:
        what = f"{d.held_out} is predicted no better with {whole_words(d)} ({share} of the gap, as energy)"
    lines = [f"how far: {what}; {change}", *fed, f"  {d.interval_words}"]
    lines += changed_channels(far, MOST_CHANNELS)
    if d.remaining.stage:
        lines.append(f"  the residual is in the stage {d.remaining.stage}")
    return lines


def _sizes(d: Diagnosis) -> list[str]:
    if not d.detectable:
        return []
    whole = [one for one in d.detectable if "@" not in one.parameter]  # else joint by joint as well
    hidden_most = sorted(whole, key=lambda one: -one.of_range)
    sized = [one for one in hidden_most if one.values]
    blind = [f"{one.effect} {one.parameter}" for one in hidden_most if not one.values]
    rows = [(s.place, s.parameter, size_words(s)) for s in sized[:MOST_SIZES]]
    lines = []
    if sized:
        lines.append("smallest sizes that would have been detected, what could hide best first:")
        lines += table_lines((Column(""),) * 3, rows, "  ")
    if blind:
        lines.append(f"not detectable at any size that makes sense: {few(blind, MOST_SIZES)}")
    if len(d.detectable) > len(rows) + min(len(blind), MOST_SIZES):
        lines.append("  all sizes are in --html and --json")
    return lines


def _next(d: Diagnosis) -> list[str]:
    if not d.next or d.severe_channels:  # no run settles what data with a fault leave open
        return []
    shown = d.next[:MOST_NEXT]
    pair = common_pair(shown)
    lines = ["", f"what to run next, to tell {pair}:" if pair else "what to run next:"]
    for one in shown:
        tells = "" if pair else f"tells {pair_words(one)} in "
        limits = f"; {one.limits}" if one.limits else ""
        runs = "1 run" if one.runs == 1 else f"{one.runs} runs"
        lines.append(f"  {one.name}: {tells}{runs}, {one.minutes:.1f} min{limits}")
        if one.command:
            lines.append(f"    {one.command}")
    return lines
