"""``bigant odom``: odometry and foot forces from a log, judged against the truth if there is one."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from model.parameters.robot import ContactParameters
    from record.log.recording import Recording
    from robot.odometry.compare import Comparison

TUNE = "tune"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.description = (
        "Run the estimator over a log with only what the loop knew at each tick. "
        "'odom tune LOG...' finds its noise from logs instead. --live follows the log of a running "
        "drive, or reads a robot without ever moving it."
    )
    parser.add_argument("logs", type=Path, nargs="*", metavar="[tune] LOG")
    parser.add_argument("--compare", action="store_true",
        help="beside it: open-loop model, strides, rigid stance and the truth")  # fmt: skip
    parser.add_argument("--law", choices=("coulomb", "viscous"),
        help="friction law of the process (default: coulomb; --live: robot file)")  # fmt: skip
    parser.add_argument("--no-sway", action="store_true",
        help="leave out how the body moves as it tilts")  # fmt: skip
    parser.add_argument("--no-forces", action="store_true", help="as if there were no force unit")
    parser.add_argument("--robot", type=Path, metavar="FILE",
        help="robot file to believe (default: the one in the log)")  # fmt: skip
    parser.add_argument("--fitted", type=Path, metavar="LOG",
        help="with --compare: fit open loop and stride to this walk of known truth")  # fmt: skip
    parser.add_argument("--smooth", action="store_true",
        help="write the trajectory smoothed with all of the log known")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE", help=".tum, .mcap, .png or .html")
    live = parser.add_argument_group("while it walks")
    live.add_argument("--live", action="store_true",
        help="follow LOG (default: newest in runs/) while it is written, or --hardware")  # fmt: skip
    live.add_argument("--hardware", metavar="virtual|PORT",
        help="read servos and forces here; torque is never asked for")  # fmt: skip
    live.add_argument("--force-unit", metavar="HOST[:UDP:CONSOLE]|none",
        help="force-torque unit (default: robot file)")  # fmt: skip
    live.add_argument("--duration", type=float, metavar="S", help="end after so long")
    parser.add_argument(
        "--json", action="store_true", help="the figures as JSON; with --live a line of it a second"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Run the command.

    Raises:
        RecordError: A log cannot be read or used, or a file cannot be written.
        ConfigError: An argument that does not fit.
    """
    from model.errors import ConfigError

    if options.live:
        from robot.odometry.live import run_live

        return run_live(_checked_live(options))
    if (
        options.hardware is not None
        or options.force_unit is not None
        or options.duration is not None
    ):
        raise ConfigError("--hardware, --force-unit, --duration", "go with --live; add it")
    if not options.logs:
        raise ConfigError("LOG", "is missing; name a log, or use --live")
    if options.logs[0] == Path(TUNE):
        from robot.odometry.tune import tune_command

        if len(options.logs) < 2:
            raise ConfigError("odom tune", "needs a log to tune by; give at least one")
        return tune_command(options.logs[1:], options)
    if len(options.logs) > 1:
        raise ConfigError("LOG", "give one log; only 'odom tune' takes several")
    if options.out is not None and options.out.suffix not in {".tum", ".mcap", ".png", ".html"}:
        raise ConfigError(
            "--out", f"must end in .tum, .mcap, .png or .html, not {options.out.name!r}"
        )
    if options.fitted is not None and not options.compare:
        raise ConfigError("--fitted", "is for --compare; add it")
    if options.smooth and (options.out is None or options.out.suffix != ".tum"):
        raise ConfigError("--smooth", "writes a trajectory; add --out FILE.tum")
    return _estimate(options)


def _checked_live(options: argparse.Namespace) -> argparse.Namespace:
    from model.errors import ConfigError

    for name in ("compare", "smooth", "fitted"):
        if getattr(options, name):
            raise ConfigError(f"--{name}", "needs a whole log; leave --live out")
    if len(options.logs) > 1 or options.logs == [Path(TUNE)]:
        raise ConfigError("LOG", "give one log to follow")
    return options


def _estimate(options: argparse.Namespace) -> ExitCode:
    from dataclasses import replace

    import numpy as np

    from model.estimator.settings import EstimatorSettings
    from model.quasistatic.frames import FrictionLaw
    from record.log.reader import read_log
    from robot.config.robot_file import load_robot, parse_robot
    from robot.console.json_output import print_json
    from robot.console.screen_fit import columns_of
    from robot.control.effect_uses import say_unused
    from robot.odometry.compare import compare_ways, stride_of
    from robot.odometry.table import as_json, table

    log = read_log(options.logs[0])
    if options.no_forces:
        log = replace(log, force_n=np.full_like(log.force_n, np.nan))
    if options.robot is not None:
        config = load_robot(options.robot)
    else:
        config = parse_robot(log.config_text) if log.config_text else load_robot()
    say_unused(config)
    settings = EstimatorSettings(
        law=FrictionLaw(options.law or "coulomb"), sway=not options.no_sway
    )
    fitted, stride_m, source = None, np.nan, ""
    if options.compare:
        if options.fitted is not None:
            other = read_log(options.fitted)
            fitted, stride_m, source = _fit(other, options.fitted), stride_of(other), "fitted log"
        elif log.has_truth:
            stride_m, source = stride_of(log), "this log's own truth, so it ends well by itself"
    found = compare_ways(
        log, config, settings, fitted=fitted, stride_m=stride_m, keep_states=options.smooth,
        progress=None if options.json else _progress,
    )  # fmt: skip
    if not options.json:
        print(file=sys.stderr)
    if options.json:
        print_json(as_json(found, log.names))
    else:
        width = columns_of(sys.stdout)
        print(*table(found, log.names, everything=options.compare, width=width), sep="\n")
        if source:
            print(f"distance a stride: {1e3 * stride_m:.1f} mm a cycle, from {source}")
    if options.out is not None:
        _write(options, found, log)
        if not options.json:
            print(f"written: {options.out}")
    return ExitCode.OK


def _progress(share: float) -> None:
    if sys.stderr.isatty():
        print(f"\restimating {100 * share:3.0f} %", end="", file=sys.stderr, flush=True)


def _fit(log: "object", path: Path) -> "ContactParameters":
    from record.log.recording import Recording
    from robot.study.sensitivity_frames import walk_frames
    from robot.study.sensitivity_table import fit_contact

    assert isinstance(log, Recording)
    walk = walk_frames(log, path.name)
    return fit_contact(walk, log.names, free_w=False, rest_m_s=1e-3).contact


def _write(options: argparse.Namespace, found: "Comparison", log: "Recording") -> None:
    from robot.odometry.files import write_mcap, write_tum

    out: Path = options.out
    if out.suffix == ".mcap":
        write_mcap(out, found.track)
    elif out.suffix == ".png":
        from robot.odometry.figure import draw

        draw(found, log.names, out, everything=options.compare)
    elif out.suffix == ".html":
        from record.whole_file import write_text
        from robot.odometry.page import odometry_page
        from robot.report.run_date import date_words

        date = date_words(log.metadata)
        page = odometry_page(found, log.names, options.logs[0], date, everything=options.compare)
        write_text(out, page)
    else:
        pose = found.track.pose
        if options.smooth:
            from model.estimator.smoother import smooth

            pose = smooth(found.track.states)[0][:, :3]
        write_tum(out, found.track.t_s, pose)
        if found.truth is not None:
            write_tum(out.with_suffix(".truth.tum"), found.track.t_s, found.truth[0])
