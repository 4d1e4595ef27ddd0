"""The causes on a diagnosis' page: what was named, what could stand in its place, which run would tell."""

import html

from gap.diagnosis.findings import Diagnosis, NamedCause, Verdict
from gap.experiments.next_run import NextRun
from gap.interfaces import place_words
from gap.rounding import percent_words, value_words
from robot.gap_report.words import ENOUGH, common_pair, likely_rivals, pair_words, which_run
from robot.report.page_table import command, note, table, with_sign

MOST_RIVALS = 5
MOST_NEXT = 5


def causes_part(d: Diagnosis) -> str:
    """Return a card for each cause, and the likeliest rivals of each."""
    if d.verdict is Verdict.NO_GAP:
        return ""
    if not d.causes:
        return "<p>No effect of the catalogue reduces it.</p>"
    cards = "\n".join(_card(number, one) for number, one in enumerate(d.causes, 1))
    rows = [
        (place_words(*one.of), place_words(one.effect, one.joints), f"{one.probability:.2f}")
        for one in likely_rivals(d)[:MOST_RIVALS]
    ]
    return f"{cards}\n{table(('in place of', 'it could be', 'probability'), rows)}"


def _card(number: int, one: NamedCause) -> str:
    numbers = "".join(
        f"<div><b>{html.escape(with_sign(value_words(v.value, v.error, v.unit)))}</b>"
        f"<span>{html.escape(v.name + (' (on its bound)' if v.on_bound else ''))}</span></div>"
        for v in one.values
    )
    evidence = (
        f"Stage {one.stage}. Closes {percent_words(one.shrink)} of the gap (by itself "
        f"{percent_words(one.alone)}, on top of the others {percent_words(one.last)}; energy above the "
        f"floor); predicts unseen blocks better by {one.nats:.0f} ± {one.nats_error:.0f} nats."
    )
    return (
        f"<div class='card'><span class='sure'>{one.probability:.0%} sure</span>"
        f"<h3>{number}. {html.escape(place_words(one.effect, one.joints))}</h3>"
        f"<div class='facts'>{numbers}</div><p>{html.escape(one.physics)}</p>"
        f"<p><b>What to do:</b> {html.escape(one.remedy)}</p>"
        f"<p class='small'>{html.escape(evidence)}</p></div>"
    )


def alike_part(d: Diagnosis) -> str:
    """Return what the runs leave open."""
    rows = [
        (
            place_words(*one.of),
            place_words(one.effect, one.joints),
            f"{one.separation:.3g}",
            value_words(one.behind, one.error),
            one.why,
        )
        for one in d.ambiguous
    ]
    head = ("named", "could as well be", f"how far apart ({ENOUGH} tells)",
            "how far behind (nats)", "why it is open")  # fmt: skip
    return table(head, rows)


def next_part(d: Diagnosis) -> str:
    """Return the best runs that would tell."""
    shown = d.next[:MOST_NEXT]
    if not shown:
        run = which_run(d, "<code>bigant gap next</code>")
        return f"<p>Which run would tell them apart: {run}.</p>" if d.ambiguous else ""
    pair = common_pair(shown)
    lead = f"Each tells {pair}. " if pair else ""
    lead += f"How far apart it shows them is for one run; {ENOUGH} is enough. The best is first."
    with_limits = any(one.limits for one in shown)
    head = ["run", *([] if pair else ["tells"]), "how far apart", "runs", "minutes",
            *(["beware"] if with_limits else [])]  # fmt: skip
    rows = [_next_row(one, pair=pair, limits=with_limits) for one in shown]
    more = len(d.next) - len(shown)
    return note(lead) + table(head, rows) + note(f"{more} more in --json." if more else "")


def _next_row(one: NextRun, *, pair: str, limits: bool) -> list[str]:
    return [
        command(one.name, one.command),
        *([] if pair else [pair_words(one)]),
        f"{one.separation:.3g}",
        str(one.runs),
        f"{one.minutes:.1f}",
        *([one.limits or "-"] if limits else []),
    ]
