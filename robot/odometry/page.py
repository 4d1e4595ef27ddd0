"""Odometry from a log as a page: the figures as tables, the pictures below."""

import math
from collections.abc import Sequence
from pathlib import Path

from robot.console.number_text import number_text
from robot.odometry.compare import Comparison
from robot.odometry.figure import drawing
from robot.odometry.metrics import LENGTHS_M
from robot.odometry.table import (
    NOTES,
    consistency_rows,
    force_rms,
    health_rows,
    short_walk,
    walking_words,
    way_and_sd,
)
from robot.report.page import grid_table, heading, page_frame, pictures, rows_table, section

WAYS = ("way", *(f"RPE {d:g} m, %" for d in LENGTHS_M), "end, %", "yaw, deg/m",
        "vx, mm/s", "vy, mm/s", "yaw rate, mrad/s", "Fx, N", "Fy, N", "Fz, N")  # fmt: skip
LEGS = ("leg", "mu", "sd", "K, N/m", "sd", "Fx, N", "Fy, N", "Fz, N")


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
    title = f"{log.name}: odometry"
    return page_frame(
        title,
        [
            heading(title, f"{log}, {date}; {judged}; the walking part only"),
            rows_table(rows),
            section("Errors of each way", _ways(found, everything=everything)),
            section("Each leg, as estimated at the end; RMSE of its force", _legs(found, names)),
            section("What the words mean", rows_table(NOTES)),
            *pictures(
                {"Path, error, velocity, friction": drawing(found, names, everything=everything)}
            ),
        ],
    )


def _ways(found: Comparison, *, everything: bool) -> str:
    errors = found.errors if everything else found.errors[:1]
    rows = [
        (
            one.name,
            *(number_text(value, 2) for value in one.rpe_percent),
            number_text(one.end_percent, 2),
            number_text(one.yaw_deg_m, 3),
            *(number_text(1e3 * value, 2) for value in one.velocity_rmse),
            *(number_text(value, 2) for value in force_rms(one)),
        )
        for one in errors
    ]
    return grid_table(WAYS, rows, numbers=range(1, len(WAYS)))


def _legs(found: Comparison, names: Sequence[str]) -> str:
    last = found.track.estimates[-1]
    rows = []
    for k, name in enumerate(names):
        stiff, of_it = last.stiffness[k], last.stiffness_sd[k]
        row = [name, number_text(last.mu[k], 3), number_text(last.mu_sd[k], 3)]
        row += [number_text(stiff, 0), number_text(stiff * of_it, 0)]
        if found.errors:
            row += [number_text(value, 2) for value in found.errors[0].force_rmse[k]]
        rows.append(row)
    head = LEGS if found.errors else LEGS[:5]
    return grid_table(head, rows, numbers=range(1, len(head)))
