"""The report of a day as one page: the sentence, the figures over runs, a row a run with its page."""

import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from robot.console.table import number_text
from robot.day.gap import DayGap
from robot.day.runs import DayRun
from robot.day.text import day_sentence
from robot.report.page import PageLink, Section, report_page
from robot.report.pictures import page_picture
from robot.report.plots import FAULT, STYLE, TRUE

HEAD = (
    "",
    "run",
    "began",
    "gait",
    "walked s",
    "distance m",
    "slip mm/s",
    "odometry end",
    "health",
    "hottest C",
    "ended",
)
NO_BREAK = "\xa0"
NUMBERS = (0, 4, 5, 6, 7, 9)


def day_page(
    title: str, runs: Sequence[DayRun], gap: DayGap, out: Path, pages: Mapping[Path, Path]
) -> str:
    """Return the page of a day.

    Args:
        title: Heading.
        runs: In order of time.
        gap: Of the day against earlier runs.
        out: Where the page will be: links are relative to it.
        pages: The page of a log, and of the diagnosis under the path of ``out``, where there is one.
    """
    read = [one for one in runs if one.summary is not None]
    troubled = [(one.path.name, one.fault_words) for one in runs if one.fault_words]
    bad = len(read) < len(runs) or any(one.stopped_by_fault for one in runs)
    lead = page_picture(_figure(read), "Figures of each run", "day") if read else None
    sections = [
        Section(
            "Runs",
            [_row(number, one, out, pages) for number, one in enumerate(read, start=1)],
            HEAD,
            NUMBERS,
        ),
        Section("Faults and files that could not be read", troubled, ("run", "what happened")),
        Section("Gap against earlier runs", _gap_rows(gap, out, pages)),
    ]
    return report_page(
        title,
        f"{len(runs)} log{'s' * (len(runs) != 1)}; figures of odometry need ground truth",
        sections,
        lead=lead,
        verdict=day_sentence(runs),
        kind="warn" if bad else "pass",
    )


def _row(
    number: int, one: DayRun, out: Path, pages: Mapping[Path, Path]
) -> tuple[str | PageLink, ...]:
    s = one.summary
    assert s is not None
    page = pages.get(one.path)
    name = (
        PageLink(one.path.stem, link=_link(page, out))
        if page
        else PageLink(one.path.stem, command=f"bigant show {one.path}")
    )
    slip, health = (
        one.slip_words.replace(" ", NO_BREAK),
        one.health_words.replace(" %", f"{NO_BREAK}%"),
    )
    error = "-" if math.isnan(one.end_error) else f"{number_text(one.end_error, 1)} %"
    return (
        str(number), name, one.begun, s.gait, number_text(s.walking_s, 1), number_text(s.distance_m, 3),
        slip, error, health, number_text(s.hottest_c, 0), one.end_words,
    )  # fmt: skip


def _gap_rows(
    gap: DayGap, out: Path, pages: Mapping[Path, Path]
) -> list[tuple[str | PageLink, ...]]:
    rows: list[tuple[str | PageLink, ...]] = [(gap.verdict.capitalize() or "Answer", gap.words)]
    if gap.diagnosis is not None:
        rows.append(("compared", f"{len(gap.trials)} runs with {len(gap.references)} earlier ones"))
    rows += [("not compared", f"{path.name}: {reason}") for path, reason in gap.left_out]
    if out in pages:
        rows.append(("page", PageLink("the diagnosis", link=_link(pages[out], out))))
    return rows


def _link(page: Path, out: Path) -> str:
    return Path(os.path.relpath(page, out.parent)).as_posix()


def _figure(runs: Sequence[DayRun]) -> Figure:
    """Distance, slip, odometry and temperature of each run, by its number."""
    numbers = list(range(1, len(runs) + 1))
    summaries = [s for one in runs if (s := one.summary) is not None]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 5.0), layout="constrained")
        (distance, slip), (odometry, heat) = figure.subplots(2, 2)
        dots = {"marker": "o", "ls": "-", "lw": 1.0}
        distance.plot(numbers, [s.distance_m for s in summaries], color=TRUE, **dots)
        distance.set(ylabel="distance [m]")
        for at, label, colour in ((0, "5 %", TRUE), (-1, "95 %", FAULT)):
            values = [s.slip_percentiles_m_s[at] * 1e3 for s in summaries]
            slip.plot(numbers, values, color=colour, label=label, **dots)
        slip.legend(loc="best")
        slip.set(ylabel="slip of feet [mm/s]")
        odometry.plot(numbers, [one.end_error for one in runs], color=TRUE, **dots)
        odometry.set(ylabel="odometry error [%]")
        heat.plot(numbers, [s.hottest_c for s in summaries], color=TRUE, **dots)
        heat.set(ylabel="hottest servo [C]")
        for ax in (distance, slip, odometry, heat):
            ax.set(xlabel="run", xlim=(0.5, len(runs) + 0.5))
            ax.set_xticks(
                numbers if len(numbers) <= 12 else numbers[:: math.ceil(len(numbers) / 12)]
            )
    return figure
