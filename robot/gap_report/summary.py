"""A diagnosis as lines for a terminal: the answer first, then what it rests on."""

import math
from collections.abc import Sequence
from pathlib import Path

from gap.diagnosis.findings import Diagnosis, NamedCause, Verdict
from gap.interfaces import place_words
from gap.rounding import percent_words
from robot.console.screen_fit import WIDTH, wrapped
from robot.console.table import Column, table_lines
from robot.gap_report.words import (
    LEGGED_SIMULATORS,
    NOT_LEGGED,
    changed_channels,
    common_pair,
    fault_groups,
    few,
    held_out_words,
    joint_sizes,
    pair_words,
    size_words,
    stage_note,
)

BAR = 20
FIXED = 48  # columns of the table of stages besides its bars
MOST_CHANNELS = 6
MOST_SIZES = 12
MOST_NEXT = 3
MOST_JOINTS = 12


def summary_lines(d: Diagnosis, paths: Sequence[Path], width: int = WIDTH) -> list[str]:
    """Return the lines, none longer than ``width`` but command lines, which are there to be copied.

    The paths are those of the trials and the references, in their order.
    """
    lines = [d.verdict.headline, d.sentence]
    lines += [*_to_do(d), "", *_faults(d, paths)]
    if d.verdict is not Verdict.NO_GAP:
        lines += [*_where(d, width), "", *_causes(d), "", *_how_far(d)]
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


def _to_do(d: Diagnosis) -> list[str]:
    """What a person does now, before any figures."""
    if d.verdict is Verdict.NO_GAP:
        return []
    legged, lines = d.simulator in LEGGED_SIMULATORS, []
    causes = d.sure if d.verdict is Verdict.EXPLAINED else d.causes
    for one in causes:
        about = "" if len(causes) == 1 else f" about {place_words(one.effect, one.joints)}"
        lines.append(f"what to do{about}: {one.remedy}")
    if d.verdict is Verdict.AMBIGUOUS:
        run = "bigant gap next" if legged else NOT_LEGGED
        lines.append(f"run that settles it: {run}")
    if legged and d.causes and d.verdict is not Verdict.UNEXPLAINED:
        lines.append(
            "to apply: write the diagnosis with --json d.json, then: bigant gap apply d.json"
        )
    return lines


def _faults(d: Diagnosis, paths: Sequence[Path]) -> list[str]:
    rows = [
        f"  {'severe ' if one.severe else ''}{one.kind} {one.channel} in {one.where}: {one.evidence}"
        for one in fault_groups(d.data_faults, paths)
    ]
    if len(rows) > MOST_CHANNELS:
        rows = [*rows[:MOST_CHANNELS], f"  and {len(rows) - MOST_CHANNELS} more, in --json"]
    return ["data faults:", *rows, ""] if rows else []


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
    if len(d.where.joints) > 1:
        shown = [
            f"{one.joint} {percent_words(one.share)} ({one.rms:.3g} {one.unit})"
            for one in d.where.joints
        ]
        lines.append(f"  joints, by {d.where.joints[0].channel}: {few(shown, MOST_JOINTS)}")
    for cell in d.where.cells[:3]:
        phase = f" at phase {cell.phase:.2f}" if not math.isnan(cell.phase) else ""
        place = f" {cell.joint}" if cell.joint else ""
        lines.append(
            f"  {cell.channel}{place}{phase}: off by {cell.mean:+.2g} times its noise (p {cell.p:.3f})"
        )
    if stage_note(d):
        lines.append(f"  {stage_note(d)}")
    return lines


def _causes(d: Diagnosis) -> list[str]:
    if not d.causes:
        return ["which: no effect of the catalogue reduces it"]
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
        lines.append(f"  indistinguishable from {place_words(*rival.of)}: {place} ({rival.why})")
    lines.append(f"  none of the catalogue: probability {d.none:.2f}")
    return lines


def _share(one: NamedCause) -> str:
    if math.isnan(one.shrink):
        return ""
    alone, last = percent_words(one.alone), percent_words(one.last)
    return f", explains {percent_words(one.shrink)} (alone {alone}, added last {last})"


def _how_far(d: Diagnosis) -> list[str]:
    far = d.far
    if math.isnan(far.shrink):
        return [f"how far: on {d.held_out} the gap is too small to measure how much is explained"]
    low, high = percent_words(far.low), percent_words(far.high)
    lines = [
        f"how far: {percent_words(far.shrink)} [{low}, {high}] of the gap, as energy above the baseline, "
        f"is explained on {d.held_out}; RMS {far.before:.3g} -> {far.after:.3g} of its baseline",
        f"  {d.interval_words}",
    ]
    lines += changed_channels(far, MOST_CHANNELS)
    if d.remaining.stage:
        lines.append(f"  the residual is in the stage {d.remaining.stage}")
    return lines


def _sizes(d: Diagnosis) -> list[str]:
    if not d.detectable:
        return []
    rows = [(s.effect, s.parameter, size_words(s)) for s in d.detectable[:MOST_SIZES]]
    lines = ["smallest sizes that would have been detected:"]
    lines += table_lines((Column(""),) * 3, rows, "  ")
    if len(d.detectable) > MOST_SIZES:
        lines.append(f"  and {len(d.detectable) - MOST_SIZES} more, in --html and --json")
    return lines


def _next(d: Diagnosis) -> list[str]:
    if not d.next:
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
