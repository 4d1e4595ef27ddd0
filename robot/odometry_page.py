"""Odometry from a log as a page: the figures as tables, the pictures below."""

import math
from collections.abc import Sequence
from pathlib import Path

from robot.odometry_compare import Comparison
from robot.odometry_figure import drawing
from robot.odometry_metrics import LENGTHS_M
from robot.odometry_table import table
from robot.report_page import grid_table, heading, page_frame, pictures, rows_table, section

WAYS = ("way", *(f"RPE {d:g} m, %" for d in LENGTHS_M), "end, %", "yaw, deg/m",
        "vx, mm/s", "vy, mm/s", "yaw rate, mrad/s")  # fmt: skip
LEGS = ("leg", "mu", "sd", "K, N/m", "sd", "Fx, N", "Fy, N", "Fz, N")


def odometry_page(
    found: Comparison, names: Sequence[str], log: Path, *, everything: bool
) -> str:  # fmt: skip
    """Return the page.

    Args:
        found: What was found.
        names: Legs.
        log: The log, to name it.
        everything: Whether the other ways are shown beside the estimator.
    """
    run = found.track
    way, last = run.pose[-1] - run.pose[0], run.estimates[-1]
    sd = [math.sqrt(last.pose_covariance[k, k]) for k in range(3)]
    rows = [
        ("walked", f"{run.t_s[-1] - run.t_s[0]:.1f} s, {len(run.t_s)} ticks"),
        ("ahead", f"{1e3 * way[0]:.1f} mm +- {1e3 * sd[0]:.1f}"),
        ("aside", f"{1e3 * way[1]:.1f} mm +- {1e3 * sd[1]:.1f}"),
        ("turned", f"{math.degrees(way[2]):.2f} deg +- {math.degrees(sd[2]):.2f}"),
        *_health(found, names),
    ]
    note = "judged against the truth in the log" if found.truth else "no truth in this log"
    return page_frame(
        f"{log.name}: odometry",
        [
            heading(f"{log.name}: odometry", note),
            rows_table(rows),
            section("Errors of each way", _ways(found, everything=everything)),
            section("Each leg, as estimated at the end; its force's error", _legs(found, names)),
            *pictures({"Path, error, velocity, friction": drawing(found, everything=everything)}),
        ],
    )


def _health(found: Comparison, names: Sequence[str]) -> list[tuple[str, str]]:
    """What the text table says of health and consistency, label and words."""
    lines = table(found, tuple(names), everything=False)
    told = [one for one in lines if one.startswith(("health:", "NEES", "NIS"))]
    return [(label, words.strip()) for label, _, words in (one.partition(":") for one in told)]


def _ways(found: Comparison, *, everything: bool) -> str:
    errors = found.errors if everything else found.errors[:1]
    rows = [
        (
            one.name,
            *(_number(value, 2) for value in one.rpe_percent),
            _number(one.end_percent, 2),
            _number(one.yaw_deg_m, 3),
            *(_number(1e3 * value, 2) for value in one.velocity_rmse),
        )
        for one in errors
    ]
    return grid_table(WAYS, rows, numbers=range(1, len(WAYS)))


def _legs(found: Comparison, names: Sequence[str]) -> str:
    last = found.track.estimates[-1]
    rows = []
    for k, name in enumerate(names):
        stiff, of_it = last.stiffness[k], last.stiffness_sd[k]
        row = [name, _number(last.mu[k], 3), _number(last.mu_sd[k], 3)]
        row += [_number(stiff, 0), _number(stiff * of_it, 0)]
        if found.errors:
            row += [_number(value, 2) for value in found.errors[0].force_rmse[k]]
        rows.append(row)
    head = LEGS if found.errors else LEGS[:5]
    return grid_table(head, rows, numbers=range(1, len(head)))


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else "-"
