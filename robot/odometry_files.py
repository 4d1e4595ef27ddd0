"""Odometry as files that others read: TUM trajectories (evo) and nav_msgs/Odometry in MCAP."""

from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from model.errors import RecordError
from model.signals import FloatArray
from record.cdr import CdrWriter
from record.definitions import DEFINITIONS
from robot.odometry_track import OdometryTrack

KIND = "nav_msgs/msg/Odometry"
# Rows and columns of x, y and yaw in ROS' six by six; what the plane does not know is 0.
PLANAR = np.array([0, 1, 5])


def write_tum(path: Path, t_s: FloatArray, pose: FloatArray) -> None:
    """Write "time x y z qx qy qz qw" lines, in s and m; z, roll and pitch are 0.

    Args:
        path: File.
        t_s: (T,).
        pose: x, y, yaw, (T, 3).

    Raises:
        RecordError: It cannot be written.
    """
    half = pose[:, 2] / 2
    zero = np.zeros(len(pose))
    rows = np.column_stack([t_s, pose[:, :2], zero, zero, zero, np.sin(half), np.cos(half)])
    try:
        np.savetxt(path, rows, fmt="%.9f")
    except OSError as error:
        raise _refused(path, error) from error


def write_mcap(path: Path, run: OdometryTrack) -> None:
    """Write the estimator's odometry with its covariances, topic ``/odom``.

    Raises:
        RecordError: It cannot be written.
    """
    try:
        with path.open("wb") as file:
            writer = McapWriter(file, compression=CompressionType.ZSTD)
            writer.start(profile="ros2", library="bigant")
            schema = writer.register_schema(KIND, "ros2msg", DEFINITIONS[KIND].encode("utf-8"))
            channel = writer.register_channel("/odom", "cdr", schema)
            for i, estimate in enumerate(run.estimates):
                data = odometry_message(run, i)
                writer.add_message(channel, estimate.t_ns, data, estimate.t_ns, i)
            writer.finish()  # type: ignore[no-untyped-call]
    except OSError as error:
        raise _refused(path, error) from error


def odometry_message(run: OdometryTrack, tick: int) -> bytes:
    """nav_msgs/msg/Odometry of a tick, covariances row by row."""
    w = CdrWriter()
    seconds, nanoseconds = divmod(run.estimates[tick].t_ns, 1_000_000_000)
    w.i32(seconds)
    w.u32(nanoseconds)
    w.text("odom")
    w.text("base_link")
    x, y, yaw = run.pose[tick].tolist()
    w.f64_array(np.array([x, y, 0.0, 0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)]))
    w.f64_array(_six(run.pose_covariance[tick]))
    vx, vy, rate = run.velocity_B[tick].tolist()
    w.f64_array(np.array([vx, vy, 0.0, 0.0, 0.0, rate]))
    w.f64_array(_six(run.twist_covariance[tick]))
    return w.done()


def _six(planar: FloatArray) -> FloatArray:
    full = np.zeros((6, 6))
    full[np.ix_(PLANAR, PLANAR)] = planar
    return full.ravel()


def _refused(path: Path, error: OSError) -> RecordError:
    return RecordError(f"{path} cannot be written: {error.strerror}; choose another --out")
