"""A comparison of methods of dead reckoning as lines for a person and as JSON for a program."""

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import NamedTuple

import numpy as np

from model.values.arrays import FloatArray, known_mean
from model.values.estimate import Health
from robot.console.table import Column, number_text, table_lines
from robot.odometry.compare import OdometryComparison
from robot.odometry.metrics import LENGTHS_M, TrackErrors, in_band, path_length

NAME_LETTERS, LEG_LETTERS = 18, 6
PLACE_COLUMNS = len(LENGTHS_M) + 2
MOST_REASONS = 5
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?")
NOTES = (
    ("RPE", "relative pose error: how far off the end of a piece of path of that length is, seen from "
     "its beginning, over the length; the mean over all such pieces"),
    ("end, yaw", "how far off the end of the walk is, over the length of the path"),
    ("NEES", "squared error in units of the estimator's own covariance; the mean should be 3, more: "
     "it believes itself too much"),
    ("NIS", "the same of the measured forces against what the estimator expected; the mean should be 1"),
    ("mu, K", "friction coefficient and vertical stiffness of a leg, as estimated"),
)  # fmt: skip
SHORT_NOTE = "RPE: relative pose error, mu: friction, K: leg stiffness; see docs/odometry.md"


def table(comparison: OdometryComparison, width: int | None = None) -> list[str]:
    """Lines of text; a table wider than ``width`` letters is set as two. None: as wide as it is."""
    run = comparison.track
    (ahead_m, aside_m, yaw_rad), sd = displacement_and_sd(comparison)
    lines = [
        f"walking part: {walking_words(comparison)}",
        f"displacement: {number_text(1e3 * ahead_m, 1)} mm ahead, "
        f"{number_text(1e3 * aside_m, 1)} mm aside, {number_text(math.degrees(yaw_rad), 2)} deg",
        f"standard deviation at the end: {1e3 * sd[0]:.1f} mm, {1e3 * sd[1]:.1f} mm, "
        f"{math.degrees(sd[2]):.2f} deg",
        f"step {np.median(run.step_us):.0f} us, 99 % below {np.percentile(run.step_us, 99):.0f} us",
        *(
            f"{'  ' * (label != 'health')}{label}: {words}"
            for label, words in health_rows(comparison)
        ),
    ]
    if comparison.errors:
        columns, methods = error_columns(comparison.errors), [e.name for e in comparison.errors]
        head = Column("", width=NAME_LETTERS)
        whole = _figure_lines(head, methods, columns)
        if width is not None and max(map(len, whole)) > width:
            parts = (columns[:PLACE_COLUMNS], columns[PLACE_COLUMNS:])
            whole = [line for part in parts for line in _figure_lines(head, methods, part)]
        lines += whole
        lines += [f"{label}: {words}" for label, words in consistency_rows(comparison)]
        lines += [f"RPE: {words}" for words in short_walk(comparison)]
    elif len(comparison.motions) > 1:
        lines.append(
            "no truth in this log: the methods are drawn beside each other (--out FILE.png)"
        )
    lines += _figure_lines(
        Column("leg", width=LEG_LETTERS), comparison.names, leg_columns(comparison)
    )
    return [*lines, SHORT_NOTE]


class Figures(NamedTuple):
    """One figure of merit of each row of a table: its heading, unit, form, and values."""

    name: str
    unit: str
    form: str
    values: Sequence[float] | FloatArray
    width: int = 5


def _figure_lines(first: Column, names: Sequence[str], columns: Sequence[Figures]) -> list[str]:
    """Figures below their names and units, beside the names of their rows."""
    heads = [first, *(Column(one.name, one.form, one.width) for one in columns)]
    units = ("", *(one.unit for one in columns))
    return table_lines(heads, [units, *zip(names, *(one.values for one in columns), strict=True)])


def error_columns(errors: Sequence[TrackErrors]) -> list[Figures]:
    """The errors of each method, a method a row; the first ``PLACE_COLUMNS`` are of the place."""
    rpe = np.array([e.rpe_percent for e in errors]).T
    velocity = 1e3 * np.array([e.velocity_rmse for e in errors]).T
    # over all feet
    force = np.array([np.sqrt((e.force_rmse_n**2).mean(axis=0)) for e in errors]).T
    return [
        *(
            Figures(f"RPE {length_m:g} m", "%", ".2f", values, width=9)
            for length_m, values in zip(LENGTHS_M, rpe, strict=True)
        ),
        Figures("end", "%", ".2f", [e.end_percent for e in errors], width=6),
        Figures("yaw", "deg/m", ".3f", [e.yaw_deg_m for e in errors], width=7),
        Figures("vx", "mm/s", ".2f", velocity[0], width=6),
        Figures("vy", "mm/s", ".2f", velocity[1], width=6),
        Figures("yaw rate", "mrad/s", ".2f", velocity[2]),
        *(Figures(f"F{axis}", "N", ".2f", force[k]) for k, axis in enumerate("xyz")),
    ]


def leg_columns(comparison: OdometryComparison) -> list[Figures]:
    """Friction and stiffness of each leg at the end, and the RMSE of its force if there is truth."""
    last = comparison.track.estimates[-1]
    columns = [
        Figures("mu", "", ".3f", last.mu, width=6),
        Figures("sd", "", ".3f", last.mu_sd),
        Figures("K", "N/m", ".0f", last.stiffness, width=7),
        Figures("sd", "N/m", ".0f", last.stiffness * last.stiffness_sd),
    ]
    if comparison.errors:
        force = comparison.errors[0].force_rmse_n
        columns += [
            Figures(f"F{axis} RMSE", "N", ".2f", force[:, k]) for k, axis in enumerate("xyz")
        ]
    return columns


def displacement_and_sd(comparison: OdometryComparison) -> tuple[FloatArray, FloatArray]:
    """The estimator's displacement over the walking part, and its sd: x, y [m], yaw [rad]."""
    run = comparison.track
    return run.pose[-1] - run.pose[0], np.sqrt(np.diagonal(run.displacement_covariance[-1]))


def walking_words(comparison: OdometryComparison) -> str:
    """Which part of the log was judged."""
    t_s = comparison.track.t_s
    return f"{len(t_s)} of {comparison.log_ticks} ticks, {t_s[-1] - t_s[0]:.1f} s"


def health_rows(comparison: OdometryComparison) -> list[tuple[str, str]]:
    """How often the estimator was well, and why it was not: label and words.

    Reasons that differ in their numbers only are one row, with the numbers that were most frequent.
    """
    estimates = comparison.track.estimates
    poor: dict[tuple[str, str], Counter[str]] = {}
    for one in estimates:
        if one.health is not Health.OK:
            same = poor.setdefault((one.health.value, NUMBER.sub("#", one.reason)), Counter())
            same[one.reason] += 1
    fine = len(estimates) - sum(same.total() for same in poor.values())
    rows = [("health", f"ok {100 * fine / len(estimates):.1f} % of ticks")]
    for (health, _), same in sorted(poor.items(), key=lambda one: -one[1].total())[:MOST_REASONS]:
        count, (reason, _) = same.total(), same.most_common(1)[0]
        others = " (most often; other numbers, too)" if len(same) > 1 else ""
        rows.append((health, f"{reason}{others}, {count} {'tick' if count == 1 else 'ticks'}"))
    return rows


def short_walk(comparison: OdometryComparison) -> list[str]:
    """Why there is no relative error over a length, if the walk is too short for all of them."""
    if np.isfinite([e.rpe_percent for e in comparison.errors]).any() or comparison.truth is None:
        return []
    length_m = path_length(comparison.truth.pose)[-1]
    return [f"none: the walk is {length_m:.2f} m long, the shortest piece is {LENGTHS_M[0]:g} m"]


def consistency_rows(comparison: OdometryComparison) -> list[tuple[str, str]]:
    """Whether the estimator's covariances are as large as its errors: label and words."""
    run = comparison.track
    rows = [
        ("NEES (3 is ideal)", f"velocity {known_mean(comparison.twist_nees):.2f}, "
         f"{100 * in_band(comparison.twist_nees, 3):.0f} % in the 95 % band; "
         f"pose {known_mean(comparison.pose_nees):.2f}, {100 * in_band(comparison.pose_nees, 3):.0f} %")
    ]  # fmt: skip
    if len(run.nis_over_dof):
        words = f"{known_mean(run.nis_over_dof):.2f}; {run.rejected} measurements rejected"
        rows.append(("NIS over its numbers (1 is ideal)", words))
    return rows


def as_json(comparison: OdometryComparison) -> dict[str, object]:
    """The same for ``print_json``."""
    run = comparison.track
    last, (displacement, sd) = run.estimates[-1], displacement_and_sd(comparison)
    return {
        "ticks": len(run.t_s),
        "pose": run.pose[-1],
        "pose_covariance": last.pose_covariance,
        "way": displacement,
        "way_sd": sd,
        "health": last.health.value,
        "reason": last.reason,
        "step_us": {"median": np.median(run.step_us), "p99": np.percentile(run.step_us, 99)},
        "legs": comparison.names,
        "mu": last.mu,
        "mu_sd": last.mu_sd,
        "stiffness_n_m": last.stiffness,
        "ways": [
            {"name": e.name, "rpe_lengths_m": LENGTHS_M, **asdict(e)} for e in comparison.errors
        ],
        "nees_velocity": known_mean(comparison.twist_nees),
        "nees_pose": known_mean(comparison.pose_nees),
        "nis_over_dof": known_mean(run.nis_over_dof),
        "rejects": run.rejected,
    }
