"""A walk of a physical twin as a trial: through bus and force unit, or at the same times without bytes."""

from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from gaits.catalog import make_gait
from gaits.limits import check_gait
from model.errors import ModelError, RecordError
from model.motion.attitude import roll_pitch_yaw
from model.values.arrays import FloatArray, readonly
from model.values.legs import FootForces, JointState
from model.values.parameters import PluginParameters
from model.values.readings import BodyTruth, ImuRecord
from model.values.tick import Intent, Mode, Tick
from record.log.recording import Stack, newest_imu
from record.trial.header import LEGGED, TrialHeader
from record.trial.trial import Trial
from robot.config.gait_file import with_plugin
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.header import virtual_header, whole_log
from robot.run.loop import TickSink
from robot.run.operator import Script
from robot.run.rig import Reading, Rig
from robot.virtual.direct_robot import DirectRobot
from robot.virtual.file_twin import file_effects
from robot.virtual.open import VirtualSettings, open_twin
from robot.virtual.rehearsal import Progress, rehearse, silent
from sim_hw.host.virtual_robot import VirtualRobot
from sim_hw.host.world import World
from sim_hw.realities.catalogue import USUAL
from sim_hw.realities.reality import Reality, real_twin
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import TwinEffect, apply_effects
from sim_hw.twin.motion_capture import MotionCapture, Poses
from sim_hw.twin.twin import Twin

ROBOT_FILE = "robot.toml"
# Time [ns], body in the world (3,) [m], body to world x y z w (4,), feet in the world (N, 3) [m].
Place: TypeAlias = tuple[int, FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True, slots=True)
class WalkPlan:
    """What the twin is to do.

    Attributes:
        gait: Gait.
        frequency_hz: Cycles a second.
        seconds: Length of the trial, from the first tick of walking on.
        steer: -1 (right) to 1 (left).
        plugin: The gait, if a Python file gives it.
    """

    gait: str
    frequency_hz: float
    seconds: float
    steer: float
    plugin: PluginParameters | None = None

    def robot(self, config: RobotConfig) -> RobotConfig:
        """Return a robot that has the gait."""
        return config if self.plugin is None else with_plugin(config, self.plugin)

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
    plugins = [one for one in config.parameters.gaits if isinstance(one, PluginParameters)]
    frequency = frequency_hz if frequency_hz is not None else made.frequency_hz
    check_gait(made, frequency, config.parameters.servo)
    plugin = next((one for one in plugins if one.name == gait), None)
    return WalkPlan(gait, frequency, seconds, steer, plugin)


def make_twin(
    config: RobotConfig, effects: tuple[TwinEffect, ...], seed: int, reality: Reality = USUAL
) -> Twin:
    """Return the twin of a robot file in a reality, with the file's own effects and others.

    Raises:
        ConfigError: An effect does not fit the robot.
    """
    everything = (*file_effects(config, effects), *effects)
    return apply_effects(real_twin(reality, config.parameters, seed), everything, EFFECTS)


def walk_through_bytes(
    config: RobotConfig,
    twin: Twin,
    plan: WalkPlan,
    log: Path | None = None,
    progress: Progress = silent,
) -> Trial:
    """Walk through the virtual bus and force unit, with the whole controller, and return the trial.

    Args:
        config: Robot file: what controller and safety gate assume.
        twin: What walks.
        plan: How.
        log: Log that every tick goes to as well; it does not say what is wrong with the twin.
        progress: Called with the share done, 0 to 1.

    Raises:
        ModelError: The robot stopped before it was done.
        RecordError: The log cannot be written.
    """
    walked, config = TwinRows(plan.seconds), plan.robot(config)
    rig, _ = open_twin(config, twin, _settings(twin))
    with closing(rig), ExitStack() as stack:
        controller = Controller(config, rig.calibrations, armed=True)
        sinks: list[TickSink] = [walked]
        if log is not None:
            header = virtual_header(config, plan.script)
            sinks.insert(0, stack.enter_context(whole_log(log, header, rig, controller)))
        rehearse(rig, controller, plan.script, progress, *sinks)
    poses = poses_of([_place_of(row.truth) for row in walked.rows])
    return trial_of(config, twin, plan, walked.rows, poses)


def _settings(twin: Twin) -> VirtualSettings:
    return VirtualSettings(seed=twin.seed, with_forces=twin.sensors.forces)


def _place_of(truth: BodyTruth | None) -> Place:
    if truth is None:
        raise ModelError("the cameras saw nothing")
    return truth.t_ns, truth.position_W, truth.quaternion_xyzw, truth.foot_position_W


def walk_fast(
    config: RobotConfig, twin: Twin, plan: WalkPlan, progress: Progress = silent
) -> Trial:
    """Walk without the byte layer and without the estimator, and return the trial.

    Loop, model, watches, modes and safety gate are the robot's own: it stops where the robot would.

    Args:
        config: Robot file: what controller and safety gate assume.
        twin: What walks.
        plan: How.
        progress: Called with the share done, 0 to 1.

    Raises:
        ModelError: The robot stopped before it was done.
    """
    walked, config = TwinRows(plan.seconds), plan.robot(config)
    rig, virtual = open_twin(config, twin, _settings(twin))
    with closing(rig):
        robot = _Filmed(config, rig, virtual)
        controller = Controller(config, rig.calibrations, armed=True, estimate=False)
        rehearse(robot, controller, replace(plan.script, end=Intent.CUT), progress, walked)
    # the cameras go on for one tick more than the trial
    part = slice(walked.first, walked.first + len(walked.rows))
    places = poses_of(robot.places[: part.stop + 1])
    # the clock of the cameras is right when the trial begins, as in a log of the same run
    measured = MotionCapture(twin.sensors, twin.seed).see_all(places, walked.rows[0].t_ns)
    poses = Poses(
        measured.t_ns[part],
        measured.position_W[part],
        measured.quaternion_xyzw[part],
        measured.foot_position_W[part],
    )
    return trial_of(config, twin, plan, walked.rows, poses)


class _Filmed(DirectRobot):
    """Keeps where body and feet truly were at each read."""

    def __init__(self, config: RobotConfig, rig: Rig, robot: VirtualRobot) -> None:
        super().__init__(config, rig, robot)
        self.places: list[Place] = []

    def read(self) -> Reading:
        reading = super().read()
        assert isinstance(self.world, World), "a twin is no bench"
        position, quaternion, feet = self.world.places()
        self.places.append((self.clock.now_ns(), position.copy(), quaternion, feet))
        return reading


class Row(NamedTuple):
    """What a trial needs of one tick of walking."""

    t_ns: int
    command_rad: FloatArray
    joints: JointState
    forces: FootForces
    truth: BodyTruth | None
    imu: tuple[ImuRecord, ...]


class TwinRows:
    """A sink that keeps what a trial needs of the ticks of walking.

    Args:
        seconds: Length of the trial, from the first tick of walking on.
    """

    error: RecordError | None = None

    def __init__(self, seconds: float) -> None:
        self.first = 0  # ticks before it
        self.rows: list[Row] = []
        self._length_ns = round(seconds * 1e9)

    def write(self, tick: Tick) -> None:
        """Keep a tick if it belongs to the trial."""
        if tick.mode is not Mode.WALK:
            self.first += not self.rows
        elif not self.rows or tick.t_ns - self.rows[0].t_ns < self._length_ns:
            seen = tick.inputs
            self.rows.append(
                Row(tick.t_ns, tick.sent.angle_rad, tick.joints, tick.forces, seen.truth, seen.imu)
            )


def poses_of(places: Sequence[Place]) -> Poses:
    """Return places one behind the other as arrays."""
    return Poses(*(np.array(column) for column in zip(*places, strict=True)))


def trial_of(
    config: RobotConfig, twin: Twin, plan: WalkPlan, rows: Sequence[Row], poses: Poses
) -> Trial:
    """Make a trial; nothing in its header depends on what is wrong with the robot.

    Args:
        config: Robot file.
        twin: What walked.
        plan: How.
        rows: Ticks of walking.
        poses: What the cameras measured at the same times.
    """
    t_ns = np.array([row.t_ns for row in rows])
    position, angles, feet = body_of(poses)
    header = TrialHeader(
        kind=LEGGED,
        joints=config.parameters.legs.names,
        gait=plan.gait,
        frequency_hz=plan.frequency_hz,
        sample_rate_hz=float(config.loop.rate_hz),
        notes="",
        noise=twin.sensors.noise,
        robot_file=ROBOT_FILE,
        robot_text=config.text,
    )

    def stack(name: str) -> FloatArray:
        return readonly(np.array([getattr(row.joints, name) for row in rows]))

    nothing = readonly(np.full((len(t_ns), len(header.joints)), np.nan))
    return Trial(
        header,
        time_s=readonly((t_ns - t_ns[0]) * 1e-9),
        command_rad=readonly(np.array([row.command_rad for row in rows])),
        shaft_rad=stack("angle_rad"),
        shaft_rad_s=stack("rate_rad_s"),
        current_a=stack("current_a"),
        voltage_v=stack("voltage_v"),
        temperature_c=stack("temperature_c"),
        pwm=nothing,
        torque_nm=nothing,
        foot_m=readonly(feet),
        force_n=readonly(np.array([row.forces.force_n for row in rows])),
        body_position_m=readonly(position),
        body_angles_rad=readonly(angles),
        imu=readonly(Stack("imu", (3,), newest_imu).of(rows)),
    )


def body_of(poses: Poses) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Position (T, 3), roll, pitch and yaw (T, 3), and feet in the body (T, N, 3), as a trial has them."""
    turns = Rotation.from_quat(poses.quaternion_xyzw)
    roll, pitch, yaw = roll_pitch_yaw(turns).T
    arms = poses.foot_position_W - poses.position_W[:, None, :]
    feet = np.einsum("tji,tnj->tni", turns.as_matrix(), arms)
    return poses.position_W, np.stack([roll, pitch, np.unwrap(yaw)], axis=1), feet
