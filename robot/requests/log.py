"""Requests of ``bigant log``: look at, repair, trim, merge and export logs."""

from pathlib import Path

from robot.console.arguments import argument, as_json, needed, option, request

FORMATS = ("trial", "csv", "parquet", "tum")
GROUPS = "joints,commands,forces,model,odometry,imu,truth,loop"


@request("report.log_files:info")
class LogInfoRequest:
    """``bigant log info``: what a log holds.

    Duration, rate, ticks and missing ticks, topics, robot, gait, software versions and damage. Exit code
    1: the log is damaged.
    """

    path: Path = argument("LOG")
    json: bool = as_json()


@request("report.log_files:repair", writes=True)
class LogRepairRequest:
    """``bigant log repair``: a proper file of a cut or damaged log.

    Everything that can be read goes into a new file with index and summary; the old file is not touched.
    """

    path: Path = argument("LOG")
    out: Path | None = option("new log (default: LOG.repaired.mcap next to it)", "FILE")


@request("report.log_files:trim", writes=True)
class LogTrimRequest:
    """``bigant log trim``: keep one piece of a log.

    Times stay those of the run, so the piece begins at --from; pieces of one log can be merged again.
    """

    path: Path = argument("LOG")
    from_s: float = option(
        "first second kept (default: the beginning)", "S", default=float("-inf"), flags=("--from",)
    )
    to_s: float = option(
        "first second not kept (default: the end)", "S", default=float("inf"), flags=("--to",)
    )
    out: Path = needed("new log", "FILE")


@request("report.log_files:merge", writes=True)
class LogMergeRequest:
    """``bigant log merge``: logs of one robot, one behind the other.

    Gaps between the logs remain; logs that overlap are refused.
    """

    paths: tuple[Path, ...] = argument("LOG", nargs="+")
    out: Path = needed("new log", "FILE")


@request("report.log_files:export", writes=True)
class LogExportRequest:
    """``bigant log export``: a log as files that other programs read.

    trial: NAME.parquet (or .csv, by --out), NAME.toml and the robot file; measured quantities only.
    csv, parquet: a table with the columns of --what.
    tum: trajectories NAME_estimate.tum, NAME_dead_reckoning.tum and NAME_truth.tum, for evo.
    """

    path: Path = argument("LOG")
    format: str = needed(choices=FORMATS)
    out: Path | None = option("file to write (default: named after the log)", "FILE")
    what: str | None = option(
        f"columns of csv and parquet: raw and {GROUPS}; odometry is dead_reckoning,estimate "
        "(default: all but raw)",
        "A,B,...",
    )
