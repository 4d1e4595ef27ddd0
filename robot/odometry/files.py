"""Odometry as files: TUM trajectories (evo), nav_msgs/Odometry in MCAP, a picture, a page."""

from pathlib import Path

from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from model.estimator.smoother import smooth
from model.values.arrays import FloatArray
from record.log.definitions import DEFINITIONS
from record.log.messages import planar_odometry
from record.log.recording import Recording
from record.log.tum import TumFile
from record.whole_file import whole_file, write_text
from robot.odometry.compare import OdometryComparison
from robot.odometry.figure import drawing
from robot.odometry.page import odometry_page
from robot.odometry.track import Track
from robot.report.run_date import date_words

KIND = "nav_msgs/msg/Odometry"


def write(
    comparison: OdometryComparison, log: Recording, path: Path, out: Path, option: str = "--out"
) -> None:
    """Write a comparison over the log of ``path`` to a .tum, .mcap, .png or .html file of an option.

    A trajectory is that of the walking part in the estimator's own frame, smoothed if states were kept;
    the ground truth goes into a second file, from the same pose on.

    Raises:
        RecordError: It cannot be written.
    """
    run = comparison.track
    if out.suffix == ".html":
        write_text(out, odometry_page(comparison, path, date_words(log.metadata)), option)
    elif out.suffix == ".tum":
        _write_tum(out, run, smooth(run.states)[0][:, :3] if run.states else run.pose)
        if comparison.truth is not None:
            _write_tum(out.with_suffix(".truth.tum"), run, comparison.truth.pose)
    else:
        with whole_file(out) as part:
            if out.suffix == ".mcap":
                write_mcap(part, run)
            else:
                drawing(comparison).savefig(part, dpi=120)


def _write_tum(path: Path, run: Track, pose: FloatArray) -> None:
    """Write a pose, x, y [m], yaw [rad], at each tick, (T, 3)."""
    with TumFile(path) as file:
        for unix_ns, row in zip(run.unix_ns.tolist(), pose, strict=True):
            file.write(unix_ns, row)


def write_mcap(path: Path, run: Track) -> None:
    """Write the estimator's odometry with its covariances, topic ``/odom``.

    Raises:
        OSError: It cannot be written.
    """
    with path.open("wb") as file:
        writer = McapWriter(file, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="bigant odom")
        schema = writer.register_schema(KIND, "ros2msg", DEFINITIONS[KIND].encode("utf-8"))
        channel = writer.register_channel("/odom", "cdr", schema)
        for unix_ns, estimate in zip(run.unix_ns.tolist(), run.estimates, strict=True):
            writer.add_message(channel, unix_ns, planar_odometry(unix_ns, estimate), unix_ns)
        writer.finish()  # type: ignore[no-untyped-call]
