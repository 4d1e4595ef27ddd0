"""A diagnosis as lines for a terminal: the answer first, then what it rests on."""

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path

from gap.ambiguity import why_open
from gap.findings import Diagnosis, NamedCause, Verdict
from gap.interfaces import place_words
from gap.verdict import cause_words
from robot.gap_faults import fault_groups

WIDTH = 100
BAR = 20
MOST_CHANNELS = 6
MOST_SIZES = 12
LEAST_CHANGE = 1e-3  # of the floor
APPLIED = frozenset({"legged", "mujoco"})
WHERE_HEAD = f"  {'stage':<14}{'of gap':>6}  {'':<{BAR}}{'by itself':>9}{'end to end':>14}"


def summary_lines(d: Diagnosis, paths: Sequence[Path]) -> list[str]:
    """Return the lines.

    Args:
        d: The diagnosis.
        paths: Files of the trials and the references, in their order.
    """
    lines = [f"{d.verdict.value.upper().replace('_', ' ')}"]
    lines += textwrap.wrap(d.sentence, WIDTH)
    lines += [*_to_do(d), "", *_faults(d, paths)]
    if d.verdict is not Verdict.NO_GAP:
        lines += [*_where(d), "", *_causes(d), "", *_how_far(d)]
    else:
        lines += _sizes(d)
    lines += _next(d)
    if d.warnings:
        lines += ["", *(f"note: {words}" for words in d.warnings)]
    if d.standing:
        lacks = ", ".join(place_words(one.effect, one.joints) for one in d.standing)
        lines.append(f"what healthy runs show already, and is no news: {lacks}")
    held = ", ".join(paths[i].name for i in d.held_out_trials[:MOST_CHANNELS])
    if len(d.held_out_trials) > MOST_CHANNELS:
        held += f" and {len(d.held_out_trials) - MOST_CHANNELS} more"
    lines.append(f"kept back to judge: {held}; floor from {d.floor_source}")
    return [line for i, line in enumerate(lines) if line or (i and lines[i - 1])]


def _to_do(d: Diagnosis) -> list[str]:
    """What a person does now, before any figures."""
    if d.verdict is Verdict.NO_GAP:
        return []
    words = [(place_words(one.effect, one.joints), one.remedy) for one in d.causes]
    lines = []
    for place, remedy in words:
        lead = "what to do: " if len(words) == 1 else f"what to do about {place}: "
        lines += textwrap.wrap(lead + remedy, WIDTH, subsequent_indent="  ")
    if d.verdict is Verdict.AMBIGUOUS:
        lines.append("which run would tell: bigant gap next")
    if d.simulator in APPLIED and d.causes and d.verdict is not Verdict.UNEXPLAINED:
        lines.append("into the simulator: bigant gap apply (of the --json of this diagnosis)")
    return lines


def _faults(d: Diagnosis, paths: Sequence[Path]) -> list[str]:
    found = [
        f"  {'severe ' if one.severe else ''}{one.kind} {one.channel} in {one.where}: {one.evidence}"
        for one in fault_groups(d.data_faults, paths)
    ]
    if len(found) > MOST_CHANNELS:
        found = [*found[:MOST_CHANNELS], f"  and {len(found) - MOST_CHANNELS} more, in --json"]
    return ["data faults:", *found, ""] if found else []


def _where(d: Diagnosis) -> list[str]:
    lines = ["where (energy over what is expected; 1 is no gap):", WHERE_HEAD]
    for one in d.where.stages:
        if not math.isnan(one.own):
            bar = "#" * round(BAR * one.share)
            lines.append(
                f"  {one.stage:<14}{one.share:>6.0%}  {bar:<{BAR}}{one.own:9.3g}{one.end_to_end:14.3g}"
            )
    for cell in d.where.cells[:3]:
        phase = f" at phase {cell.phase:.2f}" if not math.isnan(cell.phase) else ""
        place = f" {cell.joint}" if cell.joint else ""
        lines.append(
            f"  {cell.channel}{place}{phase}: off by {cell.mean:+.2g} of its noise (p {cell.p:.3f})"
        )
    return lines


def _causes(d: Diagnosis) -> list[str]:
    if not d.causes:
        return ["which: no effect of the catalogue reduces it"]
    lines = ["which:"]
    for number, one in enumerate(d.causes, 1):
        lines.append(f"  {number}. {cause_words(one)}")
        lines.append(f"     probability {one.probability:.2f}, stage {one.stage}{_share(one)}")
        lines += textwrap.wrap(
            one.physics, WIDTH, initial_indent="     ", subsequent_indent="     "
        )
    for one_alike, (effect, joints) in zip(d.ambiguous, d.ambiguous_of, strict=True):
        lines.append(
            f"  cannot be told from {place_words(effect, joints)}: "
            f"{place_words(one_alike.effect, one_alike.joints)} ({why_open(one_alike)})"
        )
    lines.append(f"  none of the catalogue: probability {d.none:.2f}")
    return lines


def _share(one: NamedCause) -> str:
    if math.isnan(one.shrink):
        return ""
    return f", closes {one.shrink:.0%} (alone {one.alone:.0%}, last in {one.last:.0%})"


def _how_far(d: Diagnosis) -> list[str]:
    far = d.far
    if math.isnan(far.shrink):
        return ["how far: on the runs kept back the gap is too small to measure what is closed"]
    lines = [
        f"how far: {far.shrink:.0%} [{far.low:.0%}, {far.high:.0%}] of the gap is closed on runs kept back;"
        f" RMS {far.before:.3g} -> {far.after:.3g} of its floor"
    ]
    changed = [c for c in far.channels if abs(c.before - c.after) > LEAST_CHANGE * c.floor]
    changed.sort(key=lambda c: -(c.before - c.after) / max(c.floor, 1e-12))
    for c in changed[:MOST_CHANNELS]:
        place = f" {c.joint}" if c.joint else ""
        lines.append(
            f"  {c.channel + place:<24} {c.before:9.3g} -> {c.after:9.3g} {c.unit:<6} floor {c.floor:.3g}"
        )
    if d.remaining.stage:
        lines.append(f"  what is left lies in the stage {d.remaining.stage}")
    return lines


def _sizes(d: Diagnosis) -> list[str]:
    shown = [one for one in d.detectable if math.isfinite(one.size)][:MOST_SIZES]
    if not shown:
        return []
    return [
        "smallest sizes that would have shown:",
        *(f"  {one.effect:<22} {one.parameter:<16} {one.size:9.3g} {one.unit}" for one in shown),
    ]


def _next(d: Diagnosis) -> list[str]:
    if not d.next:
        return []
    lines = ["", "what to run next:"]
    for one in d.next[:3]:
        limits = f"; {one.limits}" if one.limits else ""
        lines.append(
            f"  {one.name}: tells {one.pair[0]} from {one.pair[1]} in {one.runs} run(s), "
            f"{one.minutes:.1f} min{limits}"
        )
        if one.command:
            lines.append(f"    {one.command}")
    return lines
