"""A comparison of ways of dead reckoning as lines for a person and as JSON for a program."""

import math
from collections import Counter

import numpy as np

from robot.odometry_compare import Comparison
from robot.odometry_metrics import LENGTHS_M, TrackErrors, in_band


def table(found: Comparison, names: tuple[str, ...], *, everything: bool) -> list[str]:
    """Lines of text; ``everything`` adds the other ways and the forces leg by leg."""
    run = found.track
    last = run.estimates[-1]
    way = run.pose[-1] - run.pose[0]
    lines = [
        f"{len(run.t_s)} ticks, {run.t_s[-1] - run.t_s[0]:.1f} s: {1e3 * way[0]:.1f} mm ahead, "
        f"{1e3 * way[1]:.1f} mm aside, {math.degrees(way[2]):.2f} deg",
        "standard deviation at the end: "
        f"{1e3 * math.sqrt(last.pose_covariance[0, 0]):.1f} mm, "
        f"{1e3 * math.sqrt(last.pose_covariance[1, 1]):.1f} mm, "
        f"{math.degrees(math.sqrt(last.pose_covariance[2, 2])):.2f} deg",
        f"step {np.median(run.step_us):.0f} us, 99 % below {np.percentile(run.step_us, 99):.0f} us",
        *_health(found),
    ]
    if found.errors:
        lines += _error_lines(found.errors if everything else found.errors[:1])
        lines += _consistency(found)
    elif everything:
        lines.append("no truth in this log: the ways are drawn beside each other (--out FILE.png)")
    lines += [
        f"{'leg':<6}{'mu':>8}{'sd':>7}{'K N/m':>9}{'sd':>7}"
        + (f"{'Fx':>8}{'Fy':>8}{'Fz':>8}   RMSE of predicted force, N" if found.errors else "")
    ]
    for k, name in enumerate(names):
        row = (
            f"{name:<6}{last.mu[k]:>8.3f}{last.mu_sd[k]:>7.3f}{last.stiffness[k]:>9.0f}"
            f"{last.stiffness[k] * last.stiffness_sd[k]:>7.0f}"
        )
        if found.errors:
            row += "".join(f"{value:>8.2f}" for value in found.errors[0].force_rmse[k])
        lines.append(row)
    return lines


def _health(found: Comparison) -> list[str]:
    total = len(found.track.estimates)
    spoken = Counter((e.health.value, e.reason) for e in found.track.estimates)
    fine = sum(count for (health, _), count in spoken.items() if health == "ok")
    lines = [f"health: ok {100 * fine / total:.1f} % of ticks"]
    seen = Counter[str]()
    for (health, reason), count in spoken.items():
        if health != "ok":
            words = "".join(letter for letter in reason if not letter.isdigit())
            seen[f"{health}: {words}"] += count
    return lines + [f"  {words}, {count} ticks" for words, count in seen.most_common(5)]


def _error_lines(errors: tuple[TrackErrors, ...]) -> list[str]:
    rpe = "".join(f"{f'RPE {d:g} m':>11}" for d in LENGTHS_M)
    lines = [
        f"{'':<19}{rpe}{'end':>8}{'yaw':>9}{'vx':>8}{'vy':>8}{'yaw rate':>10}{'Fx':>7}{'Fy':>7}{'Fz':>7}",
        f"{'':<19}{'%':>11}{'%':>11}{'%':>11}{'%':>8}{'deg/m':>9}{'mm/s':>8}{'mm/s':>8}{'mrad/s':>10}"
        f"{'N':>7}{'N':>7}{'N':>7}",
    ]
    for e in errors:
        force = np.sqrt((e.force_rmse**2).mean(axis=0))
        lines.append(
            f"{e.name:<19}"
            + "".join(_number(value, 11, 2) for value in e.rpe_percent)
            + _number(e.end_percent, 8, 2)
            + _number(e.yaw_deg_m, 9, 3)
            + _number(1e3 * e.velocity_rmse[0], 8, 2)
            + _number(1e3 * e.velocity_rmse[1], 8, 2)
            + _number(1e3 * e.velocity_rmse[2], 10, 2)
            + "".join(_number(value, 7, 2) for value in force)
        )
    return lines


def _number(value: float, width: int, digits: int) -> str:
    return f"{value:>{width}.{digits}f}" if math.isfinite(value) else f"{'-':>{width}}"


def _consistency(found: Comparison) -> list[str]:
    run = found.track
    nis = run.nis[run.nis_dof > 0] / run.nis_dof[run.nis_dof > 0]
    lines = [
        f"NEES (3 is ideal): velocity {np.mean(found.twist_nees):.2f}, "
        f"{100 * in_band(found.twist_nees, 3):.0f} % in the 95 % band; "
        f"pose {np.mean(found.pose_nees):.2f}, {100 * in_band(found.pose_nees, 3):.0f} %"
    ]
    if len(nis):
        lines.append(
            f"NIS over its numbers (1 is ideal): {np.mean(nis):.2f}; "
            f"{run.estimates[-1].rejects} measurements rejected"
        )
    return lines


def as_json(found: Comparison, names: tuple[str, ...]) -> dict[str, object]:
    """The same for a program; what is not known is null."""
    run = found.track
    last = run.estimates[-1]
    counted = run.nis_dof > 0
    return {
        "ticks": len(run.t_s),
        "pose": _plain(run.pose[-1]),
        "pose_covariance": _plain(last.pose_covariance),
        "health": last.health.value,
        "reason": last.reason,
        "step_us": {
            "median": float(np.median(run.step_us)),
            "p99": float(np.percentile(run.step_us, 99)),
        },
        "legs": list(names),
        "mu": _plain(last.mu),
        "mu_sd": _plain(last.mu_sd),
        "stiffness_n_m": _plain(last.stiffness),
        "ways": [
            {
                "name": e.name,
                "rpe_lengths_m": list(LENGTHS_M),
                "rpe_percent": _plain(e.rpe_percent),
                "end_percent": _plain(e.end_percent),
                "yaw_deg_m": _plain(e.yaw_deg_m),
                "velocity_rmse": _plain(e.velocity_rmse),
                "force_rmse_n": _plain(e.force_rmse),
            }
            for e in found.errors
        ],
        "nees_velocity": _plain(found.twist_nees.mean()),
        "nees_pose": _plain(found.pose_nees.mean()),
        "nis_over_dof": _plain(
            np.mean(run.nis[counted] / run.nis_dof[counted]) if counted.any() else np.nan
        ),
        "rejects": last.rejects,
    }


def _plain(value: object) -> object:
    """Lists and numbers; JSON has no NaN."""
    if isinstance(value, np.ndarray) and value.ndim:
        return [_plain(item) for item in value]
    number = float(value)  # type: ignore[arg-type]
    return number if math.isfinite(number) else None
