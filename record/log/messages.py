"""The standard ROS 2 messages of a tick: what Foxglove, PlotJuggler, rosbags and ros2 bag understand.

Frames after REP-105: ``odom`` is where the run began, ``base_link`` the body, ``map`` the ground truth's
world. Forces are the ground's on the foot, body axes. JointState's effort stays empty: it is N m, and the
servos measure current, which is in ``/bigant/tick``.
"""

import struct
from functools import lru_cache
from math import cos, isfinite, sin

import numpy as np

from model.motion.se2 import quaternion_of
from model.values.arrays import FloatArray
from model.values.estimate import Estimate
from model.values.readings import BodyTruth, ImuRecord
from model.values.tick import DeadReckoning, Tick
from record.log.cdr import FLOATS, CdrWriter
from record.log.estimate_message import HEALTHS

BODY_FRAME, ODOM_FRAME, MAP_FRAME, IMU_FRAME = "base_link", "odom", "map", "imu"
UNKNOWN_COVARIANCE = np.zeros(36)
PLANAR = (0, 1, 5)  # x, y, yaw among ROS's six
NOT_ESTIMATED = 1e6
NO_MOMENT = bytes(24)
COVARIANCE_UNKNOWN, NOT_MEASURED = np.zeros(9), np.array([-1.0, *[0.0] * 8])
_PLANAR_PLACES = np.array([6 * row + column for row in PLANAR for column in PLANAR])
_ONLY_UNKNOWN = np.diag(np.full(6, NOT_ESTIMATED)).ravel()
OK, WARN, ERROR = 0, 1, 2


def _header(w: CdrWriter, unix_ns: int, frame: str) -> None:
    w.raw(_stamp(unix_ns, frame), 4)


@lru_cache(maxsize=8)
def _stamp(unix_ns: int, frame: str) -> bytes:
    """std_msgs/msg/Header; all messages of a tick have one of three."""
    seconds, nanoseconds = divmod(unix_ns, 1_000_000_000)
    name = frame.encode("utf-8") + b"\0"
    return struct.pack("<iII", seconds, nanoseconds, len(name)) + name


def joint_state(
    unix_ns: int, names: tuple[str, ...], angle_rad: FloatArray, rate_rad_s: FloatArray
) -> bytes:
    """sensor_msgs/msg/JointState."""
    w = CdrWriter()
    _header(w, unix_ns, BODY_FRAME)
    w.count(len(names))
    w.texts(*names)
    w.sequences(FLOATS, angle_rad, rate_rad_s)
    w.count(0)
    return w.done()


def wrench(unix_ns: int, force_n: FloatArray) -> bytes:
    """geometry_msgs/msg/WrenchStamped with a force at the foot and no moment."""
    w = CdrWriter()
    _header(w, unix_ns, BODY_FRAME)
    w.arrays(FLOATS, force_n)
    w.raw(NO_MOMENT, 8)
    return w.done()


def _odometry(unix_ns: int, frame: str, *arrays: FloatArray) -> bytes:
    """nav_msgs/msg/Odometry: position, quaternion, covariance; linear, angular velocity, covariance."""
    w = CdrWriter()
    _header(w, unix_ns, frame)
    w.texts(BODY_FRAME)
    w.arrays(FLOATS, *arrays)
    return w.done()


def planar_covariance(covariance: FloatArray) -> FloatArray:
    """A covariance of x, y, yaw as ROS has it: 6 x 6 of x, y, z and turns about them, (36,).

    Height, roll and pitch are not estimated: their variance says so.
    """
    flat: FloatArray = _ONLY_UNKNOWN.copy()
    flat[_PLANAR_PLACES] = covariance.ravel()
    return flat


def planar_odometry(unix_ns: int, pose: Estimate | DeadReckoning) -> bytes:
    """nav_msgs/msg/Odometry of the estimator, or of dead reckoning, whose covariance is left zero."""
    vx, vy, yaw_rate = pose.velocity_B
    pose_covariance = twist_covariance = UNKNOWN_COVARIANCE
    if isinstance(pose, Estimate):
        pose_covariance = planar_covariance(pose.pose_covariance)
        twist_covariance = planar_covariance(pose.twist_covariance)
    return _odometry(
        unix_ns, ODOM_FRAME, *_flat_pose(pose), pose_covariance,
        np.array([vx, vy, 0.0]), np.array([0.0, 0.0, yaw_rate]), twist_covariance,
    )  # fmt: skip


def truth_odometry(unix_ns: int, truth: BodyTruth) -> bytes:
    """nav_msgs/msg/Odometry of the ground truth."""
    return _odometry(
        unix_ns, MAP_FRAME, truth.position_W, truth.quaternion_xyzw, UNKNOWN_COVARIANCE,
        truth.velocity_B, truth.angular_velocity_B, UNKNOWN_COVARIANCE,
    )  # fmt: skip


def _flat_pose(pose: DeadReckoning | Estimate) -> tuple[FloatArray, FloatArray]:
    return np.array([*pose.position_m, 0.0]), quaternion_of(pose.yaw_rad)


def imu(unix_ns: int, reading: ImuRecord) -> bytes:
    """sensor_msgs/msg/Imu in the IMU's own axes; a covariance of -1 stands before what is not measured.

    Of the rates only that about z is; the orientation is roll and pitch with a yaw of 0.
    """
    known = isfinite(reading.roll_rad) and isfinite(reading.pitch_rad)
    turn = np.full(4, np.nan)
    if known:
        half_roll, half_pitch = reading.roll_rad / 2, reading.pitch_rad / 2
        (cr, sr), (cp, sp) = (cos(half_roll), sin(half_roll)), (cos(half_pitch), sin(half_pitch))
        turn = np.array([sr * cp, cr * sp, -sr * sp, cr * cp])
    w = CdrWriter()
    _header(w, unix_ns, IMU_FRAME)
    w.arrays(
        FLOATS, turn, COVARIANCE_UNKNOWN if known else NOT_MEASURED,
        np.array([np.nan, np.nan, reading.yaw_rate_rad_s]), COVARIANCE_UNKNOWN,
        np.full(3, np.nan), NOT_MEASURED,
    )  # fmt: skip
    return w.done()


def transform(unix_ns: int, pose: DeadReckoning | Estimate) -> bytes:
    """tf2_msgs/msg/TFMessage from ``odom`` to ``base_link``."""
    w = CdrWriter()
    w.count(1)
    _header(w, unix_ns, ODOM_FRAME)
    w.texts(BODY_FRAME)
    w.arrays(FLOATS, *_flat_pose(pose))
    return w.done()


def diagnostics(unix_ns: int, names: tuple[str, ...], tick: Tick) -> bytes:
    """diagnostic_msgs/msg/DiagnosticArray: one status a joint, one each for loop and estimator."""
    w = CdrWriter()
    _header(w, unix_ns, "")
    w.count(len(names) + 1 + (tick.estimate is not None))
    joints = tick.joints
    for at, name in enumerate(names):
        mine = [f"{f.kind.name}: {f.detail}" for f in tick.faults if f.source == name]
        level = OK if joints.valid[at] and not mine else ERROR
        values = (
            ("temperature_c", f"{joints.temperature_c[at]:.0f}"),
            ("voltage_v", f"{joints.voltage_v[at]:.1f}"),
            ("current_a", f"{joints.current_a[at]:.3f}"),
        )
        _status(w, level, f"servo {name}", "; ".join(mine) or "ok", values)
    others = [f"{f.source} {f.kind.name}: {f.detail}" for f in tick.faults if f.source not in names]
    timing = (
        ("mode", tick.mode.name),
        ("stop_reason", tick.stop_reason.name),
        ("lateness_ms", f"{tick.inputs.timing.lateness_ns * 1e-6:.3f}"),
        ("missed", str(tick.inputs.timing.missed)),
    )
    _status(w, WARN if others else OK, "controller", "; ".join(others) or "ok", timing)
    if tick.estimate is not None:
        _estimator_status(w, tick.estimate)
    return w.done()


def _estimator_status(w: CdrWriter, estimate: Estimate) -> None:
    level = (OK, WARN, ERROR)[HEALTHS.index(estimate.health)]
    values = (
        ("rejects", str(estimate.rejects)),
        ("nis", f"{estimate.nis:.2f}"),
        ("nis_dof", str(estimate.nis_dof)),
        ("force_age_s", f"{estimate.force_age_s:.3f}"),
        ("holding", str(estimate.holding).lower()),
    )
    _status(w, level, "estimator", estimate.reason or estimate.health.value, values)


def _status(
    w: CdrWriter, level: int, name: str, message: str, values: tuple[tuple[str, str], ...]
) -> None:
    w.record("B", level)
    w.texts(name, message, "bigant")
    w.count(len(values))
    for pair in values:
        w.texts(*pair)
