"""Odometry as files: TUM trajectories (evo), nav_msgs/Odometry in MCAP, a picture, a page."""

import math
from collections.abc import Sequence
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
from robot.console.table import formed, number_text
from robot.odometry.compare import OdometryComparison
from robot.odometry.figure import drawing
from robot.odometry.table import (
    NOTES,
    Figures,
    consistency_rows,
    displacement_and_sd,
    error_columns,
    health_rows,
    leg_columns,
    short_walk,
    walking_words,
)
from robot.odometry.track import Track
from robot.report.page import Section, report_page
from robot.report.pictures import pictures
from robot.report.run_date import date_words

KIND = "nav_msgs/msg/Odometry"


def write(comparison: OdometryComparison, log: Recording, path: Path, out: Path) -> None:
    """Write a comparison over the log of ``path`` to a .tum, .mcap, .png or .html file.

    A trajectory is that of the walking part in the estimator's own frame, smoothed if states were kept;
    the truth goes beside it, begun at the same pose.

    Raises:
        RecordError: It cannot be written.
    """
    run = comparison.track
    if out.suffix == ".html":
        write_text(out, odometry_page(comparison, path, date_words(log.metadata)))
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


def odometry_page(comparison: OdometryComparison, log: Path, date: str) -> str:
    """Return the page of a log that was recorded on a ``date``, in words."""
    (ahead_m, aside_m, yaw_rad), sd = displacement_and_sd(comparison)
    rows = [
        ("walking part", walking_words(comparison)),
        ("ahead", f"{number_text(1e3 * ahead_m, 1)} mm +- {1e3 * sd[0]:.1f}"),
        ("aside", f"{number_text(1e3 * aside_m, 1)} mm +- {1e3 * sd[1]:.1f}"),
        ("turned", f"{number_text(math.degrees(yaw_rad), 2)} deg +- {math.degrees(sd[2]):.2f}"),
        *health_rows(comparison),
        *(consistency_rows(comparison) if comparison.errors else []),
        *(("RPE", words) for words in short_walk(comparison)),
    ]
    judged = "judged against the truth in the log" if comparison.errors else "no truth in this log"
    methods = [one.name for one in comparison.errors]
    title = "Each leg, as estimated at the end; RMSE of its force"
    return report_page(
        f"{log.name}: odometry",
        f"{log}, {date}; {judged}; the walking part only",
        [
            Section("", rows),
            _grid("Errors of each method", "method", methods, error_columns(comparison.errors)),
            _grid(title, "leg", comparison.names, leg_columns(comparison)),
            Section("What the words mean", NOTES),
            *pictures({"Path, error, velocity, friction": drawing(comparison)}),
        ],
    )


def _grid(title: str, label: str, names: Sequence[str], columns: Sequence[Figures]) -> Section:
    heads = [f"{one.name}, {one.unit}" if one.unit else one.name for one in columns]
    texts = ([formed(value, one.form) for value in one.values] for one in columns)
    rows = list(zip(names, *texts, strict=True))
    return Section(title, rows, (label, *heads), range(1, len(heads) + 1))
