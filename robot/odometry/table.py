"""A comparison of methods of dead reckoning as lines for a person and as JSON for a program."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import NamedTuple

import numpy as np

from model.values.arrays import FloatArray, known_mean
from model.values.estimate import Health
from robot.console.screen_fit import wrapped
from robot.console.table import Column, number_text, row_lines, table_lines
from robot.odometry.compare import OdometryComparison
from robot.odometry.health import noticed, poor_health, share_of
from robot.odometry.metrics import LENGTHS_M, TrackErrors, in_band, path_length
from robot.odometry.sources import rejected_of, sources_of

NAME_LETTERS, LEG_LETTERS = 18, 6
MOST_REASONS = 5
AXES = "xyz"
PLACE_UNITS = ("%", "deg/m")
NAIVE = 1  # place of the open loop among the methods
IN_THREE = "3 is ideal, above 3: overconfident"
WORDS = "terms (RPE, NEES, NIS, mu, K): docs/glossary.md"


def table(comparison: OdometryComparison, width: int | None = None) -> list[str]:
    """Lines of text; a table wider than ``width`` letters is set as two. None: as wide as it is."""
    run = comparison.track
    step_us, slow_us = np.median(run.step_us), np.percentile(run.step_us, 99)
    rows = [
        ("walking", walking_words(comparison)),
        ("moved", ", ".join(moved_words(comparison))),
        ("step", f"{step_us:.0f} us (median), 99 % below {slow_us:.0f} us"),
        *health_rows(comparison),
    ]
    if not comparison.errors:
        rows.append(("truth", "no truth in this log, so there are no errors to show"))
    lines = row_lines(rows, width)
    if comparison.errors:
        lines += [
            "",
            "error against the ground truth (RPE, end: % of path; velocities, forces: RMSE)",
        ]
        columns, methods = error_columns(comparison.errors), [e.name for e in comparison.errors]
        first = Column("method", width=NAME_LETTERS)
        of_place = sum(one.unit in PLACE_UNITS for one in columns)
        lines += _fitted_lines(first, methods, columns, width, of_place)
        lines += row_lines([*consistency_rows(comparison), *unknown_rows(comparison)], width)
    elif sources_of(run):
        lines += ["", *row_lines(innovation_rows(comparison), width)]
    lines += ["", f"each leg at the end{force_words(comparison, '; ')}"]
    columns = leg_columns(comparison)
    first, of_leg = Column("leg", width=LEG_LETTERS), len(columns) - len(force_columns(comparison))
    lines += _fitted_lines(first, comparison.names, columns, width, of_leg)
    last = [*stride_words(comparison), WORDS]
    if width is not None:
        last = [piece for line in last for piece in wrapped(line, width)]
    return [*lines, "", *last]


class Figures(NamedTuple):
    """One figure of merit of each row of a table: its heading, unit, form, and values."""

    name: str
    unit: str
    form: str
    values: Sequence[float] | FloatArray
    width: int = 5


def _fitted_lines(
    first: Column, names: Sequence[str], columns: Sequence[Figures], width: int | None, part: int
) -> list[str]:
    """Figures below their names and units, next to the names of their rows.

    Those that are wider than ``width`` are two tables; the first has so many columns as ``part`` says.
    """
    whole = _figure_lines(first, names, columns)
    if width is None or max(map(len, whole)) <= width:
        return whole
    parts = [some for some in (columns[:part], columns[part:]) if some]
    return [line for some in parts for line in _figure_lines(first, names, some)]


def _figure_lines(first: Column, names: Sequence[str], columns: Sequence[Figures]) -> list[str]:
    heads = [first, *(Column(one.name, one.form, one.width) for one in columns)]
    units = ("", *(one.unit for one in columns))
    return table_lines(heads, [units, *zip(names, *(one.values for one in columns), strict=True)])


def error_columns(errors: Sequence[TrackErrors]) -> list[Figures]:
    """The errors of each method, a method a row; a column of which nothing is known is left out."""
    rpe = np.array([e.rpe_percent for e in errors]).T
    velocity = 1e3 * np.array([e.velocity_rmse for e in errors]).T
    # over all feet
    force = np.array([np.sqrt((e.force_rmse_n**2).mean(axis=0)) for e in errors]).T
    columns = [
        *(
            Figures(f"RPE {length_m:g} m", "%", ".2f", values, width=9)
            for length_m, values in zip(LENGTHS_M, rpe, strict=True)
        ),
        Figures("end", "%", ".2f", [e.end_percent for e in errors], width=6),
        Figures("yaw", "deg/m", ".3f", [e.yaw_deg_m for e in errors], width=7),
        Figures("vx", "mm/s", ".2f", velocity[0], width=6),
        Figures("vy", "mm/s", ".2f", velocity[1], width=6),
        Figures("yaw rate", "mrad/s", ".2f", velocity[2]),
        *(Figures(f"F{axis}", "N", ".2f", force[k]) for k, axis in enumerate(AXES)),
    ]
    return [one for one in columns if np.isfinite(one.values).any()]


def leg_columns(comparison: OdometryComparison) -> list[Figures]:
    """Friction and stiffness of each leg at the end, and the RMSE of its forces, if known."""
    last = comparison.track.estimates[-1]
    return [
        Figures("mu", "", ".3f", last.mu, width=6),
        Figures("sd", "", ".3f", last.mu * last.mu_sd),
        Figures("K", "N/m", ".0f", last.stiffness, width=7),
        Figures("sd", "N/m", ".0f", last.stiffness * last.stiffness_sd),
        *force_columns(comparison),
    ]


def force_columns(comparison: OdometryComparison) -> list[Figures]:
    """RMSE of the estimator's force on each foot, each axis next to the open loop's if that is compared."""
    methods = [("", 0)]
    if len(comparison.motions) > NAIVE:
        methods.append(("open loop ", NAIVE))
    rmse = [(name, comparison.leg_force_rmse(method)) for name, method in methods]
    return [
        Figures(f"{name}F{axis}", "N", ".2f", values[:, k])
        for k, axis in enumerate(AXES)
        for name, values in rmse
        if np.isfinite(values).any()
    ]


def force_words(comparison: OdometryComparison, before: str = "") -> str:
    """What the errors of forces are errors of; empty without any."""
    if not force_columns(comparison):
        return ""
    reference = "measured" if comparison.judged_by_sensors else "true"
    return f"{before}Fx, Fy, Fz: RMSE against the {reference} forces"


def displacement_and_sd(comparison: OdometryComparison) -> tuple[FloatArray, FloatArray]:
    """The estimator's displacement over the walking part, and its sd: x, y [m], yaw [rad]."""
    run = comparison.track
    return run.pose[-1] - run.pose[0], np.sqrt(np.diagonal(run.displacement_covariance[-1]))


def moved_words(comparison: OdometryComparison) -> tuple[str, str, str]:
    """The displacement with its standard deviations: ahead, aside, turned."""
    (ahead_m, aside_m, yaw_rad), sd = displacement_and_sd(comparison)
    return (
        f"{number_text(1e3 * ahead_m, 1)} +- {number_text(1e3 * sd[0], 1)} mm forward",
        f"{number_text(1e3 * aside_m, 1)} +- {number_text(1e3 * sd[1], 1)} mm left",
        f"turned {number_text(math.degrees(yaw_rad), 2)} +- {number_text(math.degrees(sd[2]), 2)} deg",
    )


def walking_words(comparison: OdometryComparison) -> str:
    """Which part of the log was judged."""
    t_s = comparison.track.t_s
    return f"{t_s[-1] - t_s[0]:.1f} s, {len(t_s)} of {comparison.log_ticks} ticks"


def health_rows(comparison: OdometryComparison) -> list[tuple[str, str]]:
    """How often the estimator was well, and why it was not: label and words."""
    run = comparison.track
    rows = [("health", f"ok {100 * share_of(run, Health.OK):.1f} % of ticks")]
    for one in poor_health(run)[:MOST_REASONS]:
        ticks = f"{one.ticks} {'tick' if one.ticks == 1 else 'ticks'}"
        rows.append((f"  {one.health.value}", f"{one.words}, {ticks}, {one.times}"))
    remarks = noticed(run)[:MOST_REASONS]
    rows.extend(("  noticed", f"{one.words}, {one.times}") for one in remarks)
    return rows


def unknown_rows(comparison: OdometryComparison) -> list[tuple[str, str]]:
    """Which errors are not known, and why: label and words."""
    if comparison.truth is None:
        return []
    rows, length_m = [], float(path_length(comparison.truth.pose)[-1])
    heading = bool(np.isfinite(comparison.truth.pose[:, 2]).any())
    if not heading:
        rows.append(
            ("unknown", "RPE, yaw, velocities, NEES: the ground truth has places without a heading")
        )
    elif not np.isfinite([e.rpe_percent for e in comparison.errors]).any():
        words = f"RPE: the walk is {length_m:.2f} m long, the shortest piece {LENGTHS_M[0]:g} m"
        rows.append(("unknown", words))
    if length_m == 0.0:
        rows.append(("unknown", "end, yaw: the ground truth does not move"))
    return rows


def consistency_rows(comparison: OdometryComparison) -> list[tuple[str, str]]:
    """Whether the estimator's covariances are as large as its errors: label and words."""
    parts: list[str] = []
    for name, values in (("velocity", comparison.twist_nees), ("pose", comparison.pose_nees)):
        if np.isfinite(values).any():
            what = "" if parts else " of ticks in the 95 % band"
            share = f"{100 * in_band(values, 3):.0f} %{what}"
            parts.append(f"{name} {number_text(known_mean(values), 2)} ({share})")
    rows = [("NEES", f"{', '.join(parts)}; {IN_THREE}")] if parts else []
    return rows + innovation_rows(comparison)


def innovation_rows(comparison: OdometryComparison) -> list[tuple[str, str]]:
    """Whether measurements were as far off as the filter expected, and what it rejected."""
    run = comparison.track
    fits = sources_of(run)
    if not fits:
        return []
    means = ", ".join(f"{one.name} {number_text(one.mean, 2)}" for one in fits)
    rows = [("NIS", f"per degree of freedom: {means} (1 is ideal)")]
    settings = comparison.config.estimator.settings
    places = ", ".join(
        f"{one.place} {one.count}" for one in rejected_of(run, comparison.names, settings)
    )
    return [*rows, ("rejected", f"{run.rejected} measurements{': ' * bool(places)}{places}")]


def stride_words(comparison: OdometryComparison) -> list[str]:
    """What the distance a stride is, and what it was calibrated on; nothing without that method."""
    if not np.isfinite(comparison.stride_m):
        return []
    length = f"{1e3 * comparison.stride_m:.1f} mm a cycle"
    return [f"distance a stride: {length}, calibrated on {comparison.stride_from}"]


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
        "noticed": [
            {"words": one.words, "share": one.share, "times_s": one.periods.tolist()}
            for one in noticed(run)
        ],
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
        "sources": [{"name": one.name, "nis_over_dof": one.mean} for one in sources_of(run)],
        "rejects": run.rejected,
        "rejected": [
            {"name": one.name, "leg": one.leg, "count": one.count, "why": one.why}
            for one in rejected_of(run, comparison.names, comparison.config.estimator.settings)
        ],
        "stride_m": comparison.stride_m,
        "stride_from": comparison.stride_from,
    }
