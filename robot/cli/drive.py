"""``bigant drive``: open a robot, run the loop, keep the log, say how it went.

Walk a gait and keep a log. Virtual hardware is the default. Real ports are only listened to unless --armed
is given. Ctrl-C stops on all feet, a second Ctrl-C cuts torque; torque is always switched off on exit.
"""

import argparse
import gc
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from drivers.pose_udp import PoseListener
from drivers.wire.tap import WireTap
from gaits.limits import check_gait
from gaits.names import GAIT_NAMES
from model.errors import ConfigError, RecordError
from model.values.tick import Intent, Tick
from record.log.background import BackgroundWriter
from record.log.versions import software_versions
from record.log.writer import LogWriter
from robot.bringup.force.unit import check_no_unit, unit_settings
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.arguments import add_robot, add_scenario, between, positive, seed, steer
from robot.console.exit_codes import ExitCode, exit_code_of
from robot.console.program_output import complain, keep_earlier, stop_output
from robot.control.controller import Controller
from robot.control.effect_uses import true_forces_of, unused_notes
from robot.report.summary_text import busy_words
from robot.run.force_units import UNITS_KEY, units_text
from robot.run.hardware import open_in_memory, open_real, open_virtual
from robot.run.header import controller_metadata, wire_metadata
from robot.run.loop import Operator, RunResult
from robot.run.loop import run as run_loop
from robot.run.operator import Interrupts, Script, ScriptedOperator
from robot.run.rig import Rig
from robot.run.teleop import HELP, KeyboardOperator, Keys, Wish
from robot.view.screen import open_view
from sim_hw.faults.scenario import load_scenario

VIRTUAL = "virtual"
# Virtual time has no calendar; its logs are stamped from this date so that two runs are the same.
VIRTUAL_EPOCH_UNIX_NS = 1_767_225_600_000_000_000  # 2026-01-01 00:00:00 UTC
DEFAULT_CYCLES = 3.0
NO_LOG = "none"


@dataclass(frozen=True, slots=True)
class Drive:
    """One run as the command line asks for it.

    Attributes:
        config: The robot.
        gait: Gait to begin with.
        frequency_hz: Its frequency.
        armed: Whether torque may be switched on.
        log_path: Where the log goes, None for no log.
        options: Everything else, as argparse gave it.
    """

    config: RobotConfig
    gait: str
    frequency_hz: float
    armed: bool
    log_path: Path | None
    options: argparse.Namespace


# Makes the operator of a run once the robot is open; what it needs to give back goes on the stack.
OperatorOf = Callable[[Drive, Controller, Interrupts, ExitStack], Operator]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_robot(parser)
    parser.add_argument("--gait", choices=GAIT_NAMES, default="tripod")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--cycles", type=positive, metavar="N", help="gait cycles (default: 3)")
    length.add_argument(
        "--duration", type=positive, metavar="S", dest="duration_s", help="seconds of walking"
    )
    parser.add_argument(
        "--frequency-hz", type=positive, metavar="F", help="cycles a second (default: robot file)"
    )
    parser.add_argument(
        "--steer", type=steer, default=0.0, metavar="X", help="-1 (right) to 1 (left)"
    )
    parser.add_argument(
        "--hardware",
        default=VIRTUAL,
        metavar="virtual|PORT",
        help="virtual (default), or the serial port of the servo bus, for example /dev/ttyUSB0",
    )
    parser.add_argument(
        "--force-unit",
        metavar="HOST[:UDP:CONSOLE]|none",
        help="wireless force-torque unit (default: robot file); none walks without it",
    )
    parser.add_argument(
        "--calibration",
        type=Path,
        metavar="FILE",
        help="calibration of the force sensors (default: the one that the robot file names, if any)",
    )
    parser.add_argument("--log", metavar="FILE", help="log file, or none (default: runs/...)")
    parser.add_argument(
        "--record-bytes",
        action="store_true",
        help="log the raw bytes of both devices as well, so that the drivers can be replayed",
    )
    parser.add_argument(
        "--pose-udp",
        type=between(1, 65535, whole=True),
        metavar="PORT",
        help="receive absolute poses on this UDP port of this machine (default: robot file, else none)",
    )
    parser.add_argument("--readonly", action="store_true", help="sense and log, never move")
    parser.add_argument("--armed", action="store_true", help="allow torque on real hardware")
    parser.add_argument("--teleop", action="store_true", help="drive with the keyboard")
    parser.add_argument(
        "--deadman",
        type=positive,
        default=5.0,
        metavar="S",
        dest="deadman_s",
        help="with --teleop: stand after so many seconds without a key (default: 5)",
    )
    parser.add_argument(
        "--rate-hz",
        type=between(10, 200, "Hz", whole=True),
        metavar="R",
        help="loop rate, up to 200",
    )
    parser.add_argument(
        "--virtual-time",
        action="store_true",
        help="virtual hardware in memory under a virtual clock: as fast as the computer goes, and "
        "the same log, byte for byte, every time",
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of virtual noise")
    add_scenario(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Run ``bigant drive``.

    Raises:
        BigantError: Something is wrong before the robot moves.
    """
    return drive_plan(plan_of(options), _operator)


def drive_plan(plan: Drive, operator_of: OperatorOf) -> ExitCode:
    """Open the robot of a plan, run it, keep its log and say how it went.

    Args:
        plan: The run.
        operator_of: Makes the operator once the robot is open.

    Raises:
        BigantError: Something is wrong before the robot moves.
    """
    options = plan.options
    tap = WireTap() if options.record_bytes else None
    with ExitStack() as stack:
        interrupts = stack.enter_context(Interrupts())
        rig = _open_rig(plan, tap)
        stack.callback(rig.close)
        port = options.pose_udp or plan.config.estimator.pose_port
        if port:
            rig.listen(PoseListener(port, rig.clock, time.time_ns()))
        for warning in rig.report.warnings:
            print(f"warning: {warning}", file=sys.stderr)
        controller = Controller(
            plan.config, rig.calibrations, armed=plan.armed, rate_hz=options.rate_hz
        )
        operator = operator_of(plan, controller, interrupts, stack)
        log = _open_log(plan, rig, controller)
        sink = log if log is None or tap is None else TappedLog(log, tap)
        title = f"{plan.config.name}  {options.hardware}" + ("" if plan.armed else "  (readonly)")
        keys = HELP if options.teleop else "Ctrl-C: stop on all feet; twice: cut torque"
        view = open_view(
            plan.config.parameters.legs.names, title, keys, true_forces=true_forces_of(plan.config)
        )
        stack.callback(view.close)
        gc.collect()
        gc.freeze()  # a full collection would cost several periods
        try:
            result = run_loop(rig, controller, operator, sink, view)
        finally:
            gc.unfreeze()
            log_error = _close_log(sink)
    code = _say(plan, result, log_error)
    busy = busy_words(result.missed, result.ticks, virtual=options.hardware == VIRTUAL)
    if busy and not options.virtual_time:
        print(busy, file=sys.stderr)
    return code


def plan_of(options: argparse.Namespace) -> Drive:
    """Turn the command line into a plan.

    Raises:
        BigantError: It makes no sense.
    """
    config = load_robot(options.robot, options.calibration)
    for note in unused_notes(config.effects):
        complain(note)
    controller = Controller(config, (), armed=False)
    gait = controller.book.gaits[options.gait]
    frequency_hz = options.frequency_hz if options.frequency_hz is not None else gait.frequency_hz
    check_gait(gait, frequency_hz, config.parameters.servo)
    virtual = options.hardware == VIRTUAL
    if options.virtual_time and not virtual:
        raise ConfigError(
            "--virtual-time", "needs --hardware virtual; real servos live in real time"
        )
    if virtual:
        check_no_unit(options.force_unit)
    if options.scenario is not None and not virtual:
        raise ConfigError(
            "--scenario", "needs --hardware virtual; faults are put on virtual devices only"
        )
    if options.virtual_time and (options.pose_udp or config.estimator.pose_port):
        raise ConfigError("--pose-udp", "cannot be heard in virtual time; leave --virtual-time out")
    if options.readonly and options.armed:
        raise ConfigError("--armed", "and --readonly exclude each other; choose one")
    if options.record_bytes and options.log == NO_LOG:
        raise ConfigError("--record-bytes", "needs a log; leave out --log none")
    armed = not options.readonly and (virtual or options.armed)
    return Drive(config, options.gait, frequency_hz, armed, _log_path(options), options)


def _log_path(options: argparse.Namespace) -> Path | None:
    if options.log == NO_LOG:
        return None
    if options.log is not None:
        return Path(options.log)
    stamp = time.strftime("%Y%m%dT%H%M%S")
    return Path("runs") / f"{options.gait}-{stamp}.mcap"


def _open_rig(plan: Drive, tap: WireTap | None) -> Rig:
    options, config = plan.options, plan.config
    with_forces = options.force_unit != NO_LOG
    if options.hardware != VIRTUAL:
        unit = unit_settings(options.force_unit, config.force_sensor) if with_forces else None
        return open_real(config, options.hardware, unit, armed=plan.armed, tap=tap)
    scenario = None
    if options.scenario is not None:
        scenario = load_scenario(options.scenario, [int(i) for i in config.servo_bus.ids])
    opener = open_in_memory if options.virtual_time else open_virtual
    return opener(
        config,
        seed=options.seed,
        armed=plan.armed,
        with_forces=with_forces,
        scenario=scenario,
        tap=tap,
    )


def _operator(
    plan: Drive, controller: Controller, interrupts: Interrupts, stack: ExitStack
) -> Operator:
    options = plan.options
    if options.teleop:
        keys = stack.enter_context(Keys())
        start = Wish(Intent.STAND, plan.gait, plan.frequency_hz, options.steer)
        return KeyboardOperator(keys, start, controller.book, interrupts, options.deadman_s)
    cycles = options.cycles
    if cycles is None and options.duration_s is None and plan.armed:
        cycles = DEFAULT_CYCLES
    script = Script(
        gait=plan.gait,
        frequency_hz=plan.frequency_hz,
        steer=options.steer,
        cycles=cycles,
        duration_s=options.duration_s,
        listen=not plan.armed,
    )
    return ScriptedOperator(script, interrupts)


def _open_log(plan: Drive, rig: Rig, controller: Controller) -> LogWriter | BackgroundWriter | None:
    if plan.log_path is None:
        return None
    options = plan.options
    try:
        plan.log_path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordError(
            f"the folder {plan.log_path.parent} cannot be made: {error.strerror}; choose another --log"
        ) from error
    keep_earlier(plan.log_path)
    start_unix_ns = VIRTUAL_EPOCH_UNIX_NS if options.virtual_time else time.time_ns()
    writer = LogWriter(
        plan.log_path,
        names=plan.config.parameters.legs.names,
        config_text=plan.config.text,
        metadata={
            "robot": plan.config.name,
            "hardware": options.hardware,
            "time": "virtual" if options.virtual_time else "real",
            "gait": plan.gait,
            "frequency_hz": f"{plan.frequency_hz:g}",
            "steer": f"{options.steer:g}",
            "seed": str(options.seed) if options.hardware == VIRTUAL else "",
            **controller_metadata(controller, rig.calibrations),
            **wire_metadata(rig, recorded=options.record_bytes),
            **({"scenario": options.scenario.name} if options.scenario is not None else {}),
            UNITS_KEY: units_text(plan.config.parameters.legs.names, rig.calibrations),
            "software": software(),
            **software_versions(),
        },
        start_ns=rig.clock.now_ns(),
        start_unix_ns=start_unix_ns,
    )
    return writer if options.virtual_time else BackgroundWriter(writer)


def software() -> str:
    """Return name and version of this program."""
    try:
        return f"bigant {version('bigant')}"
    except PackageNotFoundError:
        return "bigant (not installed)"


class TappedLog:
    """A log that takes what the tap heard along with every tick.

    Args:
        log: The log.
        tap: The tap.
    """

    def __init__(self, log: LogWriter | BackgroundWriter, tap: WireTap) -> None:
        self._log = log
        self._tap = tap

    @property
    def error(self) -> RecordError | None:
        """Why the log can no longer be written, None while it can."""
        return self._log.error

    def write(self, tick: Tick) -> None:
        """Write what was heard up to here, then the tick."""
        self._log.write_wires(self._tap.take())
        self._log.write(tick)

    def close(self) -> None:
        """Write what was heard since the last tick (torque going off) and finish."""
        self._log.write_wires(self._tap.take())
        self._log.close()


def _close_log(sink: LogWriter | BackgroundWriter | TappedLog | None) -> str:
    if sink is None:
        return ""
    try:
        sink.close()
    except RecordError as error:
        return str(error)
    return "" if sink.error is None else str(sink.error)


def _say(plan: Drive, result: RunResult, log_error: str) -> ExitCode:
    code = exit_code_of(result.reason)
    words = result.reason.name.lower().replace("_", " ")
    torque = "torque off" if result.torque_off else "TORQUE NOT CONFIRMED OFF: cut the power"
    why = f": {result.detail}" if result.detail else ""
    if code is not ExitCode.OK:
        complain(f"bigant drive: stopped ({words}){why}; {torque}")
    if not result.torque_off:
        code = ExitCode.HARDWARE
    if log_error:
        complain(f"bigant drive: {log_error}")
        code = ExitCode.LOG if code is ExitCode.OK else code
    try:
        if exit_code_of(result.reason) is ExitCode.OK:
            print(f"done ({words}), {torque}", flush=True)
        if plan.log_path is not None and not log_error:
            _print_summary(plan.log_path)
        elif result.last is not None:
            _print_pose(result.last)
        sys.stdout.flush()
    except OSError:  # whoever read our output went away; how the run ended is not lost
        complain(f"bigant drive: {words}, {torque}; log: {plan.log_path or 'none'}")
        stop_output()
    return code


def _print_pose(tick: Tick) -> None:
    pose = tick.estimate if tick.estimate is not None else tick.dead_reckoning
    name = "estimate" if tick.estimate is not None else "dead reckoning"
    x, y = pose.position_m
    print(f"{name}: x {x:.3f} m, y {y:.3f} m, yaw {pose.yaw_rad:.3f} rad")


def _print_summary(path: Path) -> None:
    from robot.console.screen_fit import columns_of
    from robot.report.long_log import read_summary
    from robot.report.summary_text import summary_lines

    summary, _ = read_summary(path)
    for line in summary_lines(summary, columns_of(sys.stdout)):
        print(line)
    print(f"log: {path}   (bigant show {path})")
