"""A comparison of ways of dead reckoning as lines for a person and as JSON for a program."""

import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from model.values.arrays import FloatArray, known_mean
from robot.console.json_output import plain
from robot.console.table import number_text
from robot.odometry.compare import Comparison
from robot.odometry.metrics import LENGTHS_M, TrackErrors, in_band, path_length

NAME_LETTERS, LEG_LETTERS = 19, 6
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
    ("mu, K", "friction coefficient and vertical stiffness of a leg, as the estimator found them"),
)  # fmt: skip
SHORT_NOTE = "RPE: relative pose error, mu: friction, K: leg stiffness; see docs/odometry.md"


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
    way, sd = way_and_sd(found)
    lines = [
        f"walking part: {walking_words(found)}",
        f"way: {number_text(1e3 * way[0], 1)} mm ahead, "
        f"{number_text(1e3 * way[1], 1)} mm aside, {number_text(math.degrees(way[2]), 2)} deg",
        f"standard deviation at the end: {1e3 * sd[0]:.1f} mm, {1e3 * sd[1]:.1f} mm, "
        f"{math.degrees(sd[2]):.2f} deg",
        f"step {np.median(run.step_us):.0f} us, 99 % below {np.percentile(run.step_us, 99):.0f} us",
        *(f"{'  ' * (label != 'health')}{label}: {words}" for label, words in health_rows(found)),
    ]
    if found.errors:
        errors = found.errors if everything else found.errors[:1]
        columns, ways = error_columns(errors), [e.name for e in errors]
        whole = NAME_LETTERS + sum(column.width for column in columns)
        cut = len(columns) if width is None or whole <= width else PLACE_COLUMNS
        for part in filter(None, (columns[:cut], columns[cut:])):
            lines += _column_lines("", NAME_LETTERS, ways, part)
        lines += [f"{label}: {words}" for label, words in consistency_rows(found)]
        lines += [f"RPE: {words}" for words in short_walk(found)]
    elif everything:
        lines.append("no truth in this log: the ways are drawn beside each other (--out FILE.png)")
    return [*lines, *_column_lines("leg", LEG_LETTERS, names, leg_columns(found)), SHORT_NOTE]


class Column(NamedTuple):
    """A column of a table: its head, letters of a line, and a text a row."""

    name: str
    unit: str
    width: int
    texts: list[str]


def _column_lines(
    label: str, letters: int, names: Sequence[str], columns: Sequence[Column]
) -> list[str]:
    """Columns below their names and units, beside the names of their rows."""
    rows = [(label, *(c.name for c in columns)), ("", *(c.unit for c in columns))]
    rows += [(name, *(c.texts[k] for c in columns)) for k, name in enumerate(names)]
    widths = [column.width for column in columns]
    return [
        f"{head:<{letters}}" + "".join(f"{t:>{w}}" for t, w in zip(texts, widths, strict=True))
        for head, *texts in rows
    ]


def error_columns(errors: Sequence[TrackErrors]) -> list[Column]:
    """The errors of each way, a way a row; the first ``PLACE_COLUMNS`` are of the place."""

    def column(name: str, unit: str, width: int, digits: int, values: Iterable[float]) -> Column:
        return Column(name, unit, width, [number_text(value, digits) for value in values])

    rates = (("vx", "mm/s", 8), ("vy", "mm/s", 8), ("yaw rate", "mrad/s", 10))
    forces = np.array([np.sqrt((e.force_rmse**2).mean(axis=0)) for e in errors])  # over all feet
    return [
        *(
            column(f"RPE {length_m:g} m", "%", 11, 2, (e.rpe_percent[k] for e in errors))
            for k, length_m in enumerate(LENGTHS_M)
        ),
        column("end", "%", 8, 2, (e.end_percent for e in errors)),
        column("yaw", "deg/m", 9, 3, (e.yaw_deg_m for e in errors)),
        *(
            column(name, unit, width, 2, (1e3 * e.velocity_rmse[k] for e in errors))
            for k, (name, unit, width) in enumerate(rates)
        ),
        *(column(f"F{axis}", "N", 7, 2, forces[:, k]) for k, axis in enumerate("xyz")),
    ]


def leg_columns(found: Comparison) -> list[Column]:
    """Friction and stiffness of each leg at the end, and the RMSE of its force if there is truth."""
    last = found.track.estimates[-1]
    values = [
        ("mu", "", 8, 3, last.mu),
        ("sd", "", 7, 3, last.mu_sd),
        ("K", "N/m", 9, 0, last.stiffness),
        ("sd", "N/m", 7, 0, last.stiffness * last.stiffness_sd),
    ]
    if found.errors:
        force = found.errors[0].force_rmse
        values += [(f"F{axis} RMSE", "N", 9, 2, force[:, k]) for k, axis in enumerate("xyz")]
    return [
        Column(name, unit, width, [number_text(value, digits) for value in each])
        for name, unit, width, digits, each in values
    ]


def way_and_sd(found: Comparison) -> tuple[FloatArray, FloatArray]:
    """The estimator's way over the walking part, and its standard deviation: x, y [m], yaw [rad]."""
    run = found.track
    return run.pose[-1] - run.pose[0], np.sqrt(np.diagonal(run.way_covariance[-1]))


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


def consistency_rows(found: Comparison) -> list[tuple[str, str]]:
    """Whether the estimator's covariances are as large as its errors: label and words."""
    run = found.track
    rows = [
        ("NEES (3 is ideal)", f"velocity {known_mean(found.twist_nees):.2f}, "
         f"{100 * in_band(found.twist_nees, 3):.0f} % in the 95 % band; "
         f"pose {known_mean(found.pose_nees):.2f}, {100 * in_band(found.pose_nees, 3):.0f} %")
    ]  # fmt: skip
    if len(run.nis_over_dof):
        words = f"{known_mean(run.nis_over_dof):.2f}; {run.rejected} measurements rejected"
        rows.append(("NIS over its numbers (1 is ideal)", words))
    return rows


def as_json(found: Comparison, names: tuple[str, ...]) -> object:
    """The same for a program; what is not known is null."""
    run = found.track
    last, (way, sd) = run.estimates[-1], way_and_sd(found)
    return plain({
        "ticks": len(run.t_s),
        "pose": run.pose[-1],
        "pose_covariance": last.pose_covariance,
        "way": way,
        "way_sd": sd,
        "health": last.health.value,
        "reason": last.reason,
        "step_us": {
            "median": float(np.median(run.step_us)),
            "p99": float(np.percentile(run.step_us, 99)),
        },
        "legs": names,
        "mu": last.mu,
        "mu_sd": last.mu_sd,
        "stiffness_n_m": last.stiffness,
        "ways": [
            {
                "name": e.name,
                "rpe_lengths_m": LENGTHS_M,
                "rpe_percent": e.rpe_percent,
                "end_percent": e.end_percent,
                "yaw_deg_m": e.yaw_deg_m,
                "velocity_rmse": e.velocity_rmse,
                "force_rmse_n": e.force_rmse,
            }
            for e in found.errors
        ],
        "nees_velocity": known_mean(found.twist_nees),
        "nees_pose": known_mean(found.pose_nees),
        "nis_over_dof": known_mean(run.nis_over_dof),
        "rejects": run.rejected,
    })  # fmt: skip
