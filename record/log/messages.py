"""The standard ROS 2 messages of a tick: what Foxglove, PlotJuggler, rosbags and ros2 bag understand.

Frames after REP-105: ``odom`` is where the run began, ``base_link`` the body, ``map`` the ground truth's
world. Forces are the ground's on the foot, body axes. JointState's effort stays empty: it is N m, and the
servos measure current, which is in ``/bigant/tick``.
"""

import struct
from functools import cache, lru_cache
from math import cos, isfinite, sin

import numpy as np

from model.values.arrays import FloatArray
from model.values.estimate import Estimate
from model.values.readings import BodyTruth, ImuRecord
from model.values.tick import DeadReckoning, Tick
from record.log.cdr import FLOATS, HEADER, CdrWriter
from record.log.estimate_message import HEALTHS

BODY_FRAME, ODOM_FRAME, MAP_FRAME, IMU_FRAME = "base_link", "odom", "map", "imu"
UNKNOWN_COVARIANCE = np.zeros(36)
NOT_ESTIMATED = 1e6
NO_MOMENT = bytes(24)
COVARIANCE_UNKNOWN, NOT_MEASURED = np.zeros(9), np.array([-1.0, *[0.0] * 8])
NO_COVARIANCE = UNKNOWN_COVARIANCE.tobytes()
BEHIND_TIME = len(HEADER) + 8  # in a message that begins with its header
ONE = struct.pack("<I", 1)  # a sequence of one
_POSE, _TWIST, _COVARIANCE = struct.Struct("<7d"), struct.Struct("<6d"), struct.Struct("<36d")
OK, WARN, ERROR = 0, 1, 2


def _header(w: CdrWriter, unix_ns: int, frame: str) -> None:
    """std_msgs/msg/Header."""
    name = frame.encode("utf-8") + b"\0"
    w.raw(_time(unix_ns) + struct.pack("<I", len(name)) + name, 4)


@lru_cache(maxsize=4)
def _time(unix_ns: int) -> bytes:
    """builtin_interfaces/msg/Time; all messages of a tick have the same."""
    return struct.pack("<iI", *divmod(unix_ns, 1_000_000_000))


def _as_bytes(numbers: FloatArray) -> bytes:
    return numbers.tobytes() if numbers.dtype is FLOATS else numbers.astype(FLOATS).tobytes()


def joint_state(
    unix_ns: int, names: tuple[str, ...], angle_rad: FloatArray, rate_rad_s: FloatArray
) -> bytes:
    """sensor_msgs/msg/JointState."""
    angles, rates = _as_bytes(angle_rad), _as_bytes(rate_rad_s)
    before, between, behind = _around_joints(names, len(angles) >> 3, len(rates) >> 3)
    return b"".join((HEADER, _time(unix_ns), before, angles, between, rates, behind))


@lru_cache(maxsize=8)
def _around_joints(names: tuple[str, ...], angles: int, rates: int) -> tuple[bytes, bytes, bytes]:
    """The bytes before, between and behind so many angles and rates; the same in every tick."""
    w = CdrWriter()
    _header(w, 0, BODY_FRAME)
    w.raw(_names(names), 4)
    w.count(angles)
    w.raw(b"", 8 if angles else 4)
    before = w.done()
    w.raw(bytes(8 * angles), 4)
    w.count(rates)
    w.raw(b"", 8 if rates else 4)
    between = w.done()[len(before) + 8 * angles :]
    w.raw(bytes(8 * rates), 4)
    w.count(0)
    behind = w.done()[len(before) + 8 * angles + len(between) + 8 * rates :]
    return before[BEHIND_TIME:], between, behind


@lru_cache(maxsize=8)
def _names(names: tuple[str, ...]) -> bytes:
    """A sequence of strings; a robot's joints have the same names in every tick."""
    w = CdrWriter()
    w.count(len(names))
    w.texts(*names)
    return w.done()[len(HEADER) :]


@cache
def _between(frame: str, child: str | None = None) -> bytes:
    """The bytes between a message's time and its numbers: the rest of its header, a child frame."""
    w = CdrWriter()
    _header(w, 0, frame)
    if child is not None:
        w.texts(child)
    w.raw(b"", 8)
    return w.done()[BEHIND_TIME:]


def wrenches(unix_ns: int, force_n: FloatArray) -> list[bytes]:
    """geometry_msgs/msg/WrenchStamped of each foot: a force there, (N, 3), and no moment."""
    head = HEADER + _time(unix_ns) + _between(BODY_FRAME)
    forces = np.ascontiguousarray(force_n, FLOATS).tobytes()
    size = len(NO_MOMENT)
    return [head + forces[at : at + size] + NO_MOMENT for at in range(0, len(forces), size)]


def _covariance(of_plane: FloatArray) -> bytes:
    """A covariance of x, y, yaw as ROS has it: 6 x 6 of x, y, z and turns about them.

    Height, roll and pitch are not estimated: their variance says so.
    """
    (xx, xy, xt), (yx, yy, yt), (tx, ty, tt) = of_plane.tolist()
    return _COVARIANCE.pack(
        xx, xy, 0.0, 0.0, 0.0, xt,
        yx, yy, 0.0, 0.0, 0.0, yt,
        0.0, 0.0, NOT_ESTIMATED, 0.0, 0.0, 0.0,
        0.0, 0.0, 0.0, NOT_ESTIMATED, 0.0, 0.0,
        0.0, 0.0, 0.0, 0.0, NOT_ESTIMATED, 0.0,
        tx, ty, 0.0, 0.0, 0.0, tt,
    )  # fmt: skip


def planar_odometry(unix_ns: int, pose: Estimate | DeadReckoning) -> bytes:
    """nav_msgs/msg/Odometry of the estimator, or of dead reckoning, whose covariance is left zero."""
    return planar_pose(unix_ns, pose)[0]


def planar_pose(unix_ns: int, pose: Estimate | DeadReckoning) -> tuple[bytes, bytes]:
    """Return a pose of the estimator, or of dead reckoning, as the two messages that say it.

    Returns:
        nav_msgs/msg/Odometry, whose covariance is left zero for dead reckoning, and tf2_msgs/msg/TFMessage
        from ``odom`` to ``base_link``.
    """
    (x, y), (vx, vy, yaw_rate) = pose.position_m.tolist(), pose.velocity_B.tolist()
    half = pose.yaw_rad / 2
    place = _POSE.pack(x, y, 0.0, 0.0, 0.0, np.sin(half), np.cos(half))  # a turn about z
    of_pose = of_twist = NO_COVARIANCE
    if isinstance(pose, Estimate):
        of_pose, of_twist = _covariance(pose.pose_covariance), _covariance(pose.twist_covariance)
    turn = _TWIST.pack(vx, vy, 0.0, 0.0, 0.0, yaw_rate)
    time, between = _time(unix_ns), _between(ODOM_FRAME, BODY_FRAME)
    odometry = b"".join((HEADER, time, between, place, of_pose, turn, of_twist))
    return odometry, b"".join((HEADER, ONE, time, _behind_one(), place))


@cache
def _behind_one() -> bytes:
    """The bytes between the time and the numbers of the one transform of tf2_msgs/msg/TFMessage."""
    w = CdrWriter()
    w.raw(ONE, 4)
    _header(w, 0, ODOM_FRAME)
    w.texts(BODY_FRAME)
    w.raw(b"", 8)
    return w.done()[BEHIND_TIME + len(ONE) :]


def truth_odometry(unix_ns: int, truth: BodyTruth) -> bytes:
    """nav_msgs/msg/Odometry of the ground truth."""
    place, turn = _as_bytes(truth.position_W), _as_bytes(truth.quaternion_xyzw)
    twist = _as_bytes(truth.velocity_B), _as_bytes(truth.angular_velocity_B)
    head = HEADER, _time(unix_ns), _between(MAP_FRAME, BODY_FRAME)
    return b"".join((*head, place, turn, NO_COVARIANCE, *twist, NO_COVARIANCE))


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
