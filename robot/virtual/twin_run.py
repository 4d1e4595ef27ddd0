"""A walk of a physical twin as a trial: through bus and force unit, or at the same times without bytes."""

from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path

from gaits.catalog import make_gait
from gaits.limits import check_gait
from model.errors import ModelError
from model.values.readings import BodyTruth
from model.values.tick import Intent
from record.log.header import RunHeader
from record.trial.header import TrialHeader
from record.trial.trial import Trial
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.log import whole_log
from robot.run.loop import TickSink
from robot.run.operator import Script
from robot.run.rig import Reading, Rig
from robot.virtual.direct_robot import DirectRobot
from robot.virtual.file_twin import file_effects
from robot.virtual.open import VirtualSettings, open_twin
from robot.virtual.rehearsal import Progress, rehearse
from robot.virtual.twin_rows import Place, TwinRows, poses_of, trial_header, trial_of
from sim_hw.host.virtual_robot import VirtualRobot
from sim_hw.host.world import World
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import Effect, apply_effects
from sim_hw.twin.motion_capture import MotionCapture, Poses
from sim_hw.twin.twin import Twin, healthy_twin


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

    @property
    def script(self) -> Script:
        """The same for an operator."""
        return Script(self.gait, self.frequency_hz, self.steer, duration_s=self.seconds)


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


def walk_through_bytes(
    config: RobotConfig, twin: Twin, plan: WalkPlan, log: Path | None, progress: Progress
) -> Trial:
    """Walk through the virtual bus and force unit, with the whole controller, and return the trial.

    Args:
        config: Robot file: what controller and safety gate believe.
        twin: What walks.
        plan: How.
        log: Log that every tick goes to as well; it does not say what is wrong with the twin.
        progress: Called with the share done, 0 to 1.

    Raises:
        ModelError: The robot stopped before it was done.
        RecordError: The log cannot be written.
    """
    rows = TwinRows(plan.seconds)
    header = RunHeader(
        robot=config.name,
        hardware="virtual",
        time="virtual",
        gait=plan.gait,
        frequency_hz=plan.frequency_hz,
        steer=plan.steer,
    )
    rig, _ = open_twin(config, twin, VirtualSettings(seed=twin.seed))
    with closing(rig), ExitStack() as stack:
        controller = Controller(config, rig.calibrations, armed=True)
        sinks: list[TickSink] = [rows]
        if log is not None:
            sinks.insert(0, stack.enter_context(whole_log(log, header, rig, controller)))
        rehearse(rig, controller, plan.script, progress, *sinks)
    return trial_of(
        rows, poses_of([_place_of(t) for t in rows.truths]), _header(config, twin, plan)
    )


def _place_of(truth: BodyTruth | None) -> Place:
    if truth is None:
        raise ModelError("the cameras saw nothing")
    return truth.t_ns, truth.position_W, truth.quaternion_xyzw, truth.foot_position_W


def walk_fast(config: RobotConfig, twin: Twin, plan: WalkPlan, progress: Progress) -> Trial:
    """Walk without the byte layer and without model and estimator, and return the trial.

    Loop, watches, modes and safety gate are the robot's own; what is left out steers nothing.

    Args:
        config: Robot file: what controller and safety gate believe.
        twin: What walks.
        plan: How.
        progress: Called with the share done, 0 to 1.

    Raises:
        ModelError: The robot stopped before it was done.
    """
    rows = TwinRows(plan.seconds)
    rig, virtual = open_twin(config, twin, VirtualSettings(seed=twin.seed))
    with closing(rig):
        robot = _Filmed(config, rig, virtual)
        controller = Controller(config, rig.calibrations, armed=True, model=False)
        rehearse(robot, controller, replace(plan.script, end=Intent.CUT), progress, rows)
    # the cameras go on for one tick more than the trial
    first, count = rows.first, len(rows.t_ns)
    places = poses_of(robot.places[: first + count + 1])
    # a skewed clock was set when the record begins: what a log of the same run says, too
    measured = MotionCapture(twin.sensors, twin.seed).see_all(places, rows.t_ns[0])
    part = slice(first, first + count)
    walked = Poses(
        measured.t_ns[part],
        measured.position_W[part],
        measured.quaternion_xyzw[part],
        measured.foot_position_W[part],
    )
    return trial_of(rows, walked, _header(config, twin, plan))


def _header(config: RobotConfig, twin: Twin, plan: WalkPlan) -> TrialHeader:
    return trial_header(config, plan.gait, plan.frequency_hz, twin.sensors.noise)


class _Filmed(DirectRobot):
    """Keeps where body and feet truly were at each read."""

    def __init__(self, config: RobotConfig, rig: Rig, robot: VirtualRobot) -> None:
        super().__init__(config, rig, robot)
        self.places: list[Place] = []

    def read(self) -> Reading:
        reading = super().read()
        assert isinstance(self.world, World), "a twin is no bench"
        position, quaternion, feet = self.world.plant.places()
        self.places.append((self.clock.now_ns(), position.copy(), quaternion, feet))
        return reading
