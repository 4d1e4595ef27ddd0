"""A comparison of ways of dead reckoning as lines for a person and as JSON for a program."""

import math
import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from model.values.arrays import FloatArray
from robot.console.table import Column, number_text, table_lines
from robot.odometry.compare import Comparison
from robot.odometry.metrics import LENGTHS_M, TrackErrors, in_band, path_length

MOST_REASONS = 5
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?")
NOTES = (
    ("RPE", "relative pose error: how far off the end of a piece of path of that length is, seen from "
     "its beginning, over the length; the mean over all such pieces"),
    ("end, yaw", "how far off the end of the walk is, over the length of the path"),
    ("NEES", "squared error in units of the estimator's own covariance; the mean should be 3, more: "
     "it believes itself too much"),
    ("NIS", "the same of the measured forces against what the estimator expected; the mean should be 1"),
    ("mu, K", "friction coefficient and vertical stiffness of a leg, as the estimator found them"),
)  # fmt: skip
# Columns: name, unit, form of its numbers.
FORCES = (("Fx", "N", ".2f"), ("Fy", "N", ".2f"), ("Fz", "N", ".2f"))
WAYS = (
    *((f"RPE {d:g} m", "%", ".2f") for d in LENGTHS_M),
    ("end", "%", ".2f"), ("yaw", "deg/m", ".3f"),
    ("vx", "mm/s", ".2f"), ("vy", "mm/s", ".2f"), ("yaw rate", "mrad/s", ".2f"), *FORCES,
)  # fmt: skip
PLACES = 1 + len(LENGTHS_M) + 2  # columns of a way before its rates
LEG = ("leg", "", "")
LEGS = (
    ("mu", "", ".3f"), ("sd", "", ".3f"), ("K", "N/m", ".0f"), ("sd", "N/m", ".0f"), *FORCES,
)  # fmt: skip
SHORT_NOTE = "RPE: relative pose error, K: stiffness, F: RMSE of force; see docs/odometry.md"


def table(
    found: Comparison, names: tuple[str, ...], *, everything: bool, width: int | None = None
) -> list[str]:
    """Lines of text; ``everything`` adds the other ways and the forces leg by leg.

    Args:
        found: What was found.
        names: Legs.
        everything: Whether the other ways are shown beside the estimator.
        width: Letters of a line of the terminal; a wider table is set as two. None: as wide as it is.
    """
    run = found.track
    last = run.estimates[-1]
    way = run.pose[-1] - run.pose[0]
    lines = [
        f"walking part: {walking_words(found)}",
        f"way: {number_text(1e3 * way[0], 1)} mm ahead, "
        f"{number_text(1e3 * way[1], 1)} mm aside, {number_text(math.degrees(way[2]), 2)} deg",
        "standard deviation at the end: "
        f"{1e3 * math.sqrt(last.pose_covariance[0, 0]):.1f} mm, "
        f"{1e3 * math.sqrt(last.pose_covariance[1, 1]):.1f} mm, "
        f"{math.degrees(math.sqrt(last.pose_covariance[2, 2])):.2f} deg",
        f"step {np.median(run.step_us):.0f} us, 99 % below {np.percentile(run.step_us, 99):.0f} us",
        *(f"{'  ' * (label != 'health')}{label}: {words}" for label, words in health_rows(found)),
    ]
    if found.errors:
        lines += _error_lines(found.errors if everything else found.errors[:1], width)
        lines += [f"{label}: {words}" for label, words in consistency_rows(found)]
        lines += [f"RPE: {words}" for words in short_walk(found)]
    elif everything:
        lines.append("no truth in this log: the ways are drawn beside each other (--out FILE.png)")
    columns = [Column(name, form, 4) for name, _, form in (LEG, *leg_columns(found))]
    units = ("", *(unit for _, unit, _ in leg_columns(found)))
    lines += table_lines(columns, [units, *leg_rows(found, names)])
    return [*lines, SHORT_NOTE]


def walking_words(found: Comparison) -> str:
    """Which part of the log was judged."""
    t_s = found.track.t_s
    return f"{len(t_s)} of {found.log_ticks} ticks, {t_s[-1] - t_s[0]:.1f} s"


def health_rows(found: Comparison) -> list[tuple[str, str]]:
    """How often the estimator was well, and why it was not: label and words.

    Reasons that differ in their numbers only are one row, with the numbers that were most frequent.
    """
    total = len(found.track.estimates)
    spoken = Counter((e.health.value, e.reason) for e in found.track.estimates)
    fine = sum(count for (health, _), count in spoken.items() if health == "ok")
    alike: dict[tuple[str, str], list[tuple[int, str]]] = {}
    for (health, reason), count in spoken.items():
        if health != "ok":
            alike.setdefault((health, NUMBER.sub("#", reason)), []).append((count, reason))
    counted = [
        (sum(count for count, _ in said), health, max(said)[1], len(said))
        for (health, _), said in alike.items()
    ]
    rows = [("health", f"ok {100 * fine / total:.1f} % of ticks")]
    for count, health, reason, kinds in sorted(counted, reverse=True)[:MOST_REASONS]:
        others = " (most often; other numbers, too)" if kinds > 1 else ""
        rows.append((health, f"{reason}{others}, {count} {'tick' if count == 1 else 'ticks'}"))
    return rows


def short_walk(found: Comparison) -> list[str]:
    """Why there is no relative error over a length, if the walk is too short for all of them."""
    if np.isfinite([e.rpe_percent for e in found.errors]).any() or found.truth is None:
        return []
    length_m = path_length(found.truth[0])[-1]
    return [f"none: the walk is {length_m:.2f} m long, the shortest piece is {LENGTHS_M[0]:g} m"]


def _error_lines(errors: tuple[TrackErrors, ...], width: int | None) -> list[str]:
    """The errors of each way: one table, or two below each other where one is too wide."""
    columns = [Column(""), *(Column(name, form, 5) for name, _, form in WAYS)]
    rows = [("", *(unit for _, unit, _ in WAYS)), *map(way_row, errors)]
    lines = table_lines(columns, rows)
    if width is None or len(lines[0]) <= width:
        return lines
    return [
        line
        for part in (slice(1, PLACES), slice(PLACES, None))
        for line in table_lines(
            [columns[0], *columns[part]], [(row[0], *row[part]) for row in rows]
        )
    ]


def way_row(errors: TrackErrors) -> tuple[str | float, ...]:
    """The name of a way and its errors, in the order of ``WAYS``."""
    return (
        errors.name,
        *errors.rpe_percent,
        errors.end_percent,
        errors.yaw_deg_m,
        *(1e3 * errors.velocity_rmse),
        *force_rms(errors),
    )


def leg_columns(found: Comparison) -> tuple[tuple[str, str, str], ...]:
    """What is said of each leg; forces only where their errors are known."""
    return LEGS if found.errors else LEGS[: -len(FORCES)]


def leg_rows(found: Comparison, names: Sequence[str]) -> list[tuple[str | float, ...]]:
    """Name of each leg with its figures at the end, in the order of ``leg_columns``."""
    last = found.track.estimates[-1]
    rows = []
    for k, name in enumerate(names):
        stiffness = last.stiffness[k]
        forces = found.errors[0].force_rmse[k] if found.errors else ()
        rows.append(
            (name, last.mu[k], last.mu_sd[k], stiffness, stiffness * last.stiffness_sd[k], *forces)
        )
    return rows


def force_rms(errors: TrackErrors) -> FloatArray:
    """RMSE of the predicted force over all feet: x, y, z, (3,) [N]."""
    found: FloatArray = np.sqrt((errors.force_rmse**2).mean(axis=0))
    return found


def consistency_rows(found: Comparison) -> list[tuple[str, str]]:
    """Whether the estimator's covariances are as large as its errors: label and words."""
    run = found.track
    nis = run.nis[run.nis_dof > 0] / run.nis_dof[run.nis_dof > 0]
    rows = [
        ("NEES (3 is ideal)", f"velocity {np.mean(found.twist_nees):.2f}, "
         f"{100 * in_band(found.twist_nees, 3):.0f} % in the 95 % band; "
         f"pose {np.mean(found.pose_nees):.2f}, {100 * in_band(found.pose_nees, 3):.0f} %")
    ]  # fmt: skip
    if len(nis):
        words = f"{np.mean(nis):.2f}; {run.estimates[-1].rejects} measurements rejected"
        rows.append(("NIS over its numbers (1 is ideal)", words))
    return rows


def as_json(found: Comparison, names: tuple[str, ...]) -> dict[str, object]:
    """The same for a program; what is not known is null."""
    run = found.track
    last = run.estimates[-1]
    counted = run.nis_dof > 0
    return {
        "ticks": len(run.t_s),
        "pose": run.pose[-1],
        "pose_covariance": last.pose_covariance,
        "health": last.health.value,
        "reason": last.reason,
        "step_us": {
            "median": float(np.median(run.step_us)),
            "p99": float(np.percentile(run.step_us, 99)),
        },
        "legs": list(names),
        "mu": last.mu,
        "mu_sd": last.mu_sd,
        "stiffness_n_m": last.stiffness,
        "ways": [
            {
                "name": e.name,
                "rpe_lengths_m": list(LENGTHS_M),
                "rpe_percent": e.rpe_percent,
                "end_percent": e.end_percent,
                "yaw_deg_m": e.yaw_deg_m,
                "velocity_rmse": e.velocity_rmse,
                "force_rmse_n": e.force_rmse,
            }
            for e in found.errors
        ],
        "nees_velocity": found.twist_nees.mean(),
        "nees_pose": found.pose_nees.mean(),
        "nis_over_dof": np.mean(run.nis[counted] / run.nis_dof[counted])
        if counted.any()
        else np.nan,
        "rejects": last.rejects,
    }
