"""``bigant ft calibrate``: force sensors to foot wrenches, from logs of a robot at rest.

Stage one fits what each sensor reads with its foot in the air (offset and leg gravity over the shaft
angle), stage two a 6 x 6 correction from poses in which the feet carry the weight. Poses are found in the
logs where no shaft moves. Judged on poses that the fit has not seen; nothing is written if those got
worse. --hardware virtual drives the virtual robot through such poses first, in virtual time.
"""

import argparse
import json
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import ConfigError, RecordError
from robot.console.arguments import seed
from robot.console.exit_codes import ExitCode

# Left-out poses are few: sensors that need no correction come out a few per cent better or worse.
WORSE = 1.1

if TYPE_CHECKING:
    from model.fit.in_situ import InSituResult
    from robot.bringup.force.logs import PoseLogs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("logs", nargs="*", type=Path, metavar="LOG", help="robot standing at rest")
    parser.add_argument("--hung", nargs="+", type=Path, default=[], metavar="LOG",
                        help="logs of the robot hung up, no foot on the ground")  # fmt: skip
    parser.add_argument("--hardware", choices=("virtual",), help="record poses first")
    parser.add_argument("--rounds", type=int, default=4, metavar="N",
                        help="with --hardware: how often each leg is lifted (4)")  # fmt: skip
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="with --hardware")
    parser.add_argument("--log", type=Path, default=Path("ft-poses.mcap"), metavar="FILE",
                        help="with --hardware: the log to write (ft-poses.mcap)")  # fmt: skip
    parser.add_argument("--robot", type=Path, metavar="FILE",
                        help="robot file (default: with --hardware config/bigant.toml, else the "
                        "one in the logs)")  # fmt: skip
    parser.add_argument("--harmonics", type=int, default=3, metavar="H",
                        help="most harmonics of leg gravity (3)")  # fmt: skip
    parser.add_argument("--no-cross-talk", action="store_true", help="stage one only")
    parser.add_argument("--no-point-feet", action="store_true",
                        help="do not believe that feet touch at a point")  # fmt: skip
    parser.add_argument("--out", type=Path, default=Path("force-calibration.toml"), metavar="FILE",
                        help="calibration file (force-calibration.toml)")  # fmt: skip
    parser.add_argument("--report", type=Path, metavar="FILE", help="picture, .png")
    parser.add_argument("--json", action="store_true", help="residuals and warnings as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Calibrate.

    Returns:
        OK, or VERDICT_FAILED when left-out poses got worse; then no file is written.

    Raises:
        BigantError: A log or file cannot be used, or the poses are too few.
    """
    _check(options)
    from model.fit.in_situ import calibrate_in_situ
    from robot.bringup.force.logs import read_pose_logs
    from robot.bringup.force.report import overall, report_lines
    from robot.config.calibration import write_calibration
    from robot.console.program_output import keep_earlier

    logs: list[Path] = list(options.logs)
    if options.hardware is not None:
        _record(options)
        logs.append(options.log)
    found: PoseLogs = read_pose_logs(logs, options.hung, options.robot)
    result = calibrate_in_situ(
        found.poses,
        found.places,
        found.legs,
        max_harmonics=options.harmonics,
        cross_talk=not options.no_cross_talk,
        point_feet=not options.no_point_feet,
        serials=found.serials,
        date=time.strftime("%Y-%m-%dT%H:%M:%S%z"),
        logs=tuple(dict.fromkeys(path.name for path in [*logs, *options.hung])),
    )
    worse = overall(result.after, "standing_n") > WORSE * overall(result.before, "standing_n")
    if not worse:
        keep_earlier(options.out)
        write_calibration(options.out, result.calibration)
    if options.report is not None:
        _draw(result, options.report)
    if options.json:
        print(json.dumps(_as_json(result, None if worse else options.out), indent=2))
    else:
        print("\n".join(report_lines(result)))
        if not worse:
            print(f"calibration: {options.out}   (bigant drive --calibration {options.out})")
    if worse:
        print("bigant ft calibrate: left-out poses got worse; nothing written", file=sys.stderr)
        return ExitCode.VERDICT_FAILED
    return ExitCode.OK


def _check(options: argparse.Namespace) -> None:
    if not options.logs and options.hardware is None:
        raise ConfigError("LOG", "name one or more logs, or --hardware virtual")
    if options.report is not None and options.report.suffix != ".png":
        raise ConfigError("--report", f"must end in .png, not {options.report.name!r}")
    if not 1 <= options.rounds <= 50:
        raise ConfigError("--rounds", f"must be from 1 to 50, not {options.rounds}")
    if not 0 <= options.harmonics <= 8:
        raise ConfigError("--harmonics", f"must be from 0 to 8, not {options.harmonics}")


def _record(options: argparse.Namespace) -> None:
    from robot.config.robot_file import DEFAULT_ROBOT_FILE, load_robot
    from robot.virtual.poses import record_poses

    config = load_robot(options.robot or DEFAULT_ROBOT_FILE)
    told = -1

    def progress(share: float) -> None:
        nonlocal told
        if int(100 * share) > told and not options.json:
            told = int(100 * share)
            if sys.stderr.isatty():
                print(f"\rrecording poses {told:3d} %", end="", file=sys.stderr, flush=True)
            elif told % 10 == 0:
                print(f"recording poses {told:3d} %", file=sys.stderr, flush=True)

    record_poses(
        config, options.log, rounds=options.rounds, heights=4, seed=options.seed, progress=progress
    )
    if sys.stderr.isatty():
        print("\r" + " " * 30 + "\r", end="", file=sys.stderr)


def _draw(result: "InSituResult", path: Path) -> None:
    from robot.bringup.force.report import draw_report

    try:
        draw_report(result).savefig(path, dpi=100)
    except OSError as error:
        raise RecordError(f"{path} cannot be written: {error.strerror}") from error


def _as_json(result: "InSituResult", out: Path | None) -> dict[str, object]:
    from robot.console.json_output import plain

    legs = result.calibration.legs
    parts = {"before": result.before, "stage_one": result.stage_one, "after": result.after}
    return {
        "held_out_poses": result.held_out,
        "residuals": {
            name: {leg: plain(asdict(r)) for leg, r in zip(legs, part, strict=True)}
            for name, part in parts.items()
        },
        "warnings": list(result.warnings),
        "calibration": None if out is None else str(out),
    }
