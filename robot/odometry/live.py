"""``bigant odom --live``: the estimator beside a run, while it goes on; nothing is moved, nothing touched.

It follows LOG, or the newest log in ``runs/``, which another controller is writing, half a second behind.
With --hardware, it reads servos and forces itself and never asks for torque.
"""

import argparse
import json
import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TextIO

import numpy as np

from drivers.clock import MonotonicClock
from model.errors import ConfigError, RecordError
from model.estimator.settings import EstimatorSettings
from model.kinematics.four_bar import Linkage
from model.values.estimate import OdometryEstimate
from model.values.faults import StopReason
from model.values.legs import FootForces
from model.values.tick import Tick
from record.log.follow import LogFollower
from record.log.reader import LogContents
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.console.exit_codes import ExitCode
from robot.console.plain_json import plain
from robot.control.controller import Controller
from robot.control.estimator_stage import OdometryStage
from robot.control.file_model import odometry_stage
from robot.control.stops import STOPS
from robot.run.force_unit import NO_UNIT, check_no_unit, unit_settings
from robot.run.hardware import open_real
from robot.run.loop import run
from robot.run.operator import Interrupts, Script, ScriptedOperator
from robot.view.log_source import newest_log
from robot.virtual.open import VirtualSettings, open_virtual

VIRTUAL = "virtual"
LOOK_PERIOD_NS = 200_000_000
LINE_PERIOD_NS = 1_000_000_000


class Said:
    """Takes estimates: a line a second, and every one of them into a trajectory.

    Args:
        out: File of lines ``t x y z qx qy qz qw``, None for none.
        as_json: Lines as JSON.
    """

    error: RecordError | None = None

    def __init__(self, out: TextIO | None, *, as_json: bool) -> None:
        self._out = out
        self._json = as_json
        self._next_ns = 0
        self._first_ns: int | None = None
        self.count = 0

    def take(self, said: OdometryEstimate) -> None:
        """Take one."""
        if self._first_ns is None:
            self._first_ns = self._next_ns = said.t_ns
        self.count += 1
        if self._out is not None:
            x, y = said.position_m
            half = said.yaw_rad / 2
            self._out.write(
                f"{said.t_ns * 1e-9:.9f} {x:.9f} {y:.9f} 0 0 0 {np.sin(half):.9f} {np.cos(half):.9f}\n"
            )
        if said.t_ns >= self._next_ns:
            self._next_ns = said.t_ns + LINE_PERIOD_NS
            seconds = (said.t_ns - self._first_ns) * 1e-9
            print(_json_line(said) if self._json else _line(said, seconds), flush=True)
            if self._out is not None:
                self._out.flush()

    def write(self, tick: Tick) -> None:
        """Take the estimate of a tick: as a log does, for the loop."""
        if tick.odometry is not None:
            self.take(tick.odometry)


def run_live(options: argparse.Namespace) -> ExitCode:
    """Run ``bigant odom --live``.

    Raises:
        BigantError: Nothing to follow, or a robot that does not answer.
    """
    if options.logs and options.hardware:
        raise ConfigError("--live", "follows a LOG or reads --hardware PORT; give one of them")
    if not (options.logs or options.hardware):
        options.logs = [newest_log()]
        print(f"following {options.logs[0]}; Ctrl-C ends this, not the run", file=sys.stderr)
    with ExitStack() as stack:
        out = None
        if options.out is not None:
            if options.out.suffix != ".tum":
                raise ConfigError(
                    "--out", f"must end in .tum with --live, not {options.out.name!r}"
                )
            try:
                out = stack.enter_context(options.out.open("w", encoding="utf-8"))
            except OSError as error:
                raise RecordError(f"{options.out} cannot be written: {error.strerror}") from error
        said = Said(out, as_json=options.json)
        interrupts = stack.enter_context(Interrupts())
        if options.hardware:
            return _beside_hardware(options, said, interrupts, stack)
        _beside_log(options, said, interrupts)
    if said.count == 0:
        raise RecordError(
            f"{options.logs[0]} holds no ticks yet; is it the log of a running drive?"
        )
    if not options.json:
        print(f"{said.count} ticks")
    return ExitCode.OK


def _beside_log(options: argparse.Namespace, said: Said, interrupts: Interrupts) -> None:
    path: Path = options.logs[0]
    clock = MonotonicClock()
    end_ns = None if options.duration is None else clock.now_ns() + round(options.duration * 1e9)
    beside: _Beside | None = None
    with LogFollower(path) as follower:
        while True:
            for stamped in follower.new_ticks():
                beside = beside or _Beside(options, follower.contents)
                said.take(beside.step(stamped.tick))
            now_ns = clock.now_ns()
            ended = interrupts.count > 0 or (end_ns is not None and now_ns >= end_ns)
            if follower.finished or ended:
                return
            clock.sleep_until_ns(now_ns + LOOK_PERIOD_NS)


class _Beside:
    """The estimator over the ticks of somebody else's loop."""

    def __init__(self, options: argparse.Namespace, contents: LogContents) -> None:
        self._stage = stage_of(options, _config(options, contents))
        self._memory = self._stage.initial()
        self._deaf = options.no_forces

    def step(self, tick: Tick) -> OdometryEstimate:
        forces = tick.forces
        if self._deaf:
            nothing = np.full_like(forces.force_n, np.nan)
            forces = FootForces(forces.t_ns, nothing, np.zeros(len(nothing), dtype=bool))
        self._memory, estimate = self._stage.step(
            self._memory, tick.t_ns, tick.joints, forces, tick.inputs.poses
        )
        return estimate


def _beside_hardware(
    options: argparse.Namespace, said: Said, interrupts: Interrupts, stack: ExitStack
) -> ExitCode:
    config = load_robot(options.robot) if options.robot is not None else load_robot()
    estimator = replace(config.estimator, enabled=True, settings=_settings(options, config))
    config = replace(config, estimator=estimator)
    with_forces = not options.no_forces and options.force_unit != NO_UNIT
    if options.hardware == VIRTUAL:
        check_no_unit(options.force_unit)
        rig = open_virtual(config, VirtualSettings(armed=False, with_forces=with_forces))
    else:
        unit = unit_settings(options.force_unit, config.force_sensor) if with_forces else None
        rig = open_real(config, options.hardware, unit, armed=False)
    stack.callback(rig.close)
    controller = Controller(config, rig.calibrations, armed=False)
    script = Script("tripod", 0.1, 0.0, None, options.duration, listen=True)
    result = run(rig, controller, ScriptedOperator(script, interrupts), said, None)
    if not options.json:
        print(f"{said.count} ticks, torque never asked for")
    if result.reason is StopReason.OPERATOR:
        return ExitCode.OK
    return STOPS[result.reason].exit_code


def _settings(options: argparse.Namespace, config: RobotConfig) -> EstimatorSettings:
    from model.quasistatic.frames import FrictionLaw

    settings = config.estimator.settings
    if options.law is not None:
        settings = replace(settings, law=FrictionLaw(options.law))
    return replace(settings, sway=False) if options.no_sway else settings


def stage_of(options: argparse.Namespace, config: RobotConfig) -> OdometryStage:
    """The estimator of a robot file with what the command line changes of it."""
    robot = config.parameters
    estimator = replace(config.estimator, settings=_settings(options, config))
    linkage = Linkage(robot.linkage, robot.legs.shaft_position)
    return odometry_stage(replace(config, estimator=estimator), linkage)


def _config(options: argparse.Namespace, contents: LogContents) -> RobotConfig:
    if options.robot is not None:
        return load_robot(options.robot)
    return parse_robot(contents.config_text) if contents.config_text else load_robot()


def _line(said: OdometryEstimate, seconds: float) -> str:
    x, y = said.position_m * 1e3
    sd_x, sd_y, sd_yaw = np.sqrt(np.diagonal(said.pose_covariance))
    vx, vy, turn = said.velocity_B
    why = f": {said.reason}" if said.reason else ""
    return (
        f"{seconds:7.2f} s  x {x:8.1f} +-{sd_x * 1e3:.1f}  y {y:7.1f} +-{sd_y * 1e3:.1f} mm  "
        f"yaw {np.degrees(said.yaw_rad):7.2f} +-{np.degrees(sd_yaw):.2f} deg  vx {vx * 1e3:6.1f} mm/s  "
        f"vy {vy * 1e3:6.1f}  turn {turn:7.4f} rad/s  {said.health.value}{why}"
    )


def _json_line(said: OdometryEstimate) -> str:
    return json.dumps(
        plain({
            "t_ns": said.t_ns,
            "position_m": said.position_m.tolist(),
            "yaw_rad": said.yaw_rad,
            "velocity": said.velocity_B.tolist(),
            "pose_covariance": said.pose_covariance.tolist(),
            "twist_covariance": said.twist_covariance.tolist(),
            "force_n": said.force_B.tolist(),
            "mu": said.mu.tolist(),
            "stiffness_n_m": said.stiffness.tolist(),
            "health": said.health.value,
            "reason": said.reason,
        })
    )  # fmt: skip
