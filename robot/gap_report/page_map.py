"""Where a gap lies, as coloured cells of tables: readable on a phone, in the dark and on paper."""

import html
import math
from collections.abc import Sequence

from gap.diagnosis.findings import Diagnosis
from gap.diagnosis.where import PHASE_BINS, ChannelGap
from gap.rounding import percent_words
from robot.report.page_table import table

MAP_STYLE = """
.map { border-collapse: separate; border-spacing: 2px; width: auto; min-width: 60%; }
.map th { width: auto; font-weight: 500; padding: 0.1rem 0.35rem; border: 0; white-space: nowrap; }
.map td { text-align: center; border: 0; border-radius: 4px; min-width: 1.9rem; padding: 0.15rem 0.2rem;
          font-size: 0.82rem; background: rgba(213, 94, 0, var(--heat)); print-color-adjust: exact;
          -webkit-print-color-adjust: exact; }
.map td.hot { color: #000; } .map td.none { color: var(--faint); background: none; }
.chain { display: grid; grid-template-columns: minmax(6.5rem, auto) 1fr auto; gap: 0.2rem 0.6rem;
         align-items: center; }
.chain .bar { background: var(--line); border-radius: 4px; height: 0.9rem; overflow: hidden; }
.chain .bar i { display: block; height: 100%; background: #D55E00; print-color-adjust: exact;
                -webkit-print-color-adjust: exact; }
@media (max-width: 40rem) { .map { min-width: 0; }
  .map td { min-width: 1.35rem; font-size: 0.72rem; padding: 0.1rem; }
  .map th { font-size: 0.72rem; padding: 0.1rem 0.15rem; } }
.chain .top { font-weight: 700; } .chain span:nth-child(3n) { color: var(--faint); font-size: 0.85rem; }
"""
COLD, HOT = 1.0, 30.0  # energy over expectation: no gap; full colour
# The letters of a cell are the page's, but black from here: on full colour black has the better contrast on
# a dark page too, and on a white page it always has.
BLACK_FROM = 0.82
BODY = "body"
UNSEEN = "no channel of its own: it shows in the others"


def stage_bars(d: Diagnosis) -> str:
    """Return each stage's share of the gap as a bar, with its energy in words."""
    after = {one.stage: one.own for one in d.remaining.stages}
    top = max((one.share for one in d.where.stages), default=0.0)
    rows = []
    for one in d.where.stages:
        if math.isnan(one.own):
            rows.append(_row(one.stage, 0.0, UNSEEN, top=False))
            continue
        words = f"{percent_words(one.share)} of the gap; {one.own:.3g} times expected"
        if math.isfinite(after.get(one.stage, math.nan)) and d.causes:
            words += f", {after[one.stage]:.3g} with the causes"
        rows.append(_row(one.stage, one.share, words, top=0 < top == one.share))
    return f"<div class='chain'>{''.join(rows)}</div>"


def stage_words(d: Diagnosis) -> str:
    """Return each stage's energy in words, where there is no gap to have shares of."""
    rows = [
        (one.stage, UNSEEN if math.isnan(one.own) else f"{one.own:.3g} times expected")
        for one in d.where.stages
    ]
    return table(("stage", "difference, its energy"), rows)


def _row(stage: str, share: float, words: str, *, top: bool) -> str:
    mark = " class='top'" if top else ""
    return (
        f"<span{mark}>{html.escape(stage)}</span><span class='bar'>"
        f"<i style='width:{100 * share:.0f}%'></i></span><span>{html.escape(words)}</span>"
    )


def leg_phase_map(d: Diagnosis) -> tuple[str, bool]:
    """Return legs against the phase of the gait: the worst channel of each leg in each part of it.

    Where there are no cycles, the parts are thirds of the runs; the second value tells which.
    """
    known = [one for one in d.where.channels if math.isfinite(one.excess)]
    if not known:
        return "", False
    cyclic = any(math.isfinite(one.bands[0]) for one in known)
    head = [f"{i / PHASE_BINS:.2g}" for i in range(PHASE_BINS)] if cyclic else ["1st", "2nd", "3rd"]
    rows = []
    for place in _places(known):
        own = [one for one in known if (one.joint or BODY) == place]
        parts = [one.phases if cyclic else one.thirds for one in own]
        values = [max((p[i] for p in parts if math.isfinite(p[i])), default=math.nan)
                  for i in range(len(head))]  # fmt: skip
        rows.append((place, values))
    corner = "phase from" if cyclic else "third of the run"
    return _map(corner, head, rows), cyclic


def stage_leg_map(d: Diagnosis) -> str:
    """Return stages against legs: the worst channel of each."""
    known = [one for one in d.where.channels if math.isfinite(one.excess)]
    places = _places(known)
    if len(places) < 2:
        return ""
    rows = []
    for stage in dict.fromkeys(one.stage for one in known):
        values = [
            max(
                (c.excess for c in known if c.stage == stage and (c.joint or BODY) == place),
                default=math.nan,
            )
            for place in places
        ]
        rows.append((stage, values))
    return _map("", places, rows)


def _places(channels: Sequence[ChannelGap]) -> list[str]:
    found = list(dict.fromkeys(one.joint or BODY for one in channels))
    return sorted(found, key=lambda place: place == BODY)  # the body last, legs in their order


def _map(corner: str, head: Sequence[str], rows: Sequence[tuple[str, Sequence[float]]]) -> str:
    top = "".join(f"<th scope='col'>{html.escape(one)}</th>" for one in head)
    body = "".join(
        f"<tr><th scope='row'>{html.escape(name)}</th>{''.join(map(_cell, values))}</tr>"
        for name, values in rows
    )
    return (
        f"<div class='wide'><table class='map'><thead><tr><th>{html.escape(corner)}</th>{top}</tr></thead>"
        f"<tbody>{body}</tbody></table></div>"
    )


def _cell(value: float) -> str:
    if math.isnan(value):
        return "<td class='none'>-</td>"
    share = math.log(max(value, COLD) / COLD) / math.log(HOT / COLD)
    heat = min(1.0, share)
    words = f"{value:.2g}" if value < 99.5 else f"{value:.0f}"
    return f"<td{' class=hot' if heat > BLACK_FROM else ''} style='--heat:{heat:.2f}'>{words}</td>"
