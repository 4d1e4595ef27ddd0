"""Requests of the commands of one word about what was recorded: ``bigant show`` and others."""

import os
from pathlib import Path

from robot.console.arguments import (
    EITHER,
    argument,
    as_json,
    between,
    flag,
    hardware_port,
    option,
    positive,
    random_seed,
    request,
)
from robot.requests.single import FROM_ROBOT_FILE, UNIT_OR_NONE

TUNE = Path("tune")
DEFAULT_PORT = 8765
DEFAULT_RATE_HZ = 25.0
RERUN_SUFFIX = ".rrd"
CORES = min(os.cpu_count() or 1, 4)
AGAIN, WALKING = "with --drive", "while it walks"  # headings in the help


@request("view.show:show", writes=True)
class ShowRequest:
    """``bigant show``: what happened in a log, as a table and as pictures.

    Print a summary of a log (distance, speed, slip, faults, loop) and write a page with trajectory, body
    velocity and foot forces, predicted against measured. --video also draws the walk in 3-D, with the
    forces on the feet and where they slip; no display or graphics card is needed.
    """

    path: Path = argument("LOG")
    out: Path | None = option(".html or .png (default: next to the log, .html)", "FILE")
    json: bool = as_json("the summary as JSON, no picture")
    video: Path | None = option("also a video: .mp4 (needs bigant[video]) or .gif", "FILE")
    speed: float | None = option(
        "of the video, times real time (default: 1)", "X", type=between(0.01, 1000)
    )
    fps: float | None = option(
        "pictures a second of the video (default: 25; .gif 12.5)", "R", type=between(1, 60)
    )


@request("day.command:report_day", writes=True)
class ReportRequest:
    """``bigant report``: one page of a day's runs, for the lab's meeting.

    A row for each log: gait, distance, slip, odometry, hottest servo, how it ended, and faults; the figures
    over the runs; links to the pages of the runs. With --reference, earlier runs of the same robot, the
    day's runs are diagnosed together: what is new since then? A log that cannot be read is listed with the
    reason. Exit code 1: none could be read.
    """

    paths: tuple[Path, ...] = argument("LOG|FOLDER", nargs="+")
    reference: tuple[Path, ...] = option(
        "earlier runs to compare with, for example yesterday's; at least three say more",
        "LOG|TRIAL|FOLDER",
        nargs="+",
        default=(),
    )
    out: Path | None = option("the page (default: report.html next to the runs)", "FILE.html")
    pages: bool = flag("write the page of each run that has none (bigant show)")
    json: bool = as_json("the rows as JSON; a page only with --out")
    jobs: int = option(
        "processes of the diagnosis (default: one a core, up to 4)",
        "N",
        default=CORES,
        type=between(1, whole=True),
    )


@request("odometry.command:odom", writes=True)
class OdomRequest:
    """``bigant odom``: odometry and foot forces from a log, compared with ground truth if available.

    Runs the estimator over a log, with only what the loop knew at each tick. 'odom tune LOG...' estimates
    its noise from logs instead. --live follows the log of a running drive, or reads a robot without ever
    moving it.
    """

    logs: tuple[Path, ...] = argument("[tune] LOG", nargs="*", default=())
    compare: bool = flag("also: open-loop model, strides, rigid stance and ground truth")
    law: str | None = option(
        "friction law of the process (default: the robot file's)", choices=("coulomb", "viscous")
    )
    no_sway: bool = flag("ignore the body's motion from its tilt")
    no_forces: bool = flag("ignore the force unit")
    no_imu: bool = flag("ignore the IMU")
    robot: Path | None = option("robot file to use (default: the one in the log)", "FILE")
    fitted: Path | None = option(
        "with --compare: fit open loop and stride to this walk with ground truth", "LOG"
    )
    smooth: bool = flag("write the trajectory smoothed over the whole walk")
    out: Path | None = option(
        ".tum, .mcap, .png or .html; tune: .toml, the robot file with what was found", "FILE"
    )
    html: Path | None = option(
        "the page: path, error bars, sensors, health, rejections, forces", "FILE"
    )
    live: bool = flag(
        "follow LOG (default: newest in runs/) while it is written, or --hardware", group=WALKING
    )
    hardware: str | None = option(
        "read servos and forces here; torque is never switched on", "virtual|PORT", group=WALKING
    )
    force_unit: str | None = option(FROM_ROBOT_FILE, UNIT_OR_NONE, group=WALKING)
    duration: float | None = option("stop after so many seconds", "S", type=positive, group=WALKING)
    json: bool = as_json("the figures as JSON; with --live a line of it a second")

    @property
    def tunes(self) -> bool:
        """Whether noise is to be found from logs."""
        return not self.live and self.logs[:1] == (TUNE,)


@request("replay.command:replay", writes=True)
class ReplayRequest:
    """``bigant replay``: run a recorded run again, as a test.

    The recorded inputs go through today's controller, and every stage's output is compared with the
    recorded one. With --bus the recorded bytes of both devices go through today's drivers, which must send
    the same bytes. With --drive the robot does the same run again, and the new measurements are compared
    with the old. For imported data, which no controller made, the estimator is replayed. Exit code
    0: equal (--drive: driven); 1: not.
    """

    path: Path = argument("LOG")
    tolerance: float = option(
        "factor on all tolerances (1); 0 requires the same bits",
        "X",
        default=1.0,
        type=between(0),
    )
    robot: Path | None = option("try this robot file instead of the log's", "FILE")
    gait: str | None = option(
        "for a run with the gait of a Python file: that file, or 'recorded' to run the text in the log",
        "FILE.py|recorded",
    )
    json: bool = as_json()
    bus: bool = flag(
        "replay the recorded bytes through the drivers (log: bigant drive --record-bytes)",
        group=EITHER,
    )
    drive: bool = flag("do the run again on a robot", group=EITHER)
    hardware: str = hardware_port(group=AGAIN)
    armed: bool = flag("allow torque on real hardware", group=AGAIN)
    force_unit: str | None = option(FROM_ROBOT_FILE, UNIT_OR_NONE, group=AGAIN)
    virtual_time: bool = flag("as fast as the computer goes", group=AGAIN)
    seed: int = random_seed(group=AGAIN)
    log: Path | None = option("the new log (default: runs/...)", "FILE", group=AGAIN)
    out: Path | None = option(
        "page with the pictures (default: next to the new log)", "FILE", group=AGAIN
    )


@request("gap_report.imports:bring_in", writes=True)
class ImportRequest:
    """``bigant import``: turn your measured data into logs or trials, and check it.

    Reads the trial table (.parquet or .csv with NAME.toml next to it), any other .csv, .parquet or .npz
    with a map of its columns, and ROS 2 bags. The map is your own, or one that comes with the program
    (--maps lists them). Reports what is absent, out of order, repeated, out of range, jumping, stuck,
    unsigned or empty, which data faults the diagnosis would find, and what the run can be used for.
    Nothing is dropped without being listed.
    """

    paths: tuple[Path, ...] = argument(
        "TABLE",
        ".parquet, .csv, .npz, NAME.toml, or a ROS 2 bag; several with --out FOLDER",
        nargs="*",
        default=(),
    )
    map: str | None = option(
        "which column means what", "NAME|MAP.toml", flags=("--map", "--columns")
    )
    topics: str | None = option(
        "of a bag, where the map does not name them and several could be meant: joints=, commands=, pose=, "
        "force_LEG=",
        "WHAT=TOPIC,...",
    )
    maps: bool = flag("list the maps that come with the program")
    out: Path | None = option(
        "log (.mcap) or trial (.parquet, .csv) to write, or a folder for a trial (.parquet) of each table; "
        "without it, only the report",
        "FILE|FOLDER",
    )
    report: Path | None = option("the whole report (.json, or text)", "FILE")
    json: bool = as_json("the report as JSON")

    @property
    def folder(self) -> bool:
        """Whether ``out`` is a folder, for a trial of each table."""
        return self.out is not None and not self.out.suffix


@request("view.watch:watch", writes=True)
class ViewRequest:
    """``bigant view``: watch a run, live or from its log, in a viewer or in a terminal.

    Draws the robot with its linkages, contact forces measured and predicted, the trajectory against
    ground truth, velocities, modes, health and faults. Foxglove and Lichtblick connect to the address
    that is printed, or open the .mcap that --save writes; Rerun opens an .rrd; --terminal needs none of
    them. --live follows a running bigant drive by reading the log that it writes, so the run cannot be
    disturbed from here. See docs/view.md.

    --ros2 publishes the run as ROS 2 topics instead: joint states and commands, a measured and a predicted
    wrench per foot, odometry, ground truth, transforms and diagnostics, under the log's own names and
    types, with frames by REP-105 and units and axes by REP-103. It needs a shell in which ROS 2 is set up;
    ROS can neither command nor disturb the run. See docs/ros2.md.
    """

    path: Path | None = argument(
        "LOG",
        "a log; with --live the one that is being written (default: the newest in runs/)",
        nargs="?",
        default=None,
    )
    live: bool = flag("follow a running bigant drive")
    speed: float = option(
        "of a recorded log (default: 1)", "X", default=1.0, type=between(0.01, 1000)
    )
    terminal: bool = flag("in this terminal")
    browser: bool = flag("in a web browser: robot in 3-D and numbers, without further packages")
    save: Path | None = option(
        "write what a viewer shows: .mcap for Foxglove and Lichtblick, .rrd for Rerun", "FILE"
    )
    headless: bool = flag("with --live and --save: no server, only the file")
    layout: Path | None = option("also write a layout to import in Foxglove", "FILE.json")
    host: str = option("listen here (default: 127.0.0.1)", "ADDRESS", default="127.0.0.1")
    port: int = option(
        f"({DEFAULT_PORT}; 0: any)", "P", default=DEFAULT_PORT, type=between(0, 65535, whole=True)
    )
    rate_hz: float = option(
        f"pictures a second of run time (default: {DEFAULT_RATE_HZ:g})",
        "R",
        default=DEFAULT_RATE_HZ,
        type=between(0.1, 200, "Hz"),
    )
    ros2: bool = flag("publish the run as ROS 2 topics")
    prefix: str | None = option("with --ros2: put all topics but /tf and /clock below it", "NAME")

    @property
    def for_rerun(self) -> bool:
        """Whether the file to save is one of Rerun's."""
        return self.save is not None and self.save.suffix == RERUN_SUFFIX
