"""A trial as a log, so that everything that reads logs reads it: shafts, commands, forces, body.

What the tick has no place for is named by ``left_out``. The model is not run: its outputs are invalid. An
estimator that the caller brings is stepped through the ticks; without one they hold no estimate.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from model.errors import RecordError
from model.motion.se2 import heading_quaternion
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.contact import no_contact
from model.values.estimate import Estimate
from model.values.faults import StopReason
from model.values.legs import FootForces, JointCommand, JointState, no_feet
from model.values.readings import BodyTruth, ImuRecord
from model.values.tick import DeadReckoning, Inputs, Intent, LoopTiming, Mode, Request, Tick
from record.log.header import IMPORTED, RunHeader
from record.log.writer import LogWriter
from record.trial.header import LEGGED
from record.trial.header_file import header_text
from record.trial.trial import Trial
from record.whole_file import whole_file

NOT_RUN = "imported data: the model was not run"
# Seconds as large as this are UNIX time (1973 and later), not time since a beginning.
UNIX_TIME_S = 1e8
TELL_TICKS = 500


def write_trial_log(
    trial: Trial,
    path: Path,
    tell: Callable[[float], None] = lambda _: None,
    estimate: Callable[[Tick], Estimate] | None = None,
) -> None:
    """Write a trial as a log.

    Args:
        trial: The trial.
        path: The log.
        tell: Told now and then which share has been written.
        estimate: Gets every tick in order, and returns what the log is to hold as its estimate.

    Raises:
        RecordError: It cannot be written.
    """
    t_ns = _nanoseconds(trial.time_s)
    if np.any(np.diff(t_ns) <= 0):
        raise RecordError("a log's clock counts nanoseconds; two samples lie closer than that")
    # the log's clock begins at 0 s of the trial, and must not be negative
    start_ns = int(t_ns[0]) if trial.time_s[0] > UNIX_TIME_S else max(0, -int(t_ns[0]))
    offset_ns = 0 if trial.time_s[0] > UNIX_TIME_S else start_ns
    header = trial.header
    phases = gait_phase(trial)
    metadata = RunHeader(
        robot=Path(header.robot_file).stem,
        hardware=IMPORTED,
        gait=header.gait,
        frequency_hz=header.frequency_hz,
        trial=header_text(header),
    ).metadata()
    with whole_file(path) as part:
        writer = LogWriter(
            part,
            names=header.names.legs,
            joints=header.joints,
            config_text=header.robot_text,
            metadata=metadata,
            start_ns=start_ns,
            start_unix_ns=start_ns,
        )
        for index in range(len(t_ns)):
            if index % TELL_TICKS == 0:
                tell(index / len(t_ns))
            now_ns = int(t_ns[index]) + offset_ns
            tick = _tick(trial, index, now_ns, float(phases[index]))
            writer.write(tick if estimate is None else replace(tick, estimate=estimate(tick)))
        writer.close()
        if writer.error is not None:
            raise writer.error


def _nanoseconds(time_s: FloatArray) -> IntArray:
    """Return whole nanoseconds; times 1e9 at once would lose hundreds of them on UNIX time."""
    whole = np.floor(time_s)
    rest_ns: IntArray = np.rint((time_s - whole) * 1e9).astype(np.int64)
    return whole.astype(np.int64) * 10**9 + rest_ns


def left_out(trial: Trial) -> tuple[str, ...]:
    """Return the columns that a log has no place for; write those to a .parquet or .csv."""
    lost = [c.name for c in trial.columns() if c.name.startswith("torque_")]
    pose = np.isfinite(np.hstack([trial.body_position_m, trial.body_angles_rad])).all(axis=1)
    if (np.isfinite(trial.foot_m).any(axis=(1, 2)) & ~pose).any():
        lost.append("foot points where the body's pose is not known")
    tilt, yaw = np.isfinite(trial.body_angles_rad[:, :2]), np.isfinite(trial.body_angles_rad[:, 2])
    if (tilt.any(axis=1) & ~(tilt.all(axis=1) & yaw)).any():
        lost.append("roll and pitch where not all three angles are known")
    return tuple(lost)


def _tick(trial: Trial, at: int, t_ns: int, phase: float) -> Tick:
    nothing = readonly(np.full(len(trial.joints), np.nan))
    walking = trial.header.kind == LEGGED
    command = JointCommand(t_ns, trial.command_rad[at], nothing,
                           torque=bool(np.isfinite(trial.command_rad[at]).any()))  # fmt: skip
    request = Request(Intent.WALK if walking else Intent.LISTEN, trial.header.gait,
                      trial.header.frequency_hz, 0.0, StopReason.NONE)  # fmt: skip
    return Tick(
        t_ns=t_ns,
        index=at,
        mode=Mode.WALK if walking else Mode.IDLE,
        stop_reason=StopReason.NONE,
        inputs=Inputs(
            None, (), request, LoopTiming(t_ns, 0, 0, 0), _truth(trial, at, t_ns), (),
            imu=_imu(trial.imu[at], t_ns),
        ),
        joints=JointState(
            t_ns, trial.shaft_rad[at], trial.shaft_rad_s[at], trial.current_a[at], trial.pwm[at],
            trial.voltage_v[at], trial.temperature_c[at], np.isfinite(trial.shaft_rad[at]),
        ),
        forces=FootForces(t_ns, trial.force_n[at], np.isfinite(trial.force_n[at]).all(axis=1)),
        gait_phase=phase,
        wished=command,
        sent=command,
        feet=no_feet(len(trial.legs)),
        contact=no_contact(len(trial.legs), NOT_RUN),
        dead_reckoning=DeadReckoning(
            t_ns, np.full(2, np.nan), np.nan, np.full(3, np.nan), valid=False
        ),
        faults=(),
    )  # fmt: skip


def _imu(values: FloatArray, t_ns: int) -> tuple[ImuRecord, ...]:
    """Return the reading of a sample; none where nothing of it is known."""
    return (ImuRecord(t_ns, *values.tolist()),) if np.isfinite(values).any() else ()


def gait_phase(trial: Trial) -> FloatArray:
    """Return the cycles since the beginning, (T,), of legs that all turn; NaN where that is not known.

    A cycle is a turn of every shaft. Legs that swing to and fro have the frequency of the header, if any.
    """
    for angles in (trial.shaft_rad, trial.command_rad):
        cycles = angles / (2 * np.pi)
        if not np.isfinite(cycles).all(axis=0).any():
            continue
        cycles = cycles[:, np.isfinite(cycles).all(axis=0)]
        turned = cycles[-1] - cycles[0]
        # legs of one gait are less than a cycle apart all the time
        if abs(turned.mean()) > 0.1 and np.abs(turned - turned.mean()).max() < 1.0:
            phase: FloatArray = (cycles - cycles[0]).mean(axis=1)
            return phase
    return np.asarray((trial.time_s - trial.time_s[0]) * trial.header.frequency_hz)


def _truth(trial: Trial, at: int, t_ns: int) -> BodyTruth | None:
    """Return what is measured of the pose as ground truth; velocities and contact were not measured."""
    position, (roll, pitch, yaw) = trial.body_position_m[at], trial.body_angles_rad[at]
    if not np.isfinite([*position, yaw]).any():
        return None
    legs = len(trial.legs)
    feet: FloatArray = np.full((legs, 3), np.nan)
    if np.isfinite([roll, pitch, yaw]).all():
        turn = Rotation.from_euler("ZYX", [yaw, pitch, roll])
        quaternion = turn.as_quat()
        feet = position + trial.foot_m[at] @ turn.as_matrix().T
    else:
        quaternion = heading_quaternion(yaw)  # NaN throughout without a yaw
    return BodyTruth(
        t_ns=t_ns,
        position_W=position,
        quaternion_xyzw=quaternion,
        velocity_B=np.full(3, np.nan),
        angular_velocity_B=np.full(3, np.nan),
        foot_position_W=feet,
        foot_velocity_W=np.full((legs, 3), np.nan),
        foot_force_B=np.full((legs, 3), np.nan),
        contact=np.zeros(legs, dtype=bool),
    )
