"""A walk of a physical twin as a trial: through bus and force unit, or at the same times without bytes."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from drivers.ati.foot_forces import foot_forces
from drivers.dynamixel.mx106 import joint_state
from gaits.catalog import make_gait
from gaits.limits import check_gait
from model.errors import ModelError
from model.values.arrays import readonly
from model.values.faults import StopReason
from model.values.legs import JointCommand
from model.values.tick import Intent, Mode, Request
from record.trial.trial import Trial
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.control.modes import Phase, Situation, advance
from robot.control.safety import Allowed, Refused, gate
from robot.run.hardware import open_twin
from robot.virtual.direct_robot import DirectRobot
from robot.virtual.file_twin import file_effects
from robot.virtual.twin_rows import TwinRows, trial_header, trial_of
from sim_hw.host.world import World
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import Effect, apply_effects
from sim_hw.twin.motion_capture import MotionCapture, Poses
from sim_hw.twin.twin import Twin, healthy_twin

# The robot stands up and takes its start pose in this time, or never.
START_LIMIT_S = 60.0
Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True)
class WalkPlan:
    """What the twin is to do.

    Attributes:
        gait: Gait.
        frequency_hz: Cycles a second.
        seconds: Length of the trial, from the first tick of walking on.
        steer: -1 (right) to 1 (left).
    """

    gait: str
    frequency_hz: float
    seconds: float
    steer: float


def plan_of(
    config: RobotConfig, gait: str, frequency_hz: float | None, seconds: float, steer: float
) -> WalkPlan:
    """Return a walk that the robot's servos can follow.

    Args:
        config: Robot file.
        gait: Gait.
        frequency_hz: Cycles a second, None for the robot file's.
        seconds: Length.
        steer: -1 (right) to 1 (left).

    Raises:
        ConfigError: There is no such gait.
        GaitRefused: It is too fast.
    """
    made = make_gait(gait, config.parameters)
    frequency = frequency_hz if frequency_hz is not None else made.frequency_hz
    check_gait(made, frequency, config.parameters.servo)
    return WalkPlan(gait, frequency, seconds, steer)


def make_twin(config: RobotConfig, effects: tuple[Effect, ...], seed: int) -> Twin:
    """Return the twin of a robot file, with the file's own effects and others.

    Raises:
        ConfigError: An effect does not fit the robot.
    """
    everything = (*file_effects(config, effects), *effects)
    return apply_effects(healthy_twin(config.parameters, seed), everything, EFFECTS)


class _Poses:
    """Poses of body and feet, appended as they come."""

    def __init__(self) -> None:
        self.rows: list[tuple[int, np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, t_ns: int, places: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
        position, quaternion, feet = places
        self.rows.append((t_ns, position.copy(), quaternion, feet))

    def all(self) -> Poses:
        return Poses(
            t_ns=np.array([row[0] for row in self.rows]),
            position_W=np.array([row[1] for row in self.rows]),
            quaternion_xyzw=np.array([row[2] for row in self.rows]),
            foot_position_W=np.array([row[3] for row in self.rows]),
        )


def walk_fast(config: RobotConfig, twin: Twin, plan: WalkPlan, progress: Progress) -> Trial:
    """Walk without the byte layer, and return the trial.

    Args:
        config: Robot file: what controller and safety gate believe.
        twin: What walks.
        plan: How.
        progress: Told the share done, 0 to 1.

    Raises:
        ModelError: The robot stopped before it was done.
    """
    rig, robot = open_twin(config, twin, seed=twin.seed, armed=True, with_forces=True)
    walker = _FastWalk(config, DirectRobot(config, rig, robot), plan)
    poses, rows, first = _Poses(), TwinRows(), 0
    world = robot.world
    assert isinstance(world, World), "a twin is no bench"
    while True:
        joints_at_ns, mode = walker.tick()
        poses.add(joints_at_ns, world.plant.places())
        if mode is Mode.WALK:
            if not rows.t_ns:
                first = len(poses.rows) - 1
            elif walker.t_ns - rows.t_ns[0] >= round(plan.seconds * 1e9):
                break
            rows.t_ns.append(walker.t_ns)
            rows.command_rad.append(walker.allowed.command.angle_rad)
            rows.joints.append(walker.joints)
            rows.forces.append(walker.forces)
            progress(min(1.0, (walker.t_ns - rows.t_ns[0]) * 1e-9 / plan.seconds))
        walker.act()
    # a skewed clock was set when the record begins: what a log of the same run says, too
    seen = MotionCapture(twin.sensors, twin.seed).see_all(poses.all(), rows.t_ns[0])
    part = slice(first, first + len(rows.t_ns))
    walked = Poses(
        seen.t_ns[part],
        seen.position_W[part],
        seen.quaternion_xyzw[part],
        seen.foot_position_W[part],
    )
    header = trial_header(config, plan.gait, plan.frequency_hz, twin.sensors.noise)
    return trial_of(rows, walked, header)


class _FastWalk:
    """The loop's ticks without model, estimate and log: modes, plan, safety gate, direct robot."""

    def __init__(self, config: RobotConfig, robot: DirectRobot, plan: WalkPlan) -> None:
        controller = Controller(config, (None,) * len(config.servo_bus.names), armed=True)
        self._calibrations = robot.calibrations
        self._book, self._period_ns = controller.book, controller.period_ns
        self._config, self._robot = config, robot
        self._request = Request(
            Intent.WALK, plan.gait, plan.frequency_hz, plan.steer, StopReason.NONE
        )
        nan = readonly(np.full(len(config.servo_bus.names), np.nan))
        self._nan = nan
        self._phase = Phase(Mode.IDLE, None, None, StopReason.NONE)
        self._deadline_ns = robot.clock.now_ns() + self._period_ns
        self._begin_ns = robot.clock.now_ns()
        self._walked = False
        self.allowed = Allowed(JointCommand(0, nan, nan, torque=False))
        self._no_forces = foot_forces(None, self._calibrations, config.force_sensor, nan)
        self.forces = self._no_forces
        self.t_ns = 0

    def tick(self) -> tuple[int, Mode]:
        """Read and decide; return when the poses of this tick hold, and the mode."""
        clock = self._robot.clock
        clock.sleep_until_ns(self._deadline_ns)
        self.t_ns = clock.now_ns()
        readings, records = self._robot.read()
        self.joints = joint_state(readings, self._config.servo_bus)
        if records:
            self.forces = foot_forces(
                records[-1], self._calibrations, self._config.force_sensor, self.joints.angle_rad
            )
        elif self.t_ns - self.forces.t_ns > self._config.force_sensor.silent_limit_s * 1e9:
            self.forces = self._no_forces
        self._check()
        now = Situation(self.t_ns, self._request, StopReason.NONE, self.joints.angle_rad, True)
        self._phase = advance(self._phase, now, self._book)
        if self._phase.stop_reason is not StopReason.NONE:
            raise ModelError(f"the walk cannot be done ({self._phase.stop_reason.name})")
        self._decide()
        return clock.now_ns(), self._phase.mode

    def _check(self) -> None:
        last = self.allowed.command
        off = np.abs(self.joints.angle_rad - last.angle_rad).max() if last.torque else 0.0
        if off > self._config.limits.max_following_error_rad:
            raise ModelError(
                f"a shaft is {off:.2f} rad from its command: the robot would have stopped; choose a "
                "smaller effect"
            )
        if self._phase.mode is not Mode.WALK and (self.t_ns - self._begin_ns) > START_LIMIT_S * 1e9:
            raise ModelError(f"the robot did not come to walk within {START_LIMIT_S:g} s")

    def _decide(self) -> None:
        plan, last = self._phase.plan, self.allowed.command
        if plan is None:
            wished = JointCommand(self.t_ns, self._nan, self._nan, torque=False)
        else:
            angle, rate = plan.at(self.t_ns)
            wished = JointCommand(self.t_ns, readonly(angle), readonly(rate), torque=True)
        if wished.torque and not last.torque:
            last = replace(wished, torque=False)
        verdict = gate(wished, last, self._config.limits, self._config.servo_bus)
        if isinstance(verdict, Refused):
            raise ModelError(f"the safety gate refused a command: {verdict.reason}")
        self.allowed = verdict

    def act(self) -> None:
        """Send, and go on to the next deadline as the loop does."""
        before = self._robot.torque
        switched_on = self.allowed.command.torque and not before
        self._robot.actuate(self.allowed)
        if switched_on:
            self._deadline_ns = self._robot.clock.now_ns()
        missed = max(0, (self._robot.clock.now_ns() - self._deadline_ns) // self._period_ns)
        self._deadline_ns += self._period_ns * (1 + missed)
