"""What a log says in a few lines: distance, speed, slip, forces, faults, loop."""

from dataclasses import dataclass

import numpy as np

from model.signals import FloatArray, StopReason
from record.recording import Recording
from robot.run_totals import RunTotals, truth_yaw


@dataclass(frozen=True, slots=True)
class Summary:
    """Figures of one run. NaN where they cannot be known; velocities: vx, vy [m/s], yaw rate [rad/s].

    Attributes:
        gait: Gait, as the log's metadata has it.
        hardware: Hardware, as the log's metadata has it.
        duration_s: Length of the log.
        walking_s: Time in mode WALK.
        cycles: Gait cycles walked.
        truth: Whether distance, speed and slip are the plant's or motion capture's, not the model's.
        distance_m: Way in the ground plane while walking, straight from first to last point.
        forward_m: The same along the body's first heading.
        mean_speed_m_s: Forward way over walking time.
        yaw_rad: Change of heading.
        slip_percentiles_m_s: 5, 25, 50, 75 and 95 % of the forward slip velocity of loaded feet.
        velocity_rmse: Predicted against true body velocity while walking, per component.
        velocity_rms: RMS of the true body velocity while walking, per component.
        force_rmse_n: Predicted against measured foot force while walking, x, y, z.
        drift_m: Distance between dead reckoning and truth at the end.
        odometry_rmse: The estimator's against true body velocity while walking, per component.
        odometry_force_rmse_n: Its against measured foot force while walking, x, y, z.
        odometry_drift_m: Distance between its pose and truth at the end.
        odometry_sd: Its standard deviations of x, y [m], yaw [rad] at the end.
        odometry_health: Share of the ticks with health ok, degraded, lost; of those in which it ran.
        faults: Counts by kind, most frequent first.
        late_p50_ms: Median lateness of a tick.
        late_p99_ms: 99 %.
        late_max_ms: Largest.
        missed: Periods missed.
        ticks: Number of ticks.
        hottest_c: Highest servo temperature.
        stop_reason: Why it ended.
        damage: Empty, or how the file ends early.
    """

    gait: str
    hardware: str
    duration_s: float
    walking_s: float
    cycles: float
    truth: bool
    distance_m: float
    forward_m: float
    mean_speed_m_s: float
    yaw_rad: float
    slip_percentiles_m_s: tuple[float, ...]
    velocity_rmse: tuple[float, ...]
    velocity_rms: tuple[float, ...]
    force_rmse_n: tuple[float, ...]
    drift_m: float
    odometry_rmse: tuple[float, ...]
    odometry_force_rmse_n: tuple[float, ...]
    odometry_drift_m: float
    odometry_sd: tuple[float, ...]
    odometry_health: tuple[float, ...]
    faults: tuple[tuple[str, int], ...]
    late_p50_ms: float
    late_p99_ms: float
    late_max_ms: float
    missed: int
    ticks: int
    hottest_c: float
    stop_reason: str
    damage: str


PERCENTILES = (5, 25, 50, 75, 95)


def summarise(log: Recording) -> Summary:
    """Compute the figures of a log."""
    totals = RunTotals()
    totals.add(log)
    return summarise_totals(totals, log)


def summarise_totals(totals: RunTotals, last: Recording) -> Summary:
    """Compute the figures of a log that was read in blocks.

    Args:
        totals: What all blocks gave.
        last: The last block; it knows metadata and damage.
    """
    t_s, walking, pose = totals.column("t_s"), totals.walking, totals.pose()
    walking_s = float(np.sum(walking[1:] * np.diff(t_s)))
    way, forward, turn = _way(pose[walking & np.isfinite(pose).all(axis=1)])
    late_ms = totals.column("lateness_s") * 1e3
    return Summary(
        gait=last.metadata.get("gait", "?"),
        hardware=last.metadata.get("hardware", "?"),
        duration_s=float(t_s[-1] - t_s[0]),
        walking_s=walking_s,
        cycles=_span(totals.column("gait_phase")[walking]),
        truth=totals.truth,
        distance_m=way,
        forward_m=forward,
        mean_speed_m_s=forward / walking_s if walking_s > 0 else np.nan,
        yaw_rad=turn,
        slip_percentiles_m_s=_percentiles(totals.slip_m_s()),
        velocity_rmse=totals.velocity_error.root(),
        velocity_rms=totals.velocity.root(),
        force_rmse_n=totals.force_error.root(),
        drift_m=_drift(totals.true_pose(), totals.column("estimate")),
        odometry_rmse=totals.odometry_error.root(),
        odometry_force_rmse_n=totals.odometry_force_error.root(),
        odometry_drift_m=_drift(totals.true_pose(), totals.column("odometry")),
        odometry_sd=tuple(totals.odometry_sd.tolist()),
        odometry_health=_health(totals.column("odometry_health")),
        faults=tuple(totals.faults.most_common()),
        late_p50_ms=float(np.percentile(late_ms, 50)),
        late_p99_ms=float(np.percentile(late_ms, 99)),
        late_max_ms=float(late_ms.max()),
        missed=totals.missed,
        ticks=len(t_s),
        hottest_c=totals.hottest_c,
        stop_reason=StopReason(int(last.stop_reason[-1])).name.lower().replace("_", " "),
        damage=last.damage,
    )


def planar_pose(log: Recording) -> FloatArray:
    """Return x, y [m] and yaw [rad], (T, 3): the truth's if there is one, else dead reckoning's."""
    if not log.has_truth:
        return log.estimate_pose
    return np.column_stack([log.truth_position_W[:, :2], truth_yaw(log)])


def _way(pose: FloatArray) -> tuple[float, float, float]:
    if len(pose) < 2:
        return np.nan, np.nan, np.nan
    step = pose[-1, :2] - pose[0, :2]
    heading = np.array([np.cos(pose[0, 2]), np.sin(pose[0, 2])])
    return float(np.hypot(*step)), float(step @ heading), float(pose[-1, 2] - pose[0, 2])


def _span(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known[-1] - known[0]) if len(known) else np.nan


def _percentiles(values: FloatArray) -> tuple[float, ...]:
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return (np.nan,) * len(PERCENTILES)
    return tuple(float(p) for p in np.percentile(known, PERCENTILES))


def _health(codes: FloatArray) -> tuple[float, ...]:
    ran = codes[codes >= 0]
    return tuple(float(np.mean(ran == code)) for code in range(3)) if len(ran) else (np.nan,) * 3


def _drift(true: FloatArray, estimate: FloatArray) -> float:
    known = np.flatnonzero(np.isfinite(true[:, 0]))
    if len(known) == 0:
        return np.nan
    first, last = known[0], known[-1]
    yaw = true[first, 2] - estimate[first, 2]
    c, s = np.cos(yaw), np.sin(yaw)
    moved = estimate[last, :2] - estimate[first, :2]
    there = true[first, :2] + np.array([[c, -s], [s, c]]) @ moved
    return float(np.hypot(*(true[last, :2] - there)))


def summary_lines(summary: Summary) -> list[str]:
    """Return the summary as lines of text for a person."""
    return table_lines(summary_rows(summary))


def table_lines(rows: list[tuple[str, str]]) -> list[str]:
    """Return rows as lines, labels in a column."""
    width = max(len(label) for label, _ in rows)
    return [f"{label:<{width}}  {text}" for label, text in rows]


def summary_rows(summary: Summary) -> list[tuple[str, str]]:
    """Return label and text of each row of the table."""
    s = summary
    source = "true" if s.truth else "estimated"
    slip = "  ".join(
        f"{p}% {v * 1e3:.1f}" for p, v in zip(PERCENTILES, s.slip_percentiles_m_s, strict=True)
    )
    rows = [
        ("run", f"{s.gait} on {s.hardware}, {s.duration_s:.1f} s, ended: {s.stop_reason}"),
        ("walked", f"{s.cycles:.2f} cycles in {s.walking_s:.1f} s"),
        ("distance", f"{s.distance_m:.3f} m ({source}), forward {s.forward_m:.3f} m"),
        ("mean speed", f"{s.mean_speed_m_s * 1e3:.1f} mm/s forward"),
        ("turned", f"{np.degrees(s.yaw_rad):.1f} deg"),
        ("forward slip of loaded feet", f"{slip}  mm/s ({source})"),
    ]
    if s.truth:
        rows += [
            ("predicted velocity, RMSE", _velocity_words(s.velocity_rmse)),
            ("true velocity, RMS", _velocity_words(s.velocity_rms)),
            ("drift of dead reckoning", f"{s.drift_m * 1e3:.1f} mm at the end"),
        ]
    rows.append(("predicted foot force, RMSE", _force_words(s.force_rmse_n)))
    if np.isfinite(s.odometry_health[0]):
        rows += _odometry_rows(s)
    rows += [
        ("loop", f"{s.ticks} ticks, late p50 {s.late_p50_ms:.2f} p99 {s.late_p99_ms:.2f} "
         f"max {s.late_max_ms:.2f} ms, {s.missed} missed"),
        ("hottest servo", f"{s.hottest_c:.0f} C"),
        ("faults", ", ".join(f"{kind} x{n}" for kind, n in s.faults) or "none"),
    ]  # fmt: skip
    if s.damage:
        rows.append(("file", s.damage))
    return rows


def _odometry_rows(s: Summary) -> list[tuple[str, str]]:
    ok, degraded, lost = (100 * share for share in s.odometry_health)
    x, y, yaw = s.odometry_sd
    rows = [
        ("estimator", f"ok {ok:.1f} %, degraded {degraded:.1f} %, lost {lost:.1f} % of the time"),
        ("  one sd at the end", f"x {x * 1e3:.1f}  y {y * 1e3:.1f} mm  yaw {yaw * 1e3:.1f} mrad"),
    ]
    if s.truth:
        rows += [
            ("  velocity, RMSE", _velocity_words(s.odometry_rmse)),
            ("  drift", f"{s.odometry_drift_m * 1e3:.1f} mm at the end"),
        ]
    return [*rows, ("  foot force, RMSE", _force_words(s.odometry_force_rmse_n))]


def _force_words(values: tuple[float, ...]) -> str:
    return "  ".join(f"{axis} {v:.2f}" for axis, v in zip("xyz", values, strict=True)) + "  N"


def _velocity_words(values: tuple[float, ...]) -> str:
    x, y, yaw = values
    return f"vx {x * 1e3:.1f}  vy {y * 1e3:.1f} mm/s  yaw rate {yaw * 1e3:.1f} mrad/s"
