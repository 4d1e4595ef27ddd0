"""``bigant view``: watch a run, live or from its log, in a viewer or in a terminal.

Draws the robot with its linkages, contact forces measured and predicted, the trajectory against the truth,
velocities, modes, health and faults. Foxglove and Lichtblick connect to the address that is printed, or
open the .mcap that --save writes; Rerun opens an .rrd; --terminal needs none of them. --live follows a
running bigant drive by reading the log that it writes, so the run cannot be disturbed from here. See
docs/view.md.
"""

import argparse
import importlib.util
import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import ConfigError, RecordError
from robot.console.exit_codes import ExitCode
from robot.console.installed import how_to_install
from robot.view.log_source import POLL_NS, add_source, be_nice, followed, log_path, paced

if TYPE_CHECKING:
    from drivers.clock import Clock
    from model.parameters.robot import RobotParameters
    from record.log.reader import LogContents, StampedTick
    from robot.view.foxglove import FoxgloveView
    from robot.view.rerun import RerunView

DEFAULT_PORT = 8765
DEFAULT_RATE_HZ = 25.0
PACKAGE = "foxglove"
RERUN_PACKAGE, RERUN_SUFFIX = "rerun", ".rrd"
SAVED = (".mcap", RERUN_SUFFIX)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_source(parser)
    parser.add_argument("--terminal", action="store_true", help="in this terminal")
    parser.add_argument(
        "--save",
        type=Path,
        metavar="FILE",
        help="write what a viewer shows: .mcap for Foxglove and Lichtblick, .rrd for Rerun",
    )
    parser.add_argument(
        "--headless", action="store_true", help="with --live and --save: no server, only the file"
    )
    parser.add_argument(
        "--layout", type=Path, metavar="FILE.json", help="also write a layout to import in Foxglove"
    )
    parser.add_argument(
        "--host", default="127.0.0.1", metavar="ADDRESS", help="listen here (default: 127.0.0.1)"
    )
    parser.add_argument(
        "--port", type=_port, default=DEFAULT_PORT, metavar="P", help=f"({DEFAULT_PORT}; 0: any)"
    )
    parser.add_argument(
        "--rate-hz",
        type=_rate,
        default=DEFAULT_RATE_HZ,
        metavar="R",
        help=f"pictures a second of run time (default: {DEFAULT_RATE_HZ:g})",
    )


def _port(text: str) -> int:
    value = int(text)
    if not 0 <= value <= 65535:
        raise argparse.ArgumentTypeError(f"must be from 0 to 65535, not {text}")
    return value


def _rate(text: str) -> float:
    value = float(text)
    if not 0.1 <= value <= 200:
        raise argparse.ArgumentTypeError(f"must be from 0.1 to 200 Hz, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Show a run until it or the operator ends.

    Raises:
        ConfigError: Arguments that do not go together, or the viewer's package is missing.
        RecordError: The log cannot be read, or the file cannot be written.
    """
    from drivers.clock import MonotonicClock

    if options.terminal and (options.save or options.layout or options.headless):
        raise ConfigError("--terminal", "shows and writes nothing; leave out the other options")
    if options.headless and options.save is None:
        raise ConfigError("--headless", "without a server there is nothing left to do; add --save")
    if options.save is not None and options.save.suffix not in SAVED:
        raise ConfigError("--save", f"must end in .mcap or .rrd, not {options.save.name}")
    path = log_path(options)
    if not options.terminal:
        _check_packages(options)
    if options.save is not None and options.save.resolve() == path.resolve():
        raise ConfigError("--save", "would overwrite the log; choose another file")
    try:
        return _watch(path, options, MonotonicClock())
    except KeyboardInterrupt:
        print(file=sys.stderr)
        return ExitCode.OK


def _for_rerun(options: argparse.Namespace) -> bool:
    return options.save is not None and options.save.suffix == RERUN_SUFFIX


def _check_packages(options: argparse.Namespace) -> None:
    """Say what to install before anything is read."""
    package, extra, size = PACKAGE, "view", "54 MB"
    if _for_rerun(options):
        package, extra, size = RERUN_PACKAGE, "rerun", "640 MB"
        if options.layout is not None:
            raise ConfigError("--layout", "is for Foxglove; a file for Rerun holds its own layout")
        if options.live and not options.headless:
            raise ConfigError("--save", "an .rrd of a live run is written with --headless only")
    if importlib.util.find_spec(package) is None:
        raise ConfigError(
            "viewer",
            f"its package ({size}) is not installed; install it in the clone with: "
            f"{how_to_install(extra)}, or use --terminal (see docs/view.md)",
        )


def _watch(path: Path, options: argparse.Namespace, clock: "Clock") -> ExitCode:
    from record.log.reader import LogContents, StampedTick
    from robot.console.progress import ProgressLine

    if options.live:
        from record.log.follow import LogFollower

        be_nice()
        with LogFollower(path) as follower:
            ticks: Iterator[StampedTick] = (
                follower.decode(message)
                for message in followed(follower, clock)
                if message.topic == "/bigant/tick"
            )
            print(f"following {path}; Ctrl-C ends this, not the run", file=sys.stderr)
            return _present(path, ticks, follower.contents, options, clock)
    from record.log.reader import read_stamped_ticks

    contents = LogContents()
    quick = options.save is not None
    stored = read_stamped_ticks(path, contents)
    speed = math.inf if quick else options.speed
    if not quick:
        return _present(
            path, paced(stored, lambda t: t.unix_ns, clock, speed), contents, options, clock
        )
    with ProgressLine(f"reading {path}", contents.progress):
        return _present(path, stored, contents, options, clock)


def _present(
    path: Path,
    ticks: "Iterator[StampedTick]",
    contents: "LogContents",
    options: argparse.Namespace,
    clock: "Clock",
) -> ExitCode:
    from robot.view.true_ticks import ticks_with_true_forces

    ticks = ticks_with_true_forces(ticks, contents)
    first = next(ticks, None)
    if first is None:
        raise RecordError(f"{path} holds no ticks{': ' * bool(contents.damage)}{contents.damage}")
    if options.terminal:
        _in_terminal(path, first, ticks, contents)
    else:
        _in_viewer(path, first, ticks, contents, options, clock)
    if contents.damage:
        print(f"warning: {path}: {contents.damage}", file=sys.stderr)
    return ExitCode.OK


def _in_terminal(
    path: Path, first: "StampedTick", ticks: "Iterator[StampedTick]", contents: "LogContents"
) -> None:
    from robot.view.screen import open_view

    names = contents.names(len(first.tick.joints.angle_rad))
    view = open_view(names, f"{path}  (watching)", "Ctrl-C: stop watching")
    try:
        view.show(first.tick)
        for stamped in ticks:
            view.show(stamped.tick)
    finally:
        view.close()


def _in_viewer(
    path: Path,
    first: "StampedTick",
    ticks: "Iterator[StampedTick]",
    contents: "LogContents",
    options: argparse.Namespace,
    clock: "Clock",
) -> None:
    parameters = _parameters(path, contents)
    if options.layout is not None:
        from robot.view.layout import layout_text

        _write(options.layout, layout_text(parameters.legs.names))
        print(f"layout: {options.layout}")
    saves_only = options.save is not None and (options.headless or not options.live)
    serve = None if saves_only else (options.host, options.port)
    view = _open_viewer(parameters, options, serve)
    try:
        if serve is not None:
            address = f"ws://{options.host}:{view.port}"
            print(
                f"open {address} in Foxglove or Lichtblick (Open connection); Ctrl-C ends",
                flush=True,
            )
        if not (saves_only or options.live):
            _wait_for_viewer(view, clock)  # or the run would be over before anybody looks
        period_ns, next_ns, shown, count = round(1e9 / options.rate_hz), 0, 0, 0
        for stamped in _chain(first, ticks):
            view.note(stamped.tick, stamped.unix_ns)
            count += 1
            if stamped.unix_ns >= next_ns:
                next_ns = stamped.unix_ns + period_ns
                view.show(stamped.tick, stamped.unix_ns)
                shown += 1
    finally:
        view.close()
    if options.save is not None:
        opened = f"; open it with: rerun {options.save}" if _for_rerun(options) else ""
        print(f"{shown} pictures of {count} ticks: {options.save}{opened}")


def _open_viewer(
    parameters: "RobotParameters", options: argparse.Namespace, serve: tuple[str, int] | None
) -> "FoxgloveView | RerunView":
    if _for_rerun(options):
        from robot.view.rerun import RerunView

        return RerunView(parameters, options.save)
    from robot.view.foxglove import FoxgloveView

    return FoxgloveView(parameters, options.save, serve)


def _wait_for_viewer(view: "FoxgloveView | RerunView", clock: "Clock") -> None:
    while not view.watched:
        clock.sleep_until_ns(clock.now_ns() + POLL_NS)


def _chain(first: "StampedTick", rest: "Iterator[StampedTick]") -> "Iterator[StampedTick]":
    yield first
    yield from rest


def _parameters(path: Path, contents: "LogContents") -> "RobotParameters":
    from robot.config.robot_file import parse_robot

    try:
        return parse_robot(contents.config_text).parameters
    except ConfigError as error:
        raise RecordError(
            f"{path} holds no robot file to draw the robot from ({error}); use --terminal"
        ) from error


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError("--layout", f"{path} cannot be written: {error.strerror}") from error
