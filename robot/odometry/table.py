"""A comparison of ways of dead reckoning as lines for a person and as JSON for a program."""

import math
import re
from collections import Counter

import numpy as np

from model.values.arrays import FloatArray
from robot.console.number_text import number_text
from robot.console.plain_json import plain
from robot.odometry.compare import Comparison
from robot.odometry.metrics import LENGTHS_M, TrackErrors, in_band, mean_of, path_length

NAME_LETTERS = 19
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
    last = run.estimates[-1]
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
        lines += _error_lines(found.errors if everything else found.errors[:1], width)
        lines += [f"{label}: {words}" for label, words in consistency_rows(found)]
        lines += [f"RPE: {words}" for words in short_walk(found)]
    elif everything:
        lines.append("no truth in this log: the ways are drawn beside each other (--out FILE.png)")
    lines += [
        f"{'leg':<6}{'mu':>8}{'sd':>7}{'K N/m':>9}{'sd':>7}"
        + (f"{'Fx':>8}{'Fy':>8}{'Fz':>8}   RMSE of force, N" if found.errors else "")
    ]
    for k, name in enumerate(names):
        row = (
            f"{name:<6}{number_text(last.mu[k], 3, 8)}{number_text(last.mu_sd[k], 3, 7)}"
            f"{number_text(last.stiffness[k], 0, 9)}"
            f"{number_text(last.stiffness[k] * last.stiffness_sd[k], 0, 7)}"
        )
        if found.errors:
            row += "".join(number_text(value, 2, 8) for value in found.errors[0].force_rmse[k])
        lines.append(row)
    return [*lines, SHORT_NOTE]


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


Column = tuple[str, str, int, list[str]]  # name, unit, width, a text for each way


def _error_lines(errors: tuple[TrackErrors, ...], width: int | None) -> list[str]:
    """The errors of each way: one table, or two below each other where one is too wide."""
    ahead, behind = _place_columns(errors), _rate_columns(errors)
    whole = NAME_LETTERS + sum(column[2] for column in (*ahead, *behind))
    parts = [[*ahead, *behind]] if width is None or whole <= width else [ahead, behind]
    lines: list[str] = []
    for part in parts:
        lines += [
            " " * NAME_LETTERS + "".join(f"{name:>{w}}" for name, _, w, _ in part),
            " " * NAME_LETTERS + "".join(f"{unit:>{w}}" for _, unit, w, _ in part),
        ]
        lines += [
            f"{e.name:<{NAME_LETTERS}}" + "".join(f"{texts[k]:>{w}}" for _, _, w, texts in part)
            for k, e in enumerate(errors)
        ]
    return lines


def _place_columns(errors: tuple[TrackErrors, ...]) -> list[Column]:
    return [
        *(
            (f"RPE {d:g} m", "%", 11, [number_text(e.rpe_percent[k], 2) for e in errors])
            for k, d in enumerate(LENGTHS_M)
        ),
        ("end", "%", 8, [number_text(e.end_percent, 2) for e in errors]),
        ("yaw", "deg/m", 9, [number_text(e.yaw_deg_m, 3) for e in errors]),
    ]


def _rate_columns(errors: tuple[TrackErrors, ...]) -> list[Column]:
    heads = (("vx", "mm/s", 8), ("vy", "mm/s", 8), ("yaw rate", "mrad/s", 10))
    forces = [force_rms(e) for e in errors]
    return [
        *(
            (name, unit, w, [number_text(1e3 * e.velocity_rmse[k], 2) for e in errors])
            for k, (name, unit, w) in enumerate(heads)
        ),
        *(
            (f"F{axis}", "N", 7, [number_text(force[k], 2) for force in forces])
            for k, axis in enumerate("xyz")
        ),
    ]


def force_rms(errors: TrackErrors) -> FloatArray:
    """RMSE of the predicted force over all feet: x, y, z, (3,) [N]."""
    found: FloatArray = np.sqrt((errors.force_rmse**2).mean(axis=0))
    return found


def consistency_rows(found: Comparison) -> list[tuple[str, str]]:
    """Whether the estimator's covariances are as large as its errors: label and words."""
    run = found.track
    rows = [
        ("NEES (3 is ideal)", f"velocity {mean_of(found.twist_nees):.2f}, "
         f"{100 * in_band(found.twist_nees, 3):.0f} % in the 95 % band; "
         f"pose {mean_of(found.pose_nees):.2f}, {100 * in_band(found.pose_nees, 3):.0f} %")
    ]  # fmt: skip
    if len(run.nis_over_dof):
        words = f"{mean_of(run.nis_over_dof):.2f}; {run.rejected} measurements rejected"
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
        "nees_velocity": mean_of(found.twist_nees),
        "nees_pose": mean_of(found.pose_nees),
        "nis_over_dof": mean_of(run.nis_over_dof),
        "rejects": run.rejected,
    })  # fmt: skip
