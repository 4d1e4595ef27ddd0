"""One run: open the robot, run the loop, keep the log, say how it went."""

import sys
from contextlib import ExitStack
from pathlib import Path

from drivers.wire.tap import WireTap
from model.errors import RecordError
from model.values.tick import Tick
from record.log.background import BackgroundWriter
from record.log.header import RunHeader
from record.log.writer import LogWriter
from robot.console.busy_computer import busy_words
from robot.console.earlier_file import keep_earlier
from robot.console.exit_codes import ExitCode
from robot.console.program_output import complain, stop_output
from robot.console.screen_fit import columns_of
from robot.control.controller import Controller
from robot.control.stops import STOPS
from robot.control.true_readings import true_forces_of
from robot.drive.access import open_robot
from robot.drive.request import DrivePlan, DriveRequest, plan_of
from robot.report.long_log import read_summary
from robot.report.summary_text import summary_lines
from robot.run.log import TappedLog, open_log
from robot.run.loop import RunResult, run_undisturbed
from robot.run.operator import Interrupts
from robot.run.rig import Rig
from robot.view.screen import open_view


def drive(request: DriveRequest) -> ExitCode:
    """Run ``bigant drive``.

    Raises:
        BigantError: Something is wrong before the robot moves.
    """
    return drive_plan(plan_of(request))


def drive_plan(plan: DrivePlan) -> ExitCode:
    """Open the robot of a plan, run it, keep its log and say how it went.

    Raises:
        BigantError: Something is wrong before the robot moves.
    """
    config, access = plan.config, plan.access
    tap = WireTap() if access.record_bytes else None
    with ExitStack() as stack:
        interrupts = stack.enter_context(Interrupts())
        rig = open_robot(config, access, tap)
        stack.callback(rig.close)
        for warning in rig.report.warnings:
            print(f"warning: {warning}", file=sys.stderr)
        controller = Controller(config, rig.calibrations, armed=access.armed, rate_hz=plan.rate_hz)
        operator = plan.operator_of(controller, interrupts, stack)
        log = _open_log(plan, rig, controller)
        sink = log if log is None or tap is None else TappedLog(log, tap)
        title = f"{config.name}  {access.hardware}" + ("" if access.armed else "  (readonly)")
        view = open_view(
            config.parameters.legs.names, title, plan.keys, true_forces=true_forces_of(config)
        )
        stack.callback(view.close)
        try:
            result = run_undisturbed(rig, controller, operator, sink, view)
        finally:
            log_error = _close_log(sink)
    code = _say(plan.log, result, log_error)
    busy = busy_words(result.missed, result.ticks, virtual=access.virtual)
    if busy and not access.virtual_time:
        print(busy, file=sys.stderr)
    return code


def _open_log(
    plan: DrivePlan, rig: Rig, controller: Controller
) -> LogWriter | BackgroundWriter | None:
    if plan.log is None:
        return None
    access, walk = plan.access, plan.walk
    try:
        plan.log.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordError(
            f"the folder {plan.log.parent} cannot be made: {error.strerror}; choose another --log"
        ) from error
    keep_earlier(plan.log)
    header = RunHeader(
        robot=plan.config.name,
        hardware=access.hardware,
        time="virtual" if access.virtual_time else "real",
        gait=walk.gait,
        frequency_hz=walk.frequency_hz,
        steer=walk.steer,
        seed=access.seed if access.virtual else None,
        scenario=access.scenario.name if access.scenario is not None else "",
    )
    writer = open_log(plan.log, header, rig, controller, with_bytes=access.record_bytes)
    return writer if access.virtual_time else BackgroundWriter(writer)


def _close_log(sink: LogWriter | BackgroundWriter | TappedLog | None) -> str:
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
            for line in summary_lines(summary, columns_of(sys.stdout)):
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
    pose = tick.odometry if tick.odometry is not None else tick.estimate
    x, y = pose.position_m
    print(f"odometry: x {x:.3f} m, y {y:.3f} m, yaw {pose.yaw_rad:.3f} rad")
