"""Odometry from a log as a page: the figures as tables, the pictures below."""

import math
from collections.abc import Sequence
from pathlib import Path

from robot.console.table import number_text
from robot.odometry.compare import Comparison
from robot.odometry.figure import drawing
from robot.odometry.table import (
    NOTES,
    Column,
    consistency_rows,
    error_columns,
    health_rows,
    leg_columns,
    short_walk,
    walking_words,
    way_and_sd,
)
from robot.report.page import Section, report_page
from robot.report.pictures import pictures


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
    way, sd = way_and_sd(found)
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
    ways = [one.name for one in errors]
    title = "Each leg, as estimated at the end; RMSE of its force"
    return report_page(
        f"{log.name}: odometry",
        f"{log}, {date}; {judged}; the walking part only",
        [
            Section("", rows),
            _grid("Errors of each way", "way", ways, error_columns(errors)),
            _grid(title, "leg", names, leg_columns(found)),
            Section("What the words mean", NOTES),
            *pictures(
                {"Path, error, velocity, friction": drawing(found, names, everything=everything)}
            ),
        ],
    )


def _grid(title: str, label: str, names: Sequence[str], columns: Sequence[Column]) -> Section:
    heads = [f"{c.name}, {c.unit}" if c.unit else c.name for c in columns]
    rows = list(zip(names, *(c.texts for c in columns), strict=True))
    return Section(title, rows, (label, *heads), range(1, len(heads) + 1))
