"""One tick: what enters the step, and one row of the log."""

import enum
from dataclasses import dataclass

import numpy as np

from model.values.arrays import FloatArray
from model.values.contact import ContactSolution
from model.values.estimate import Estimate
from model.values.faults import Fault, ServoEvent, StopReason
from model.values.legs import FootForces, FootMotion, JointCommand, JointState
from model.values.quick import quick
from model.values.readings import (
    BodyTruth,
    ForceRecord,
    ImuRecord,
    PoseRecord,
    ServoReadings,
)


class Mode(enum.Enum):
    """What the controller is doing. The order is that of an ordinary run."""

    IDLE = 0  # torque off, only listening
    ARMED = 1  # torque on, holding where it was switched on
    START = 2  # moving one leg at a time: to the stand, or to the start pose of a gait
    WALK = 3  # following the gait
    SLOW = 4  # phase rate ramping down to zero
    SETTLE = 5  # moving one leg at a time until all feet stand
    HOLD = 6  # standing still on all feet, torque on
    LIMP = 7  # torque cut; leaving it needs a new run


class Intent(enum.Enum):
    """What the operator wants now."""

    LISTEN = 0  # torque off, only sense
    STAND = 1  # stand on all feet
    WALK = 2  # walk the gait named in the request
    STOP = 3  # come to rest on all feet and end the run
    CUT = 4  # cut torque now


@quick
@dataclass(frozen=True, slots=True)
class Request:
    """The operator's wish, sampled once a tick.

    Attributes:
        intent: What to do.
        gait: Name of the gait for WALK.
        frequency_hz: Cycles a second for WALK.
        steer: -1 (right) to 1 (left).
        reason: Why a STOP or CUT is asked for.
    """

    intent: Intent
    gait: str
    frequency_hz: float
    steer: float
    reason: StopReason


@quick
@dataclass(frozen=True, slots=True)
class LoopTiming:
    """How the loop itself is doing; measured by the loop, ignored by comparisons of replays.

    Attributes:
        deadline_ns: When this tick should have begun.
        lateness_ns: How much later it began.
        missed: Periods skipped since the tick before.
        busy_ns: Time the tick before spent working.
    """

    deadline_ns: int
    lateness_ns: int
    missed: int
    busy_ns: int


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Inputs:
    """Everything the controller may know in one tick. Nothing else enters ``step``.

    Attributes:
        servos: Latest sync read; None only when no servo bus is attached (a replay of forces).
        forces: Force records received since the last tick, oldest first.
        request: The operator's wish.
        timing: The loop's own state.
        truth: Ground truth if one exists. It is logged and compared, never used for control.
        faults: Faults found by the drivers and the recorder since the last tick.
        poses: Absolute poses received since the last tick, in the order in which they came.
        servo_events: Servos that lost their torque, were brought back or could not be, since the last
            tick. Each is among the faults too, which is all that a log keeps of it.
        imu: Readings of an inertial unit received since the last tick, in the order in which they came.
    """

    servos: ServoReadings | None
    forces: tuple[ForceRecord, ...]
    request: Request
    timing: LoopTiming
    truth: BodyTruth | None
    faults: tuple[Fault, ...]
    poses: tuple[PoseRecord, ...] = ()
    servo_events: tuple[ServoEvent, ...] = ()
    imu: tuple[ImuRecord, ...] = ()


@quick
@dataclass(frozen=True, slots=True, eq=False)
class DeadReckoning:
    """Dead-reckoned planar pose in the frame where the run began (REP-105 ``odom``).

    Attributes:
        t_ns: Time it holds for.
        position_m: (2,) [m].
        yaw_rad: Yaw, unwrapped [rad].
        velocity_B: (3,): vx, vy [m/s], yaw rate [rad/s], body axes; NaN while the model has none.
        valid: False while no velocity is known; the pose then stands still.
    """

    t_ns: int
    position_m: FloatArray
    yaw_rad: float
    velocity_B: FloatArray  # noqa: N815
    valid: bool

    @property
    def pose(self) -> FloatArray:
        """x, y [m], yaw [rad], (3,)."""
        return np.array([*self.position_m, self.yaw_rad])


@quick
@dataclass(frozen=True, slots=True, eq=False)
class SensedTick:
    """What an estimator may know in a tick of J joints and N legs.

    Attributes:
        t_ns: Time of the tick.
        joints: Calibrated shaft state.
        forces: Latest measured foot forces, NaN without any.
        poses: Absolute poses received since the last tick.
        imu: Readings of an inertial unit received since then.
    """

    t_ns: int
    joints: JointState
    forces: FootForces
    poses: tuple[PoseRecord, ...] = ()
    imu: tuple[ImuRecord, ...] = ()


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Tick:
    """One row of the log: the raw inputs, every stage's output, the verdict and the faults.

    Attributes:
        t_ns: Time of the tick.
        index: Tick number from 0.
        mode: Mode after this tick.
        stop_reason: Why the run is ending, NONE while it goes on.
        inputs: What came in.
        joints: Calibrated shaft state.
        forces: Latest measured foot forces.
        gait_phase: Gait phase in cycles, unwrapped; NaN when no gait runs.
        wished: The command the gait asked for.
        sent: The command the safety gate let through; what the bus sends.
        feet: Unloaded feet from the measured shaft angles.
        contact: The model's answer.
        dead_reckoning: The model's velocity added up, open loop.
        faults: All faults of this tick.
        estimate: What the estimator makes of shafts, forces and poses; None where it is switched off,
            and in logs older than it.
    """

    t_ns: int
    index: int
    mode: Mode
    stop_reason: StopReason
    inputs: Inputs
    joints: JointState
    forces: FootForces
    gait_phase: float
    wished: JointCommand
    sent: JointCommand
    feet: FootMotion
    contact: ContactSolution
    dead_reckoning: DeadReckoning
    faults: tuple[Fault, ...]
    estimate: Estimate | None = None

    @property
    def sensed(self) -> SensedTick:
        """What an estimator may know of it."""
        return SensedTick(self.t_ns, self.joints, self.forces, self.inputs.poses, self.inputs.imu)

    @property
    def imu_age_s(self) -> float:
        """Age of the newest reading of the IMU in this tick [s]; NaN where none came."""
        readings = self.inputs.imu
        return (self.t_ns - readings[-1].t_ns) * 1e-9 if readings else np.nan
