"""What ``bigant drive`` is asked to do, and the run that comes of it, checked before anything is opened."""

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from gaits.limits import check_gait
from model.errors import ConfigError
from model.values.tick import Intent
from robot.config.robot_file import RobotConfig, load_robot
from robot.control.controller import Controller
from robot.control.effect_uses import say_unused
from robot.drive.access import VIRTUAL, RobotAccess
from robot.run.loop import Operator
from robot.run.operator import Interrupts, Script, ScriptedOperator
from robot.run.teleop import HELP, KeyboardOperator, Keys, Wish

DEFAULT_CYCLES = 3.0
NO_LOG = "none"
# Makes the operator of a run once the robot is open; what it has to give back goes on the stack.
OperatorOf: TypeAlias = Callable[[Controller, Interrupts, ExitStack], Operator]


@dataclass(frozen=True, slots=True)
class DriveRequest:
    """The options of ``bigant drive``, under their names; see ``robot.cli.drive``."""

    robot: Path
    calibration: Path | None
    gait: str
    cycles: float | None
    duration_s: float | None
    frequency_hz: float | None
    steer: float
    hardware: str
    force_unit: str | None
    log: str | None
    record_bytes: bool
    pose_udp: int | None
    readonly: bool
    armed: bool
    teleop: bool
    deadman_s: float
    rate_hz: int | None
    virtual_time: bool
    seed: int
    scenario: Path | None


@dataclass(frozen=True, slots=True)
class DrivePlan:
    """One run that can be done.

    Attributes:
        config: Robot file.
        access: Which robot, and how it is reached.
        walk: Gait to begin with, its frequency and steering.
        log: Where the log goes, None for no log.
        operator_of: Makes the operator once the robot is open.
        rate_hz: Rate of the loop, None for the robot file's.
        keys: What the keys do, for the screen.
    """

    config: RobotConfig
    access: RobotAccess
    walk: Script
    log: Path | None
    operator_of: OperatorOf
    rate_hz: int | None = None
    keys: str = "Ctrl-C: stop on all feet; twice: cut torque"


def plan_of(request: DriveRequest) -> DrivePlan:
    """Check a request.

    Raises:
        BigantError: It makes no sense.
    """
    config = load_robot(request.robot, request.calibration)
    say_unused(config)
    # the first controller of a process compiles; nothing may wait for that once the bus is open
    book = Controller(config, (), armed=False).book
    gait = book.gaits[request.gait]
    frequency_hz = request.frequency_hz if request.frequency_hz is not None else gait.frequency_hz
    check_gait(gait, frequency_hz, config.parameters.servo)
    access = RobotAccess(
        hardware=request.hardware,
        armed=not request.readonly and (request.hardware == VIRTUAL or request.armed),
        force_unit=request.force_unit,
        virtual_time=request.virtual_time,
        seed=request.seed,
        scenario=request.scenario,
        pose_udp=request.pose_udp,
        record_bytes=request.record_bytes,
    )
    access.check()
    if access.virtual_time and (access.pose_udp or config.estimator.pose_port):
        raise ConfigError(
            "--pose-udp", "cannot be received in virtual time; leave --virtual-time out"
        )
    if request.readonly and request.armed:
        raise ConfigError("--armed", "and --readonly exclude each other; choose one")
    if request.record_bytes and request.log == NO_LOG:
        raise ConfigError("--record-bytes", "needs a log; leave out --log none")
    cycles = request.cycles
    if cycles is None and request.duration_s is None and access.armed:
        cycles = DEFAULT_CYCLES
    walk = Script(
        gait=request.gait,
        frequency_hz=frequency_hz,
        steer=request.steer,
        cycles=cycles,
        duration_s=request.duration_s,
        listen=not access.armed,
    )
    log = _log_path(request)
    if not request.teleop:
        return DrivePlan(config, access, walk, log, scripted(walk), request.rate_hz)
    by_keys = _keyboard(walk, request.deadman_s)
    return DrivePlan(config, access, walk, log, by_keys, request.rate_hz, keys=HELP)


def _log_path(request: DriveRequest) -> Path | None:
    if request.log == NO_LOG:
        return None
    if request.log is not None:
        return Path(request.log)
    return runs_path(request.gait)


def runs_path(name: str) -> Path:
    """Return the usual place of a log: in ``runs/``, with the time of day in its name."""
    return Path("runs") / f"{name}-{time.strftime('%Y%m%dT%H%M%S')}.mcap"


def scripted(script: Script) -> OperatorOf:
    """Return what makes the operator of a script."""

    def operator(_: Controller, interrupts: Interrupts, __: ExitStack) -> Operator:
        return ScriptedOperator(script, interrupts)

    return operator


def _keyboard(walk: Script, deadman_s: float) -> OperatorOf:
    def operator(controller: Controller, interrupts: Interrupts, stack: ExitStack) -> Operator:
        keys = stack.enter_context(Keys())
        start = Wish(Intent.STAND, walk.gait, walk.frequency_hz, walk.steer)
        return KeyboardOperator(keys, start, controller.book, interrupts, deadman_s)

    return operator
