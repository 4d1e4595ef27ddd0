"""What a log says in a few figures: distance, speed, slip, forces, faults, loop."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from model.errors import BigantError
from model.motion.se2 import aligning, compose, seen_from
from model.values.arrays import FloatArray
from model.values.faults import StopReason
from record.log.blocks.read import read_blocks
from record.log.reader import LogContents
from record.log.recording import Recording, join_recordings, thin_recording
from robot.config.robot_file import parse_robot
from robot.console.progress import ProgressLine
from robot.control.effect_uses import TrueForces, true_forces_of_log
from robot.report.ground_truth import true_pose
from robot.report.run_totals import RunTotals


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
        distance_m: Distance in the ground plane while walking, straight from first to last point.
        forward_m: The same along the body's first heading.
        mean_speed_m_s: Forward distance over walking time.
        yaw_rad: Change of heading.
        slip_percentiles_m_s: 5, 25, 50, 75 and 95 % of the forward slip velocity of loaded feet.
        velocity_rmse: Predicted against true body velocity while walking, per component.
        velocity_rms: RMS of the true body velocity while walking, per component.
        force_rmse_n: Predicted against measured foot force while walking, x, y, z.
        drift_m: Distance between dead reckoning and truth at the end of the run.
        walk_drift_m: The same over the walk alone: both begin together where it begins.
        estimate_rmse: The estimator's against true body velocity while walking, per component.
        estimate_force_rmse_n: Its against measured foot force while walking, x, y, z.
        estimate_drift_m: Distance between its pose and truth at the end of the run.
        estimate_walk_drift_m: The same over the walk alone.
        estimate_sd: Its standard deviations of x, y [m], yaw [rad] at the end of the run.
        estimate_health: Share of the ticks with health ok, degraded, lost; of those in which it ran.
        forces: Whether any foot force was measured.
        sensors: Whether the log's robot file has force sensors.
        imu_share: Share of the ticks with a yaw rate, a roll, a pitch of an IMU.
        gyro_bias: The estimated bias of the yaw gyro and its sd at the end [rad/s].
        faults: Ticks in which each kind of fault was, most frequent first.
        last_faults: Time [s] and words of each fault the last time it was, the newest first.
        late_p50_ms: Median lateness of a tick.
        late_p99_ms: 99 %.
        late_max_ms: Largest.
        missed: Periods missed.
        ticks: Number of ticks.
        hottest_c: Highest servo temperature.
        stop_reason: Why it ended.
        stop_s: When it began to stop, on the log's clock; NaN if it did not.
        stop_cause: The faults that made it stop, in words; empty if none did.
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
    walk_drift_m: float
    estimate_rmse: tuple[float, ...]
    estimate_force_rmse_n: tuple[float, ...]
    estimate_drift_m: float
    estimate_walk_drift_m: float
    estimate_sd: tuple[float, ...]
    estimate_health: tuple[float, ...]
    forces: bool
    sensors: bool
    imu_share: tuple[float, ...]
    gyro_bias: tuple[float, ...]
    faults: tuple[tuple[str, int], ...]
    last_faults: tuple[tuple[float, str], ...]
    late_p50_ms: float
    late_p99_ms: float
    late_max_ms: float
    missed: int
    ticks: int
    hottest_c: float
    stop_reason: str
    stop_s: float
    stop_cause: str
    damage: str


PERCENTILES = (5, 25, 50, 75, 95)
# Five minutes at 100 Hz are kept whole; of a longer log every second, fourth, ... tick is drawn. A page
# shows a few hundred points of each curve, and memory goes with what is drawn.
WHOLE_TICKS, DRAWN_TICKS = 30_000, 15_000


def read_summary(path: Path) -> tuple[Summary, Recording]:
    """Return the figures of all of a log of any length, and as much of it as pictures need.

    Memory is bounded. Forces are without what the log's robot file says that the sensors add.

    Raises:
        RecordError: The log cannot be read.
    """
    contents = LogContents()
    totals = RunTotals()
    kept: list[Recording] = []
    step, count = 1, 0
    true_forces: TrueForces | None = None
    with ProgressLine(f"reading {path}", contents.progress):
        for measured in read_blocks(path, contents):
            if count == 0:  # the robot file comes before the first tick
                true_forces = true_forces_of_log(measured.config_text)
            block = measured
            if true_forces is not None:
                block = replace(measured, force_n=true_forces(measured.force_n, measured.t_s))
            totals.add(block)
            kept.append(thin_recording(block, step))
            count += len(kept[-1].t_s)
            while count > (WHOLE_TICKS if step == 1 else DRAWN_TICKS):
                step *= 2
                kept = [
                    thin_recording(part, 2) for part in kept
                ]  # joined first, it were twice as much
                count = sum(len(part.t_s) for part in kept)
    log = join_recordings(kept, contents.damage)
    return summarise_totals(totals, replace(block, damage=contents.damage)), log


def _has_sensors(config_text: str) -> bool:
    try:
        return parse_robot(config_text).force_sensor.any
    except BigantError:
        return True  # a log of another robot's software does not say that it has none


def summarise_totals(totals: RunTotals, last: Recording) -> Summary:
    """Compute the figures of a log that was read in blocks.

    Args:
        totals: What all blocks gave.
        last: The last block; it knows metadata and damage.
    """
    t_s, walking = totals.column("t_s"), totals.column("walking")
    walking_s = float(np.sum(walking[1:] * np.diff(t_s)))
    true, dead, estimate = totals.true_pose(), *map(totals.column, ("dead_reckoning", "estimate"))
    pose = true if totals.truth else dead
    distance, forward, turn = _path(pose[walking & np.isfinite(pose).all(axis=1)])
    late_ms = totals.column("lateness_s") * 1e3
    return Summary(
        gait=last.metadata.get("gait", "?"),
        hardware=last.metadata.get("hardware", "?"),
        duration_s=float(t_s[-1] - t_s[0]),
        walking_s=walking_s,
        cycles=_span(totals.column("gait_phase")[walking]),
        truth=totals.truth,
        distance_m=distance,
        forward_m=forward,
        mean_speed_m_s=forward / walking_s if walking_s > 0 else np.nan,
        yaw_rad=turn,
        slip_percentiles_m_s=_percentiles(
            totals.column("true_slip" if totals.truth else "predicted_slip")
        ),
        velocity_rmse=totals.rms("velocity_rmse"),
        velocity_rms=totals.rms("velocity_rms"),
        force_rmse_n=totals.rms("force_rmse_n"),
        drift_m=_drift(true, dead),
        walk_drift_m=_drift(true[walking], dead[walking]),
        estimate_rmse=totals.rms("estimate_rmse"),
        estimate_force_rmse_n=totals.rms("estimate_force_rmse_n"),
        estimate_drift_m=_drift(true, estimate),
        estimate_walk_drift_m=_drift(true[walking], estimate[walking]),
        estimate_sd=tuple(totals.estimate_sd.tolist()),
        estimate_health=_health(totals.column("estimate_health")),
        forces=bool(totals.column("forces").any()),
        sensors=_has_sensors(last.config_text),
        imu_share=tuple((totals.column("imu").sum(axis=0) / len(t_s)).tolist()),
        gyro_bias=tuple(totals.gyro_bias.tolist()),
        faults=tuple(totals.faults.most_common()),
        last_faults=_last_faults(totals),
        late_p50_ms=float(np.percentile(late_ms, 50)),
        late_p99_ms=float(np.percentile(late_ms, 99)),
        late_max_ms=float(late_ms.max()),
        missed=int(totals.column("missed").sum()),
        ticks=len(t_s),
        hottest_c=float(np.fmax.reduce(totals.column("hottest_c"))),
        stop_reason=StopReason(int(last.stop_reason[-1])).name.lower().replace("_", " "),
        stop_s=totals.stop_s,
        stop_cause=totals.stop_cause,
        damage=last.damage,
    )


def reason_of(words: str) -> StopReason:
    """Return the reason that a summary's ``stop_reason`` names."""
    return StopReason[words.upper().replace(" ", "_")]


def planar_pose(log: Recording) -> FloatArray:
    """Return x, y [m] and yaw [rad], (T, 3): the truth's if there is one, else dead reckoning's."""
    return true_pose(log) if log.has_truth else log.dead_reckoning_pose


def _path(pose: FloatArray) -> tuple[float, float, float]:
    """Distance, distance along the first heading, and turn between the ends of a path."""
    if len(pose) < 2:
        return np.nan, np.nan, np.nan
    ahead, aside, turn = seen_from(pose[0], pose[-1]).tolist()
    return float(np.hypot(ahead, aside)), ahead, turn


def _span(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known[-1] - known[0]) if len(known) else np.nan


def _percentiles(known: FloatArray) -> tuple[float, ...]:
    if len(known) == 0:
        return (np.nan,) * len(PERCENTILES)
    return tuple(np.percentile(known, PERCENTILES).tolist())


def _health(codes: FloatArray) -> tuple[float, ...]:
    ran = codes[codes >= 0]
    return tuple(float(np.mean(ran == code)) for code in range(3)) if len(ran) else (np.nan,) * 3


def _last_faults(totals: RunTotals) -> tuple[tuple[float, str], ...]:
    words = [
        (t_s, f"{kind} {source}: {detail}")
        for (kind, source), (t_s, detail) in totals.last_faults.items()
    ]
    return tuple(sorted(words, key=lambda one: -one[0]))


def _drift(true: FloatArray, own: FloatArray) -> float:
    known = np.flatnonzero(np.isfinite(true[:, 0]))
    if len(known) == 0:
        return np.nan
    first, last = known[0], known[-1]
    there = compose(aligning(true[first], own[first]), own[last])
    return float(np.hypot(*(true[last] - there)[:2]))
