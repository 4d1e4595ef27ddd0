"""What a log says in a few lines: distance, speed, slip, forces, faults, loop."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from model.signals import FloatArray, Mode, StopReason
from record.recording import Recording


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
    walking = log.mode == Mode.WALK.value
    walking_s = float(np.sum(walking[1:] * np.diff(log.t_s)))
    pose = planar_pose(log)
    where = walking & np.isfinite(pose).all(axis=1)
    way, forward, turn = _way(pose[where])
    error = log.predicted_velocity_B - log.truth_velocity_B
    force_error = log.predicted_force_n - log.force_n
    late_ms = log.lateness_s * 1e3
    return Summary(
        gait=log.metadata.get("gait", "?"),
        hardware=log.metadata.get("hardware", "?"),
        duration_s=float(log.t_s[-1] - log.t_s[0]),
        walking_s=walking_s,
        cycles=_span(log.gait_phase[walking]),
        truth=log.has_truth,
        distance_m=way,
        forward_m=forward,
        mean_speed_m_s=forward / walking_s if walking_s > 0 else np.nan,
        yaw_rad=turn,
        slip_percentiles_m_s=_percentiles(forward_slip(log)[walking]),
        velocity_rmse=_rms(error[walking]),
        velocity_rms=_rms(log.truth_velocity_B[walking]),
        force_rmse_n=_rms(force_error[walking].reshape(-1, 3)),
        drift_m=_drift(log),
        faults=tuple(Counter(fault.kind.name for _, fault in log.faults).most_common()),
        late_p50_ms=float(np.percentile(late_ms, 50)),
        late_p99_ms=float(np.percentile(late_ms, 99)),
        late_max_ms=float(late_ms.max()),
        missed=int(log.missed.sum()),
        ticks=len(log.t_s),
        hottest_c=float(np.nanmax(log.temperature_c))
        if np.isfinite(log.temperature_c).any()
        else np.nan,
        stop_reason=StopReason(int(log.stop_reason[-1])).name.lower().replace("_", " "),
        damage=log.damage,
    )


def planar_pose(log: Recording) -> FloatArray:
    """Return x, y [m] and yaw [rad], (T, 3): the truth's if there is one, else dead reckoning's."""
    if not log.has_truth:
        return log.estimate_pose
    return np.column_stack([log.truth_position_W[:, :2], truth_yaw(log)])


def truth_yaw(log: Recording) -> FloatArray:
    """Return the true yaw, unwrapped, (T,) [rad]."""
    x, y, z, w = log.truth_quaternion_xyzw.T
    yaw: FloatArray = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    known = np.isfinite(yaw)
    yaw[known] = np.unwrap(yaw[known])
    return yaw


def forward_slip(log: Recording) -> FloatArray:
    """Return the velocity of loaded feet over the ground along the body's x, (T, N) [m/s]."""
    if not log.has_truth:
        return log.predicted_slip_B[:, :, 0]
    yaw = truth_yaw(log)[:, None]
    velocity = log.truth_foot_velocity_W
    along = np.cos(yaw) * velocity[:, :, 0] + np.sin(yaw) * velocity[:, :, 1]
    slip: FloatArray = np.where(log.truth_contact, along, np.nan)
    return slip


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


def _rms(values: FloatArray) -> tuple[float, ...]:
    known = np.isfinite(values).all(axis=1)
    if not known.any():
        return tuple(float("nan") for _ in range(values.shape[1]))
    return tuple(float(v) for v in np.sqrt(np.mean(values[known] ** 2, axis=0)))


def _drift(log: Recording) -> float:
    known = np.flatnonzero(np.isfinite(log.truth_position_W[:, 0]))
    if len(known) == 0:
        return np.nan
    first, last = known[0], known[-1]
    yaw = truth_yaw(log)[first] - log.estimate_pose[first, 2]
    c, s = np.cos(yaw), np.sin(yaw)
    moved = log.estimate_pose[last, :2] - log.estimate_pose[first, :2]
    there = log.truth_position_W[first, :2] + np.array([[c, -s], [s, c]]) @ moved
    return float(np.hypot(*(log.truth_position_W[last, :2] - there)))


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
    rows += [
        ("predicted foot force, RMSE", "  ".join(
            f"{axis} {v:.2f}" for axis, v in zip("xyz", s.force_rmse_n, strict=True)
        ) + "  N"),
        ("loop", f"{s.ticks} ticks, late p50 {s.late_p50_ms:.2f} p99 {s.late_p99_ms:.2f} "
         f"max {s.late_max_ms:.2f} ms, {s.missed} missed"),
        ("hottest servo", f"{s.hottest_c:.0f} C"),
        ("faults", ", ".join(f"{kind} x{n}" for kind, n in s.faults) or "none"),
    ]  # fmt: skip
    if s.damage:
        rows.append(("file", s.damage))
    return rows


def _velocity_words(values: tuple[float, ...]) -> str:
    x, y, yaw = values
    return f"vx {x * 1e3:.1f}  vy {y * 1e3:.1f} mm/s  yaw rate {yaw * 1e3:.1f} mrad/s"
