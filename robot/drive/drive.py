"""One run: open the robot, run the loop, keep the log, say how it went."""

import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeAlias

from drivers.lines.poses import PoseListener
from drivers.wire.tap import WireTap
from model.errors import ConfigError, RecordError
from model.values.faults import StopReason
from model.values.tick import Intent, Request, Tick
from record.log.background import BackgroundWriter
from record.log.header import RunHeader
from record.log.writer import LogWriter
from robot.config.imu import ImuConfig
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.exit_codes import ExitCode
from robot.console.program_output import complain, stop_output
from robot.console.screen_fit import columns_of
from robot.console.table import row_lines
from robot.control.controller import Controller
from robot.control.effect_uses import true_forces_of, unused_notes
from robot.control.stops import STOPS
from robot.design.review import (
    log_warnings,
    print_warnings,
    refuse_impossible,
    review_for_run,
)
from robot.drive.gait_choice import gait_of
from robot.drive.log_process import BesideRun, LogProcess, RunView, worth_a_process
from robot.report.summary import read_summary
from robot.report.summary_text import busy_words, summary_rows
from robot.requests.single import DriveRequest
from robot.run.force_unit import NO_UNIT, check_no_unit, wanted_unit
from robot.run.hardware import imu_place, open_imu, open_real
from robot.run.header import RunLog, TappedLog, open_log
from robot.run.loop import Operator, RunResult, no_full_collection, run
from robot.run.operator import Interrupts, Script, ScriptedOperator
from robot.run.rig import Rig
from robot.run.teleop import KeyboardOperator, Keys, help_line
from robot.view.screen import open_view

DEFAULT_CYCLES = 3.0
NO_LOG = "none"
KEYS = "Ctrl-C: stop on all feet; twice: cut torque"
# Makes the operator of a run once the robot is open; what it has to give back goes on the stack.
OperatorOf: TypeAlias = Callable[[Controller, Interrupts, ExitStack], Operator]


def drive(request: DriveRequest) -> ExitCode:
    """Run ``bigant drive``.

    Raises:
        BigantError: Something is wrong before the robot moves.
    """
    config = load_robot(request.robot, request.calibration)
    for note in unused_notes(config.effects):
        complain(note)
    config, name, frequency_hz = gait_of(request, config)
    # the first controller of a process compiles; nothing may wait for that once the bus is open
    Controller(config, (), armed=False)
    check_hardware(request)
    if request.virtual_time and (request.pose_udp or config.estimator.pose_port):
        raise ConfigError(
            "--pose-udp", "cannot be received in virtual time; leave --virtual-time out"
        )
    if request.virtual_time and request.imu not in {None, NO_UNIT}:
        raise ConfigError("--imu", "cannot be received in virtual time; leave --virtual-time out")
    if request.rate_hz is not None and config.servo_bus.watchdog_s < 3 / request.rate_hz:
        raise ConfigError(
            "--rate-hz",
            f"{request.rate_hz} is too slow for the servos' watchdog of "
            f"{config.servo_bus.watchdog_s:g} s, which has to last three periods",
        )
    if request.readonly and request.armed:
        raise ConfigError("--armed", "and --readonly exclude each other; choose one")
    if request.record_bytes and request.log == NO_LOG:
        raise ConfigError("--record-bytes", "needs a log; leave out --log none")
    armed = not request.readonly and (request.virtual or request.armed)
    log = None if request.log == NO_LOG else Path(request.log or usual_log(name or "listen"))
    cycles = request.cycles
    if cycles is None and request.duration_s is None and armed:
        cycles = DEFAULT_CYCLES
    decided = replace(request, gait=name, frequency_hz=frequency_hz, cycles=cycles, armed=armed)
    return drive_as(decided, config, log, partial(_operator, decided, name, frequency_hz))


def usual_log(name: str) -> Path:
    """Return the usual place of a log: in ``runs/``, with the time of day in its name."""
    return Path("runs") / f"{name}-{time.strftime('%Y%m%dT%H%M%S')}.mcap"


def drive_as(
    request: DriveRequest, config: RobotConfig, log_path: Path | None, operator_of: OperatorOf
) -> ExitCode:
    """Open the robot of a run, run it, keep its log and say how it went.

    Args:
        request: The run, with ``armed``, ``gait`` and ``frequency_hz`` decided.
        config: Robot file.
        log_path: Where the log goes, None for no log.
        operator_of: Makes the operator once the robot is open.

    Raises:
        BigantError: Something is wrong before the robot moves.
    """
    warnings = _design_warnings(request, config) if request.armed else ""
    tap = WireTap() if request.record_bytes else None
    with ExitStack() as stack:
        interrupts = stack.enter_context(Interrupts())
        rig = open_robot(config, request, tap)
        stack.callback(rig.close)
        pose_port = request.pose_udp or config.estimator.pose_port
        if pose_port:
            rig.listen(PoseListener(pose_port, rig.clock, time.time_ns()))
        imu = _imu_to_open(request, config.imu)
        if imu is not None:
            rig.listen_to_imu(open_imu(imu, rig.clock, "--imu" if request.imu else "imu"))
        for warning in rig.warnings:
            complain(f"warning: {warning}")
        beside = log_path is not None and _worth_a_process(request, config)
        controller = Controller(
            config,
            rig.calibrations,
            armed=request.armed,
            rate_hz=request.rate_hz,
            estimate=not beside,
        )
        operator = operator_of(controller, interrupts, stack)
        title = f"{config.name}  {request.hardware}" + ("" if request.armed else "  (readonly)")
        view_of = partial(
            open_view,
            config.parameters.names,
            title,
            help_line(controller.book) if request.teleop else KEYS,
            true_forces=true_forces_of(config),
        )
        log: RunLog | None = None
        view: RunView | None = None
        if log_path is not None:
            header = _header(request, config, warnings)
            log_of = partial(_open_log, log_path, header, rig, controller, request)
            if beside:
                log = LogProcess(BesideRun(config, controller.book.gaits, log_of, view_of))
                stack.callback(log.close)
            else:
                log = log_of() if request.virtual_time else BackgroundWriter(log_of())
        if not beside:
            view = view_of()
            stack.callback(view.close)
        sink = log if log is None or tap is None else TappedLog(log, tap)
        try:
            interrupts.begin()
            with no_full_collection():
                result = run(rig, controller, operator, sink, view, states=sink)
        finally:
            log_error = _close_log(sink)
    code = _say(log_path, result, log_error)
    busy = busy_words(result.missed, result.ticks, virtual=request.virtual)
    if busy and not request.virtual_time:
        complain(busy)
    return code


def _imu_to_open(request: DriveRequest, imu: ImuConfig) -> ImuConfig | None:
    """Return the IMU that is to be opened here; None for none, or where the virtual robot has its own."""
    if request.imu == NO_UNIT:
        return None
    if request.imu is not None:
        return imu_place(request.imu, imu)
    return None if request.virtual or not imu.any else imu


def _design_warnings(request: DriveRequest, config: RobotConfig) -> str:
    """Print what is wrong with the robot file for this run, as the model has it; return it for the log.

    Raises:
        ConfigError: The robot cannot stand.
    """
    gait = None if request.teleop else request.gait or ""  # at the keys any gait may be chosen
    review = review_for_run(config, gait, request.frequency_hz)
    refuse_impossible(review)
    print_warnings(review)
    return log_warnings(review)


def check_hardware(request: DriveRequest) -> None:
    """Refuse what the robot asked for cannot have.

    Raises:
        ConfigError: It makes no sense.
    """
    if request.virtual:
        check_no_unit(request.force_unit)
    elif request.virtual_time:
        raise ConfigError(
            "--virtual-time", "needs --hardware virtual; real servos live in real time"
        )
    elif request.scenario is not None:
        raise ConfigError(
            "--scenario", "needs --hardware virtual; faults are put on virtual devices only"
        )


def open_robot(config: RobotConfig, request: DriveRequest, tap: WireTap | None) -> Rig:
    """Open the robot of a run.

    Args:
        config: Robot file.
        request: The run, ``armed`` decided.
        tap: Listens in on all wires, from the first byte on; None for nobody.

    Raises:
        BigantError: It cannot be opened.
    """
    if not request.virtual:
        unit = wanted_unit(request.force_unit, config.force_sensor)
        return open_real(config, request.hardware, unit, armed=request.armed, tap=tap)
    # here, so that the simulator is not in the process that drives a real robot
    from robot.virtual.open import VirtualSettings, open_in_memory, open_virtual
    from sim_hw.faults.scenario import load_scenario

    scenario = None
    if request.scenario is not None:
        scenario = load_scenario(request.scenario, [int(i) for i in config.servo_bus.ids])
    settings = VirtualSettings(
        request.seed,
        request.armed,
        request.force_unit != NO_UNIT,
        scenario,
        tap,
        with_imu=request.imu is None,
    )
    return (open_in_memory if request.virtual_time else open_virtual)(config, settings)


def _operator(
    request: DriveRequest,
    gait: str,
    frequency_hz: float,
    controller: Controller,
    interrupts: Interrupts,
    stack: ExitStack,
) -> Operator:
    if request.teleop:
        keys = stack.enter_context(Keys())
        start = Request(Intent.STAND, gait, frequency_hz, request.steer, StopReason.NONE)
        return KeyboardOperator(keys, start, controller.book, interrupts, request.deadman_s)
    script = Script(
        gait=gait,
        frequency_hz=frequency_hz,
        steer=request.steer,
        cycles=request.cycles,
        duration_s=request.duration_s,
        listen=not request.armed,
    )
    return ScriptedOperator(script, interrupts)


def _header(request: DriveRequest, config: RobotConfig, warnings: str) -> RunHeader:
    return RunHeader(
        robot=config.name,
        hardware=request.hardware,
        time="virtual" if request.virtual_time else "real",
        gait=request.gait or "",
        frequency_hz=request.frequency_hz,
        steer=request.steer,
        seed=request.seed if request.virtual else None,
        scenario=request.scenario.name if request.scenario is not None else "",
        warnings=warnings,
    )


def _open_log(
    path: Path, header: RunHeader, rig: Rig, controller: Controller, request: DriveRequest
) -> LogWriter:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordError(
            f"the folder {path.parent} cannot be made: {error.strerror}; choose another --log"
        ) from error
    return open_log(path, header, rig, controller, with_bytes=request.record_bytes)


def _worth_a_process(request: DriveRequest, config: RobotConfig) -> bool:
    """Tell whether the estimator, the log and the view are worth a process of their own."""
    if not request.virtual_time or request.teleop:
        return False
    expected_s = request.duration_s
    if expected_s is None and request.cycles is not None and request.frequency_hz:
        expected_s = request.cycles / request.frequency_hz
    return worth_a_process(config, expected_s)


def _close_log(sink: RunLog | TappedLog | None) -> str:
    """Close the log; return what went wrong with it, empty if nothing did."""
    if sink is None:
        return ""
    try:
        sink.close()
    except RecordError as error:
        return str(error)
    return "" if sink.error is None else str(sink.error)


def _say(log: Path | None, result: RunResult, log_error: str) -> ExitCode:
    """Say how the run went; return the exit code."""
    code = ended_as = STOPS[result.reason].exit_code
    words = result.reason.name.lower().replace("_", " ")
    torque = "torque off" if result.torque_off else "TORQUE NOT CONFIRMED OFF: cut the power"
    why = f": {result.detail}" if result.detail else ""
    if ended_as is not ExitCode.OK:
        complain(f"bigant drive: stopped ({words}){why}; {torque}")
    if not result.torque_off:
        code = ExitCode.HARDWARE
    if log_error:
        complain(f"bigant drive: {log_error}")
        code = ExitCode.LOG if code is ExitCode.OK else code
    try:
        if ended_as is ExitCode.OK:
            print(f"done ({words}), {torque}", flush=True)
        if log is not None and not log_error:
            summary, _ = read_summary(log)
            for line in row_lines(summary_rows(summary), columns_of(sys.stdout)):
                print(line)
            print(f"log: {log}   (bigant show {log})")
        elif result.last is not None:
            _print_pose(result.last)
        sys.stdout.flush()
    except OSError:  # whoever read our output went away; how the run ended is not lost
        complain(f"bigant drive: {words}, {torque}; log: {log or 'none'}")
        stop_output()
    return code


def _print_pose(tick: Tick) -> None:
    pose = tick.estimate if tick.estimate is not None else tick.dead_reckoning
    x, y = pose.position_m
    source = "estimate" if tick.estimate is not None else "dead reckoning"
    print(f"{source}: x {x:.3f} m, y {y:.3f} m, yaw {pose.yaw_rad:.3f} rad")
