"""Odometry as files: TUM trajectories (evo), nav_msgs/Odometry in MCAP, a picture, a page."""

from pathlib import Path

from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from model.errors import RecordError
from model.estimator.smoother import smooth
from model.values.arrays import FloatArray
from record.log.definitions import DEFINITIONS
from record.log.messages import planar_odometry
from record.log.recording import Recording
from record.log.tum import TumFile
from record.whole_file import write_text
from robot.odometry.compare import Comparison
from robot.odometry.figure import drawing
from robot.odometry.page import odometry_page
from robot.odometry.track import Track
from robot.report.run_date import date_words

KIND = "nav_msgs/msg/Odometry"


def write(found: Comparison, log: Recording, name: Path, out: Path, *, everything: bool) -> None:
    """Write a comparison to a file of the kind that its suffix names.

    A trajectory is that of the walking part in the estimator's own frame, smoothed if states were kept;
    the truth goes beside it, begun at the same pose.

    Args:
        found: What was found.
        log: The log.
        name: Its file.
        out: A .tum, .mcap, .png or .html file.
        everything: Whether the other ways are shown beside the estimator.

    Raises:
        RecordError: It cannot be written.
    """
    run = found.track
    if out.suffix == ".html":
        page = odometry_page(
            found, log.names, name, date_words(log.metadata), everything=everything
        )
        write_text(out, page)
    elif out.suffix == ".tum":
        write_tum(out, run, smooth(run.states)[0][:, :3] if run.states else run.pose)
        if found.truth is not None:
            write_tum(out.with_suffix(".truth.tum"), run, found.truth[0])
    else:
        try:
            if out.suffix == ".mcap":
                write_mcap(out, run)
            else:
                drawing(found, log.names, everything=everything).savefig(out, dpi=120)
        except OSError as error:
            raise RecordError(
                f"{out} cannot be written: {error.strerror}; choose another --out"
            ) from error


def write_tum(path: Path, run: Track, pose: FloatArray) -> None:
    """Write a pose, x, y [m], yaw [rad], at each tick, (T, 3).

    Raises:
        RecordError: It cannot be written.
    """
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
