"""Odometry as files that others read: TUM trajectories (evo) and nav_msgs/Odometry in MCAP."""

from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from model.errors import RecordError
from model.values.arrays import FloatArray
from record.log.definitions import DEFINITIONS
from record.log.messages import planar_odometry
from robot.odometry.track import OdometryTrack

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
            writer.start(profile="ros2", library="bigant odom")
            schema = writer.register_schema(KIND, "ros2msg", DEFINITIONS[KIND].encode("utf-8"))
            channel = writer.register_channel("/odom", "cdr", schema)
            for i, estimate in enumerate(run.estimates):
                data = planar_odometry(estimate.t_ns, estimate)
                writer.add_message(channel, estimate.t_ns, data, estimate.t_ns, i)
            writer.finish()  # type: ignore[no-untyped-call]
    except OSError as error:
        raise _refused(path, error) from error


def _refused(path: Path, error: OSError) -> RecordError:
    return RecordError(f"{path} cannot be written: {error.strerror}; choose another --out")
