"""``bigant check``: servos, force-torque unit, computer and loop of one robot, looked at in this order."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path

from drivers.ati.settings import ForceSensorSettings
from drivers.clock import MonotonicClock
from drivers.dynamixel.bus import ServoBus
from model.errors import BigantError, ConfigError, ConnectionLost
from record.whole_file import write_text
from robot.bringup.preflight.computer import host_settings, software_findings
from robot.bringup.preflight.design import design_findings
from robot.bringup.preflight.doctor import check_computer
from robot.bringup.preflight.finding import (
    COMPUTER,
    FORCE_UNIT,
    IMU,
    LOOP,
    ROBOT_FILE,
    SERVOS,
    Finding,
    count_line,
    exit_code,
    failed,
    in_part,
    listed,
    plain_findings,
    skipped,
)
from robot.bringup.preflight.forces import force_findings
from robot.bringup.preflight.imu import NAME as IMU_NAME
from robot.bringup.preflight.imu import imu_findings
from robot.bringup.preflight.loop import LoopFigures, loop_finding, run_loop
from robot.bringup.preflight.servo_figures import ServoFigures
from robot.bringup.preflight.servos import servo_findings
from robot.bringup.servo.access import bus_of
from robot.config.imu import ImuConfig
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.progress import StatusLine
from robot.design.review import review_for_run
from robot.report.run_date import utc_words
from robot.requests.single import VIRTUAL, CheckRequest
from robot.run.force_unit import NO_UNIT, check_no_unit, open_force_links, wanted_unit, why_no_unit
from robot.run.hardware import open_imu, open_real
from robot.virtual.open import start_virtual

LISTEN_S = 3.0
PERCENTILES = ("p50", "p95", "p99", "max")


@dataclass(frozen=True, slots=True)
class Target:
    """The robot that is looked at.

    Attributes:
        config: Robot file.
        port: Serial port.
        unit: Force-torque unit, None to leave it out.
        armed: Whether torque may be switched on for the proof of the watchdog.
        imu: Where its IMU is; None where it has none.
    """

    config: RobotConfig
    port: str
    unit: ForceSensorSettings | None
    armed: bool
    imu: ImuConfig | None = None


def check(request: CheckRequest) -> ExitCode:
    """Look at everything and print the list.

    Returns:
        OK, or VERDICT_FAILED when something failed.

    Raises:
        BigantError: The robot file or an argument cannot be used.
    """
    if request.computer:
        if request.html is not None or request.loop is not None:
            raise ConfigError("--computer", "takes neither --html nor --loop; leave them out")
        return check_computer(request)
    if request.html is not None and request.html.suffix != ".html":
        raise ConfigError("--html", f"must end in .html, not {request.html.name!r}")
    figures, servos = list[LoopFigures](), ServoFigures()
    with ExitStack() as stack, StatusLine() as status:
        target = _target(request, stack)
        looking = _findings(target, request.loop, figures, servos, status)
        findings = listed(looking, status, quiet=request.json)
    print_result(_as_json(findings, figures), [count_line(findings)], as_json=request.json)
    if request.html is not None:
        from robot.bringup.preflight.page import CheckedRobot, check_page  # draws

        robot = CheckedRobot(target.config, request.hardware, _short(request.robot))
        page = check_page(robot, findings, figures, servos, date=utc_words(time.time_ns()))
        write_text(request.html, page, "--html")
        if not request.json:
            print(f"page: {request.html}")
    return exit_code(findings)


def _short(path: Path) -> str:
    """Return a path relative to the working folder, if it lies below it."""
    here = Path.cwd()
    return str(path.relative_to(here) if path.is_relative_to(here) else path)


def _target(request: CheckRequest, stack: ExitStack) -> Target:
    config = load_robot(request.robot)
    if request.hardware == VIRTUAL:
        check_no_unit(request.force_unit)
        devices, unit = start_virtual(config)
        stack.callback(devices.close)
        used = None if request.force_unit == NO_UNIT or not config.force_sensor.any else unit
        imu = None
        if devices.addresses.imu_port:
            imu = replace(config.imu, udp_port=0, port=devices.addresses.imu_port)
        return Target(config, devices.addresses.servo_port, used, armed=True, imu=imu)
    real = wanted_unit(request.force_unit, config.force_sensor)
    imu = config.imu if config.imu.any else None
    return Target(config, request.hardware, real, request.armed, imu)


def _findings(
    target: Target,
    loop_s: float | None,
    figures: list[LoopFigures],
    servos: ServoFigures,
    status: StatusLine,
) -> Iterator[Finding]:
    yield from in_part(COMPUTER, software_findings())
    yield from in_part(ROBOT_FILE, design_findings(review_for_run(target.config)))
    status.step("looking at the servos ...")
    with closing(bus_of(target.port, None, target.config)) as bus:
        yield from in_part(SERVOS, _servo_findings(bus, target, servos))
    if target.unit is None:
        why = why_no_unit(target.config.force_sensor)
        yield from in_part(FORCE_UNIT, [skipped("force unit", why)])
    else:
        status.step(f"listening to the force-torque unit, {LISTEN_S:g} s ...")
        yield from in_part(FORCE_UNIT, _force_findings(target.unit))
    if target.imu is not None:
        status.step(f"listening to the IMU, {LISTEN_S:g} s ...")
        yield from in_part(IMU, _imu_findings(target.imu))
    if loop_s is not None:
        yield from in_part(LOOP, [_loop_finding(target, loop_s, figures, status)])


def _servo_findings(bus: ServoBus, target: Target, figures: ServoFigures) -> Iterator[Finding]:
    try:
        yield from servo_findings(bus, target.config, armed=target.armed, figures=figures)
    except ConnectionLost as error:
        yield failed("port", str(error), "put the cable back and check again")


def _force_findings(unit: ForceSensorSettings) -> Iterator[Finding]:
    clock = MonotonicClock()
    yield from force_findings(
        lambda: open_force_links(unit, clock),
        unit,
        clock,
        seconds=LISTEN_S,
        unix_offset_ns=time.time_ns() - clock.now_ns(),
    )


def _imu_findings(imu: ImuConfig) -> Iterator[Finding]:
    clock = MonotonicClock()
    try:
        listener = open_imu(imu, clock)
    except ConfigError as error:
        yield failed(IMU_NAME, str(error), "plug it in, or correct its port in the robot file")
        return
    with closing(listener):
        yield from imu_findings(listener, imu, clock, LISTEN_S)


def _loop_finding(
    target: Target, seconds: float, figures: list[LoopFigures], status: StatusLine
) -> Finding:
    try:
        rig = open_real(target.config, target.port, target.unit, armed=False)
    except BigantError as error:
        return failed("loop", f"not run: {error}", "first fix the failures above")
    with closing(rig):

        def show(ticks: int) -> None:
            status.step(f"the loop without torque, {seconds:g} s: {ticks} ticks ...")

        result = run_loop(rig, target.config, seconds, show)
        figures.append(result)
        host = host_settings(rig.bus.latency_timer_ms)
    return loop_finding(result, host, target.config.loop.late_limit_s)


def _as_json(findings: list[Finding], figures: list[LoopFigures]) -> dict[str, object]:
    result = plain_findings(findings)
    for loop in figures:
        result["loop"] = {
            "period_ms": loop.period_ms,
            "ticks": loop.ticks,
            "missed": loop.missed,
            "late_ticks": loop.late_ticks,
            "late_ms": dict(zip(PERCENTILES, loop.late_ms, strict=True)),
            "busy_ms": dict(zip(PERCENTILES, loop.busy_ms, strict=True)),
            "ended": loop.reason.name.lower(),
        }
    return result
