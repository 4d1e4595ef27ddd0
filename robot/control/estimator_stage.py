"""The estimator as a stage of the step: shafts, forces and poses of a tick to pose and forces.

Pure like the step it belongs to: all that it remembers goes in and comes out.
"""

from dataclasses import dataclass, replace

import numpy as np

from model.estimator.filter import Estimator
from model.estimator.history import EstimatorMemory, LateSample, advance, use_late
from model.kinematics.legs import LegKinematics
from model.motion import shaft_speed
from model.motion.se2 import aligning, compose, yaw_of
from model.motion.shaft_speed import ShaftSpeeds
from model.values.arrays import FloatArray, readonly
from model.values.estimate import POSE, Estimate, OdometryInputs
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootForces, FootMotion, JointState
from model.values.parameters import RobotParameters
from model.values.readings import ImuRecord, PoseRecord
from robot.config.estimator import EstimatorConfig
from robot.config.imu import NO_IMU, ImuConfig
from robot.config.robot_file import RobotConfig
from robot.control.effects import EffectMemory, EffectsBeside
from robot.control.imu import MountedImu

FIRST = -1
UNKNOWN = (np.nan, np.nan, np.nan)  # yaw rate, roll, pitch


@dataclass(frozen=True, slots=True, eq=False)
class StageMemory:
    """What the stage remembers.

    Attributes:
        estimator: State of the filter and the ticks of the last moments.
        alignment: x, y [m], yaw [rad] of the outside world in ours, (3,); None before its first pose.
        effects: What the effects of the robot file remember, None without any.
        speeds: What the shafts' speeds are corrected by; None before the first tick.
    """

    estimator: EstimatorMemory
    alignment: FloatArray | None = None
    effects: EffectMemory | None = None
    speeds: ShaftSpeeds | None = None


class EstimatorStage:
    """The stage and what it knows beforehand.

    Args:
        robot: The robot as the model assumes it to be.
        config: Settings.
        kinematics: Joints to feet.
        effects: What the robot file's effects add, None without any.
        imu: How the IMU is mounted.

    Attributes:
        memory_s: How late a pose may be [s].
    """

    def __init__(
        self,
        robot: RobotParameters,
        config: EstimatorConfig,
        kinematics: LegKinematics,
        effects: EffectsBeside | None = None,
        imu: ImuConfig = NO_IMU,
    ) -> None:
        self._imu = MountedImu(imu)
        self.memory_s = config.memory
        self._kinematics = kinematics
        self._effects = effects
        weight_n = robot.body.mass * STANDARD_GRAVITY
        if effects is not None:
            weight_n = effects.weight_n
        self._estimator = Estimator(robot.contact, weight_n, config.settings, robot.legs.names)

    @property
    def filter_alone(self) -> Estimator | None:
        """The filter, where nothing of the robot file stands between it and what is sensed."""
        return self._estimator if self._effects is None else None

    def initial(self) -> StageMemory:
        """Return the memory before the first tick."""
        return StageMemory(EstimatorMemory(self._estimator.initial()))

    def step(
        self,
        memory: StageMemory,
        t_ns: int,
        joints: JointState,
        forces: FootForces,
        poses: tuple[PoseRecord, ...] = (),
        imu: tuple[ImuRecord, ...] = (),
        servo_feet: FootMotion | None = None,
    ) -> tuple[StageMemory, Estimate]:
        """Advance by a tick.

        Args:
            memory: What was.
            t_ns: Time of the tick.
            joints: Shafts; their speed is the servos' own, which is not late.
            forces: Newest foot forces.
            poses: Absolute poses received since the last tick. The first one ever says where the outside
                world lies in ours, so that the estimate does not jump.
            imu: Readings of the IMU since then; the newest fresh one counts.
            servo_feet: Feet at these shafts, if they are known already; they are the same.
        """
        effects, added = memory.effects, None
        speeds, rate_rad_s = shaft_speed.agreed(
            memory.speeds, joints.t_ns, joints.angle_rad, joints.rate_rad_s
        )
        if self._effects is None:
            feet = servo_feet
            if (
                feet is None or rate_rad_s is not joints.rate_rad_s
            ):  # in a slow loop it is corrected
                feet = self._kinematics.feet(joints.angle_rad, rate_rad_s)
        else:
            effects, tick = self._effects.step(effects, t_ns, joints.angle_rad, rate_rad_s, forces)
            feet, forces, added = tick.answer.feet, tick.forces, tick.added
        shafts = rate_rad_s if len(rate_rad_s) == len(feet.position_m) else None  # a shaft a leg
        turn, roll, pitch = self._imu.of_body(imu, t_ns) if imu else UNKNOWN
        inputs = OdometryInputs(
            t_ns, feet, forces, turn, roll, pitch, added=added, shaft_rad_s=shafts
        )
        before, alignment = memory.estimator, memory.alignment
        if poses:
            alignment, late, newest = self._sorted(before, alignment, t_ns, poses)
            before, _ = use_late(self._estimator, before, late)
            if newest is not None:
                inputs = replace(
                    inputs,
                    pose_W=newest.pose_W,
                    pose_sd_m=newest.pose_sd_m,
                    yaw_sd_rad=newest.yaw_sd_rad,
                )
        after, estimate = advance(self._estimator, before, inputs, self.memory_s)
        return StageMemory(after, alignment, effects, speeds), estimate

    def _sorted(
        self,
        memory: EstimatorMemory,
        alignment: FloatArray | None,
        t_ns: int,
        poses: tuple[PoseRecord, ...],
    ) -> tuple[FloatArray | None, list[LateSample], LateSample | None]:
        """Poses in our frame: those of earlier ticks, and the newest one of this tick."""
        late: list[LateSample] = []
        newest: LateSample | None = None
        for record in sorted(poses, key=lambda pose: pose.t_ns):
            seen = planar(record)
            if alignment is None:
                if not np.isfinite(seen).all():
                    continue  # a place without a heading says nothing about where the world lies
                alignment = readonly(aligning(_pose_at(memory, record.t_ns), seen))
            sample = LateSample(
                min(record.t_ns, t_ns),
                pose_W=readonly(compose(alignment, seen)),
                pose_sd_m=record.sd_position_m,
                yaw_sd_rad=record.sd_angle_rad,
            )
            if memory.state.t_ns != FIRST and sample.t_ns <= memory.state.t_ns:
                late.append(sample)
            else:
                newest = sample
        return alignment, late, newest


def estimator_stage(config: RobotConfig, kinematics: LegKinematics) -> EstimatorStage:
    """Return the estimator of a robot file, with what its effects add."""
    effects = None
    if config.effects:
        effects = EffectsBeside(config, config.estimator.settings.law)
        effects.prepare()
    return EstimatorStage(config.parameters, config.estimator, kinematics, effects, config.imu)


def planar(record: PoseRecord) -> FloatArray:
    """x, y [m], yaw [rad] of a pose, (3,)."""
    return np.array([*record.position_W[:2], yaw_of(record.quaternion_xyzw)])


def _pose_at(memory: EstimatorMemory, t_ns: int) -> FloatArray:
    """Our own pose at a time: that before the first tick which is not earlier, else the newest."""
    for state, inputs in memory.ticks:
        if inputs.t_ns > t_ns:
            return state.mean[POSE]
    return memory.state.mean[POSE]
