"""``bigant odom --live``: the estimator during a run; nothing is moved, nothing is written.

It follows LOG, or the newest log in ``runs/``, which another controller is writing, half a second behind.
With --hardware, it reads servos and forces itself and never asks for torque.
"""

import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from drivers.clock import MonotonicClock
from model.errors import RecordError
from model.values.estimate import Estimate, Health
from model.values.faults import StopReason
from model.values.tick import Tick
from record.log.follow import LogFollower
from record.log.tum import TumFile
from robot.console.exit_codes import ExitCode
from robot.console.json_output import json_text
from robot.console.program_output import complain
from robot.control.controller import Controller
from robot.control.stops import STOPS
from robot.odometry.health import LOST_SHARE
from robot.odometry.request import believed_robot
from robot.odometry.track import Tracker
from robot.requests.recorded import OdomRequest
from robot.requests.single import VIRTUAL
from robot.run.force_unit import NO_UNIT, check_no_unit, wanted_unit
from robot.run.hardware import open_imu, open_real
from robot.run.loop import run
from robot.run.operator import Interrupts, ScriptedOperator, listening
from robot.view.log_source import newest_log
from robot.virtual.open import VirtualSettings, open_virtual

LOOK_PERIOD_NS = 200_000_000
LINE_PERIOD_NS = 1_000_000_000


class EstimateLines:
    """Prints a line of text or JSON a second, and writes every estimate into a trajectory, if any.

    Attributes:
        offset_ns: UNIX time less the loop's clock, for estimates that come with their tick alone.
        count: How many there were.
        lost: In how many of them the estimator was lost.
    """

    error: RecordError | None = None

    def __init__(self, out: TumFile | None, *, as_json: bool) -> None:
        self._out = out
        self._json = as_json
        self._next_ns = 0
        self._first_ns: int | None = None
        self.offset_ns = 0
        self.count = self.lost = 0

    def take(self, unix_ns: int, estimate: Estimate) -> None:
        """Take one."""
        if self._first_ns is None:
            self._first_ns = self._next_ns = unix_ns
        self.count += 1
        self.lost += estimate.health is Health.LOST
        if self._out is not None:
            self._out.write(unix_ns, np.array([*estimate.position_m, estimate.yaw_rad]))
        if unix_ns >= self._next_ns:
            self._next_ns = unix_ns + LINE_PERIOD_NS
            seconds = (unix_ns - self._first_ns) * 1e-9
            print(_json_line(estimate) if self._json else _line(estimate, seconds), flush=True)
            if self._out is not None:
                self._out.flush()

    @property
    def verdict(self) -> ExitCode:
        """How a run of these estimates ends: one that was lost most of the time is no good."""
        if self.lost <= LOST_SHARE * self.count:
            return ExitCode.OK
        complain(f"the estimator was lost in {100 * self.lost / self.count:.0f} % of the ticks")
        return ExitCode.VERDICT_FAILED

    def write(self, tick: Tick) -> None:
        """Take the estimate of a tick: as a log does, for the loop."""
        if tick.estimate is not None:
            self.take(tick.t_ns + self.offset_ns, tick.estimate)


def run_live(request: OdomRequest) -> ExitCode:
    """Run ``bigant odom --live``.

    Raises:
        BigantError: Nothing to follow, or a robot that does not answer.
    """
    with ExitStack() as stack:
        path = None
        if request.hardware is None:
            path = request.logs[0] if request.logs else newest_log()
            if not request.logs:
                complain(f"following {path}; Ctrl-C ends this, not the run")
        out = None
        if request.out is not None:
            out = stack.enter_context(TumFile(request.out, growing=True))
        lines = EstimateLines(out, as_json=request.json)
        interrupts = stack.enter_context(Interrupts())
        if path is None:
            return _beside_hardware(request, lines, interrupts, stack)
        _beside_log(path, request, lines, interrupts)
    if lines.count == 0:
        raise RecordError(f"{path} holds no ticks yet; is it the log of a running drive?")
    if not request.json:
        print(f"{lines.count} ticks")
    return lines.verdict


def _beside_log(
    path: Path, request: OdomRequest, lines: EstimateLines, interrupts: Interrupts
) -> None:
    clock = MonotonicClock()
    end_ns = None if request.duration is None else clock.now_ns() + round(request.duration * 1e9)
    tracker: Tracker | None = None
    interrupts.begin()
    with LogFollower(path) as follower:
        while True:
            for stamped in follower.new_ticks():
                if tracker is None:
                    config = believed_robot(request, follower.contents.config_text)
                    tracker = Tracker(config, no_forces=request.no_forces, no_imu=request.no_imu)
                lines.take(stamped.unix_ns, tracker.step(stamped.tick.sensed))
            now_ns = clock.now_ns()
            ended = interrupts.count > 0 or (end_ns is not None and now_ns >= end_ns)
            if follower.finished or ended:
                return
            clock.sleep_until_ns(now_ns + LOOK_PERIOD_NS)


def _beside_hardware(
    request: OdomRequest, lines: EstimateLines, interrupts: Interrupts, stack: ExitStack
) -> ExitCode:
    config = believed_robot(request)
    with_forces = not request.no_forces and request.force_unit != NO_UNIT
    if request.hardware == VIRTUAL:
        check_no_unit(request.force_unit)
        settings = VirtualSettings(
            armed=False, with_forces=with_forces, with_imu=not request.no_imu
        )
        rig = open_virtual(config, settings)
    else:
        assert request.hardware is not None  # asked only with one
        unit = wanted_unit(request.force_unit, config.force_sensor) if with_forces else None
        rig = open_real(config, request.hardware, unit, armed=False)
        if config.imu.any and not request.no_imu:
            rig.listen_to_imu(open_imu(config.imu, rig.clock))
    stack.callback(rig.close)
    lines.offset_ns = time.time_ns() - rig.clock.now_ns()
    controller = Controller(config, rig.calibrations, armed=False)
    script = listening(request.duration)
    interrupts.begin()
    result = run(rig, controller, ScriptedOperator(script, interrupts), lines, None)
    if not request.json:
        print(f"{lines.count} ticks, torque never asked for")
    if result.reason is StopReason.OPERATOR:
        return lines.verdict
    return STOPS[result.reason].exit_code


def _line(estimate: Estimate, seconds: float) -> str:
    x, y = estimate.position_m * 1e3
    sd_x, sd_y, sd_yaw = np.sqrt(np.diagonal(estimate.pose_covariance))
    vx, vy, turn = estimate.velocity_B
    why = f": {estimate.reason}" if estimate.reason else ""
    why += f"; noticed: {estimate.remark}" if estimate.remark else ""
    return (
        f"{seconds:7.2f} s  x {x:8.1f} +-{sd_x * 1e3:.1f}  y {y:7.1f} +-{sd_y * 1e3:.1f} mm  "
        f"yaw {np.degrees(estimate.yaw_rad):7.2f} +-{np.degrees(sd_yaw):.2f} deg  vx {vx * 1e3:6.1f} mm/s  "
        f"vy {vy * 1e3:6.1f}  turn {turn:7.4f} rad/s  {estimate.health.value}{why}"
    )


def _json_line(estimate: Estimate) -> str:
    line = {
        "t_ns": estimate.t_ns,
        "position_m": estimate.position_m,
        "yaw_rad": estimate.yaw_rad,
        "velocity": estimate.velocity_B,
        "pose_covariance": estimate.pose_covariance,
        "twist_covariance": estimate.twist_covariance,
        "force_n": estimate.force_B,
        "mu": estimate.mu,
        "stiffness_n_m": estimate.stiffness,
        "health": estimate.health.value,
        "reason": estimate.reason,
        "noticed": estimate.remark,
    }
    return json_text(line, indent=None)
