"""Odometry from a log as a page: the figures as tables, the pictures below."""

import math
from collections.abc import Sequence
from pathlib import Path

from robot.console.table import formed, number_text
from robot.odometry.compare import Comparison
from robot.odometry.figure import drawing
from robot.odometry.table import (
    LEG,
    NOTES,
    WAYS,
    consistency_rows,
    health_rows,
    leg_columns,
    leg_rows,
    short_walk,
    walking_words,
    way_row,
)
from robot.report.page import Section, report_page
from robot.report.pictures import pictures

LEGS_TITLE = "Each leg, as estimated at the end; RMSE of its force"


def odometry_page(
    found: Comparison, names: Sequence[str], log: Path, date: str, *, everything: bool
) -> str:  # fmt: skip
    """Return the page.

    Args:
        found: What was found.
        names: Legs.
        log: The log, to name it.
        date: When it was recorded, in words.
        everything: Whether the other ways are shown beside the estimator.
    """
    run = found.track
    way, last = run.pose[-1] - run.pose[0], run.estimates[-1]
    sd = [math.sqrt(last.pose_covariance[k, k]) for k in range(3)]
    rows = [
        ("walking part", walking_words(found)),
        ("ahead", f"{number_text(1e3 * way[0], 1)} mm +- {1e3 * sd[0]:.1f}"),
        ("aside", f"{number_text(1e3 * way[1], 1)} mm +- {1e3 * sd[1]:.1f}"),
        ("turned", f"{number_text(math.degrees(way[2]), 2)} deg +- {math.degrees(sd[2]):.2f}"),
        *health_rows(found),
        *(consistency_rows(found) if found.errors else []),
        *(("RPE", words) for words in short_walk(found)),
    ]
    judged = "judged against the truth in the log" if found.truth else "no truth in this log"
    errors = found.errors if everything else found.errors[:1]
    figure = drawing(found, names, everything=everything)
    return report_page(
        f"{log.name}: odometry",
        f"{log}, {date}; {judged}; the walking part only",
        [
            Section("", rows),
            _table("Errors of each way", (("way", "", ""), *WAYS), list(map(way_row, errors))),
            _table(LEGS_TITLE, (LEG, *leg_columns(found)), leg_rows(found, names)),
            Section("What the words mean", NOTES),
            *pictures({"Path, error, velocity, friction": figure}),
        ],
    )


def _table(
    title: str, columns: Sequence[tuple[str, str, str]], rows: Sequence[Sequence[str | float]]
) -> Section:
    head = [f"{name}, {unit}" if unit else name for name, unit, _ in columns]
    texts = [
        [formed(value, form) for value, (_, _, form) in zip(row, columns, strict=True)]
        for row in rows
    ]
    return Section(title, texts, head, range(1, len(head)))
