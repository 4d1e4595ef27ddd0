"""Where a gap lies, as bars of the stages and coloured cells of tables: what the page's template draws."""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from gap.diagnosis.answer.findings import Diagnosis
from gap.diagnosis.comparison.where import ChannelGap
from gap.residuals.phase_bins import PHASE_BINS
from gap.rounding import percent_words

COLD, HOT = 1.0, 30.0  # energy over expectation: no gap; full colour
# The letters of a cell are the page's, but black from here: on full colour black has the better contrast on
# a dark page too, and on a white page it always has.
BLACK_FROM = 0.82
BODY, LEG = "body", "leg"
# What a machine's joints are called, by the simulator's name.
PLACES = {"servo_bench": "joint", "sliding_body": BODY}
UNSEEN = "no channel of its own: it shows in the others"
BASE = "before any cause is added; 1 is what is expected without a gap."


class Bar(NamedTuple):
    """A stage's share of the gap: percent of it, in words, and whether it is the largest."""

    stage: str
    percent: str
    words: str
    top: bool


class MapCell(NamedTuple):
    """Energy over expectation: in words (empty: not known), its colour from 0 to 1, whether that is hot."""

    words: str
    heat: str
    hot: bool


class GapMap(NamedTuple):
    """A table of coloured cells: what it shows, its corner and columns, and a name with cells a row."""

    about: str
    corner: str
    head: Sequence[str]
    rows: Sequence[tuple[str, Sequence[MapCell]]]


def stage_bars(d: Diagnosis) -> list[Bar]:
    """Return each stage's share of the gap as a bar, with its energy in words."""
    after = {one.stage: one.own for one in d.remaining.stages}
    top = max((one.share for one in d.where.stages), default=0.0)
    bars = []
    for one in d.where.stages:
        if math.isnan(one.own):
            bars.append(Bar(one.stage, "0", UNSEEN, top=False))
            continue
        words = f"{percent_words(one.share)} of the gap; {one.own:.3g} times expected"
        if math.isfinite(after.get(one.stage, math.nan)) and d.causes:
            words += f", {after[one.stage]:.3g} with the causes"
        bars.append(Bar(one.stage, f"{100 * one.share:.0f}", words, top=0 < top == one.share))
    return bars


def stage_rows(d: Diagnosis) -> list[tuple[str, str]]:
    """Return each stage's energy in words, where there is no gap to have shares of."""
    return [
        (one.stage, UNSEEN if math.isnan(one.own) else f"{one.own:.3g} times expected")
        for one in d.where.stages
    ]


def gap_maps(d: Diagnosis) -> list[GapMap]:
    """Return the worst channel of each stage and place, and of each place in each part of the runs."""
    known = [one for one in d.where.channels if math.isfinite(one.excess)]
    if not known:
        return []
    place = PLACES.get(d.simulator, LEG)
    names = list(dict.fromkeys(one.joint or BODY for one in known))
    names.sort(key=lambda name: name == BODY)  # the body last, legs in their order
    maps = [_by_phase(known, names, place)]
    if len(names) > 1:
        rows = []
        for stage in dict.fromkeys(one.stage for one in known):
            own = [c for c in known if c.stage == stage]
            rows.append(
                (stage, [_worst(c.excess for c in own if (c.joint or BODY) == n) for n in names])
            )
        about = f"Energy of the worst channel of each stage and {place}, {BASE}"
        maps.insert(0, GapMap(about, "", names, rows))
    return maps


def _by_phase(known: Sequence[ChannelGap], names: Sequence[str], place: str) -> GapMap:
    """Places against the phase of the gait; where there are no cycles, against thirds of the runs."""
    cyclic = any(math.isfinite(one.bands[0]) for one in known)
    head = [f"{i / PHASE_BINS:.2g}" for i in range(PHASE_BINS)] if cyclic else ["1st", "2nd", "3rd"]
    rows = []
    for name in names:
        own = [c.phases if cyclic else c.thirds for c in known if (c.joint or BODY) == name]
        rows.append((name, [_worst(parts[i] for parts in own) for i in range(len(head))]))
    part = "third of the run"
    if cyclic:
        part = f"part of the {'gait' if place == LEG else 'motion'}"
    of = "" if place == BODY else f" of each {place}"
    about = f"Energy of the worst channel{of} in each {part}, {BASE}"
    return GapMap(about, "phase from" if cyclic else "third of the run", head, rows)


def _worst(values: Iterable[float]) -> MapCell:
    """The cell of the largest of the values that are known."""
    value = max((value for value in values if math.isfinite(value)), default=math.nan)
    if math.isnan(value):
        return MapCell("", "0", hot=False)
    heat = min(1.0, math.log(max(value, COLD) / COLD) / math.log(HOT / COLD))
    words = f"{value:.2g}" if value < 99.5 else f"{value:.0f}"
    return MapCell(words, f"{heat:.2f}", heat > BLACK_FROM)
