"""``bigant view``: the ticks of a log or of a live run, shown in a viewer, a file or this terminal."""

import importlib.util
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from pathlib import Path

from drivers.clock import Clock, MonotonicClock
from model.errors import ConfigError, RecordError
from model.values.machine_names import MachineNames
from model.values.parameters import RobotParameters
from record.log.follow import LogFollower
from record.log.reader import LogContents, StampedTick, read_stamped_ticks
from record.whole_file import write_text
from robot.config.robot_file import parse_robot
from robot.console.exit_codes import ExitCode
from robot.console.installed import how_to_install
from robot.console.program_output import complain
from robot.console.progress import ProgressLine
from robot.control.effect_uses import true_forces_of_log, with_true_forces
from robot.requests.recorded import RERUN_SUFFIX, ViewRequest
from robot.view.bridge import publish
from robot.view.log_source import POLL_NS, be_nice, followed, log_path, paced
from robot.view.screen import open_view
from robot.view.viewer import Viewer

PACKAGE = "foxglove"
RERUN_PACKAGE = "rerun"
SAVED = (".mcap", RERUN_SUFFIX)


def watch(request: ViewRequest) -> ExitCode:
    """Show a run until it or the operator ends.

    Raises:
        ConfigError: Arguments that do not go together, or the viewer's package is missing.
        RecordError: The log cannot be read, or the file cannot be written.
    """
    written = request.save or request.layout or request.headless
    if request.prefix is not None and not request.ros2:
        raise ConfigError("--prefix", "is of ROS 2 topics; add --ros2")
    if request.browser and (request.terminal or request.ros2 or written):
        raise ConfigError(
            "--browser", "serves a page and writes nothing; leave out the other options"
        )
    if request.ros2:
        if request.terminal or written:
            raise ConfigError("--ros2", "only publishes; leave out the other options")
        return publish(request)
    if request.terminal and written:
        raise ConfigError(
            "--terminal", "only shows the run; leave out the options that write a file"
        )
    if request.headless and request.save is None:
        raise ConfigError("--headless", "without a server there is nothing left to do; add --save")
    if request.save is not None and request.save.suffix not in SAVED:
        raise ConfigError("--save", f"must end in .mcap or .rrd, not {request.save.name}")
    path = log_path(request.path, live=request.live)
    if not (request.terminal or request.browser):
        _check_packages(request)
    if request.save is not None and request.save.resolve() == path.resolve():
        raise ConfigError("--save", "would overwrite the log; choose another file")
    try:
        return _watch(path, request, MonotonicClock())
    except KeyboardInterrupt:
        print(file=sys.stderr)
        return ExitCode.OK


def _check_packages(request: ViewRequest) -> None:
    """Say what to install before anything is read."""
    package, extra, size = PACKAGE, "view", "54 MB"
    if request.for_rerun:
        package, extra, size = RERUN_PACKAGE, "rerun", "640 MB"
        if request.layout is not None:
            raise ConfigError("--layout", "is for Foxglove; a file for Rerun holds its own layout")
        if request.live and not request.headless:
            raise ConfigError("--save", "an .rrd of a live run is written with --headless only")
    if importlib.util.find_spec(package) is None:
        raise ConfigError(
            "viewer",
            f"its package ({size}) is not installed; install it with: "
            f"{how_to_install(extra)}, or use --browser or --terminal (see docs/view.md)",
        )


def _watch(path: Path, request: ViewRequest, clock: Clock) -> ExitCode:
    if request.live:
        be_nice()
        with LogFollower(path) as follower:
            ticks: Iterator[StampedTick] = (
                follower.decode(message)
                for message in followed(follower, clock)
                if message.topic == "/bigant/tick"
            )
            complain(f"following {path}; Ctrl-C ends this, not the run")
            return _present(path, ticks, follower.contents, request, clock)
    contents = LogContents()
    stored = read_stamped_ticks(path, contents)
    if request.save is None:
        stored = paced(stored, lambda t: t.unix_ns, clock, request.speed)
        return _present(path, stored, contents, request, clock)
    with ProgressLine(f"reading {path}", contents.progress):
        return _present(path, stored, contents, request, clock)


def _present(
    path: Path,
    ticks: Iterator[StampedTick],
    contents: LogContents,
    request: ViewRequest,
    clock: Clock,
) -> ExitCode:
    ticks = ticks_with_true_forces(ticks, contents)
    first = next(ticks, None)
    if first is None:
        raise RecordError(f"{path} holds no ticks{': ' * bool(contents.damage)}{contents.damage}")
    ticks = chain((first,), ticks)
    if request.terminal:
        _in_terminal(path, ticks, contents.machine(first.tick))
    elif request.browser:
        _in_browser(path, ticks, contents, request, clock)
    else:
        _in_viewer(path, ticks, contents, request, clock)
    if contents.damage:
        complain(f"warning: {path}: {contents.damage}")
    return ExitCode.OK


def ticks_with_true_forces(
    ticks: Iterator[StampedTick], contents: LogContents
) -> Iterator[StampedTick]:
    """Yield the ticks of a log with forces as its robot file has them."""
    first = next(ticks, None)  # the robot file comes before the first tick
    if first is None:
        return
    true_forces = true_forces_of_log(contents.config_text)
    start_ns = contents.start_ns(first.tick.t_ns)
    yield replace(first, tick=with_true_forces(first.tick, true_forces, start_ns))
    for item in ticks:
        yield replace(item, tick=with_true_forces(item.tick, true_forces, start_ns))


def _in_terminal(path: Path, ticks: Iterator[StampedTick], names: MachineNames) -> None:
    view = open_view(names, f"{path}  (watching)", "Ctrl-C: stop watching")
    try:
        for stamped in ticks:
            view.show(stamped.tick)
    finally:
        view.close()


def _in_browser(
    path: Path,
    ticks: Iterator[StampedTick],
    contents: LogContents,
    request: ViewRequest,
    clock: Clock,
) -> None:
    from robot.view.browser import BrowserView  # and with it what makes pages

    view = BrowserView(str(path), contents, request.host, request.port)
    try:
        print(f"open {view.address} in a browser; Ctrl-C ends", flush=True)
        while not (
            request.live or view.hub.watched.is_set()
        ):  # or the run is over before one looks
            clock.sleep_until_ns(clock.now_ns() + POLL_NS)
        for stamped in ticks:
            view.show(stamped)
    finally:
        view.close()


def _in_viewer(
    path: Path,
    ticks: Iterator[StampedTick],
    contents: LogContents,
    request: ViewRequest,
    clock: Clock,
) -> None:
    parameters = _parameters(path, contents)
    if request.layout is not None:
        _write_layout(request.layout, parameters.names)
    saves_only = request.save is not None and (request.headless or not request.live)
    serve = None if saves_only else (request.host, request.port)
    view = _open_viewer(parameters, request, serve)
    try:
        if serve is not None:
            address = f"ws://{request.host}:{view.port}"
            print(
                f"open {address} in Foxglove or Lichtblick (Open connection); Ctrl-C ends",
                flush=True,
            )
        # or the run is over before one looks
        while not (saves_only or request.live or view.watched):
            clock.sleep_until_ns(clock.now_ns() + POLL_NS)
        period_ns, next_ns, shown, count = round(1e9 / request.rate_hz), 0, 0, 0
        for stamped in ticks:
            view.note(stamped.tick, stamped.unix_ns)
            count += 1
            if stamped.unix_ns >= next_ns:
                next_ns = stamped.unix_ns + period_ns
                view.show(stamped.tick, stamped.unix_ns)
                shown += 1
    finally:
        view.close()
    if request.save is not None:
        opened = f"; open it with: rerun {request.save}" if request.for_rerun else ""
        print(f"{shown} pictures of {count} ticks: {request.save}{opened}")


def _open_viewer(
    parameters: RobotParameters, request: ViewRequest, serve: tuple[str, int] | None
) -> Viewer:
    if request.save is not None and request.for_rerun:
        from robot.view.rerun import RerunView

        return RerunView(parameters, request.save)
    from robot.view.foxglove import FoxgloveView

    return FoxgloveView(parameters, request.save, serve)


def _parameters(path: Path, contents: LogContents) -> RobotParameters:
    try:
        return parse_robot(contents.config_text).parameters
    except ConfigError as error:
        raise RecordError(
            f"{path} holds no robot file to draw the robot from ({error}); use --terminal"
        ) from error


def _write_layout(path: Path, names: MachineNames) -> None:
    from robot.view.layout import layout_text

    write_text(path, layout_text(names), "--layout")
    print(f"layout: {path}")
