"""The value types that travel through the program, one frozen dataclass per stage.

Shapes use N for the number of legs; the leg order is that of the robot file (BigANT:
HL, ML, FL, HR, MR, FR). Arrays are float64 (counts and flags are int64 and bool) and read-only.
What is absent is NaN with ``valid=False``, never 0. Times ``t_ns`` are integer nanoseconds of one
monotonic clock. Frames: B is the body frame (x forward, y left, z up, origin at the centre of
mass), W is the world. The source paper's symbols are explained in ``model/__init__.py``.
"""

import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # it is made of the arrays below
    from model.estimator_types import OdometryEstimate
    from model.pose_record import PoseRecord

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def readonly(array: NDArray[Any]) -> NDArray[Any]:
    """Return the array with its write flag off, so that a value stays the value it was."""
    array.setflags(write=False)
    return array


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


class StopReason(enum.Enum):
    """Why a run ended, or is ending. NONE while it goes on."""

    NONE = 0
    COMPLETED = 1  # cycles or duration asked for are done
    OPERATOR = 2  # Ctrl-C or the stop key
    EMERGENCY = 3  # second Ctrl-C or the emergency key
    COMMAND_REFUSED = 4  # the safety gate refused commands in a row
    SERVO_LOST = 5  # a servo stayed silent
    SERVO_FAULT = 6  # hardware error bit, too hot, over-current, under-voltage
    FORCE_LOST = 7  # the force stream stayed silent
    TIMING = 8  # the loop missed its deadlines in a row
    LOG_FAILED = 9  # the log can no longer be written
    LINK_LOST = 10  # the port vanished
    GAIT_REFUSED = 11  # the gait asked for cannot be followed
    TILTED = 12  # the body leans too far
    SERVO_STALLED = 13  # a shaft does not follow its goal, with much current
    SLIPPED = 14  # the body moves when it should stand, or is too far from where it began
    UNLOADED = 15  # the feet carry too little: lifted, hanging or fallen


class FaultKind(enum.Enum):
    """Faults are values in the tick, never exceptions in the loop."""

    SERVO_SILENT = 1
    SERVO_CORRUPT = 2
    SERVO_ALERT = 3  # a hardware error bit is set in the servo
    SERVO_HOT = 4
    SERVO_CURRENT = 5
    SERVO_VOLTAGE = 6
    SERVO_LAG = 7  # following error beyond the limit
    FORCE_SILENT = 8
    FORCE_GAP = 9  # samples missing between two records
    FORCE_SATURATED = 10
    LATE = 11  # the tick began later than allowed
    REFUSED = 12  # the safety gate refused the wished command
    NO_SUPPORT = 13  # the support model found no equilibrium
    LOG_WRITE = 14
    LINK_LOST = 15
    SERVO_STALLED = 16
    SERVO_DOWN = 17  # a servo has lost its torque: shut down, or started anew
    RECOVERING = 18  # the controller asks for a servo to be brought back
    SERVO_RECOVERED = 19  # it holds again where it stands
    RECOVERY_FAILED = 20
    TILTED = 21
    SLIPPED = 22
    UNLOADED = 23
    FORCE_ABSENT = 24  # a transducer that should be in the record is not
    FORCE_BATTERY = 25  # the force unit says that its battery is low
    POSE_BAD = 26  # a pose from outside that makes no sense


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that went wrong in one tick.

    Attributes:
        kind: What.
        source: Leg name, device or stage it concerns.
        detail: Words for a person, with the figures.
    """

    kind: FaultKind
    source: str
    detail: str


@dataclass(frozen=True, slots=True, eq=False)
class ServoReadings:
    """One sync read of all servos, before calibration.

    Attributes:
        t_ns: When the read was complete.
        position_ticks: Present Position, (N,) int64, 4096 a turn.
        velocity_counts: Present Velocity, (N,) int64.
        current_counts: Present Current, (N,) int64.
        duty_counts: Present PWM, (N,) int64, 885 = 100 %.
        voltage_counts: Present Input Voltage, (N,) int64, 0.1 V.
        temperature_c: Present Temperature, (N,) int64, degrees Celsius.
        error_byte: Error byte of each status packet, (N,) int64.
        hardware_error: Register 70 as last polled, (N,) int64, -1 = never read.
        valid: True where this servo answered this read with a sound packet, (N,) bool. Where it is
            False the counts above mean nothing (they are 0 and must not be used).
        age_ns: Time since each servo's last sound answer, (N,) int64; 0 where valid, -1 if never.
    """

    t_ns: int
    position_ticks: IntArray
    velocity_counts: IntArray
    current_counts: IntArray
    duty_counts: IntArray
    voltage_counts: IntArray
    temperature_c: IntArray
    error_byte: IntArray
    hardware_error: IntArray
    valid: BoolArray
    age_ns: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class ForceRecord:
    """One sample record of the wireless force-torque unit, before calibration.

    Attributes:
        t_ns: Host time of reception.
        device_ticks: Device time stamp, 1/4096 s, u32.
        sequence: Sample sequence number, u32.
        status: The two status words, (2,) int64.
        battery: Battery byte (encoding unknown, logged as it is).
        mask: Transducers present, bit 0 = transducer 1.
        counts: Fx Fy Fz Tx Ty Tz of transducers 1-6, (6, 6) int64.
        present: True for the transducers in the mask, (6,) bool.
        saturated: Saturation bit of each transducer, (6,) bool.
    """

    t_ns: int
    device_ticks: int
    sequence: int
    status: IntArray
    battery: int
    mask: int
    counts: IntArray
    present: BoolArray
    saturated: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class JointState:
    """Shaft state in the leg's own sense: increasing angle moves a foot in stance backward.

    Attributes:
        t_ns: When it was measured.
        angle_rad: Shaft angle, unwrapped, 0 at mid-stance, (N,).
        rate_rad_s: Shaft speed, (N,).
        current_a: Motor current, (N,).
        duty: PWM duty, -1 to 1, (N,).
        voltage_v: Supply voltage, (N,).
        temperature_c: Servo temperature, (N,).
        valid: (N,) bool; NaN in every other field where False.
    """

    t_ns: int
    angle_rad: FloatArray
    rate_rad_s: FloatArray
    current_a: FloatArray
    duty: FloatArray
    voltage_v: FloatArray
    temperature_c: FloatArray
    valid: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class FootForces:
    """Force of the ground on each foot, in the body frame, as measured.

    Attributes:
        t_ns: Host time of the record it came from; -1 if there never was one.
        force_n: (N, 3) [N], body axes.
        valid: (N,) bool; NaN where False.
    """

    t_ns: int
    force_n: FloatArray
    valid: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class JointCommand:
    """What the shafts should do at ``t_ns``.

    Attributes:
        t_ns: Time the command is for.
        angle_rad: Shaft angle, unwrapped, (N,).
        rate_rad_s: Shaft speed along the plan, (N,); for prediction and logging.
        torque: False asks for torque off; the angles are then not sent.
    """

    t_ns: int
    angle_rad: FloatArray
    rate_rad_s: FloatArray
    torque: bool


@dataclass(frozen=True, slots=True, eq=False)
class FootMotion:
    """Feet relative to the body, unloaded, body frame.

    Attributes:
        position_m: (..., N, 3) [m].
        velocity_m_s: (..., N, 3) [m/s], the exact derivative along the shaft speed.
    """

    position_m: FloatArray
    velocity_m_s: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Support:
    """Height, slopes and foot loads at which the leg springs carry the body.

    Attributes:
        converged: False when there is no equilibrium; ``reason`` says why and the numbers are NaN.
        reason: Empty when converged.
        height_m: Height of the body origin above the ground.
        slope_x: Slope along x (rotation about y, pitch; the paper's alpha_x).
        slope_y: Slope along y (rotation about x, roll; the paper's alpha_y).
        load_n: Ground's vertical force on each foot, (N,) [N], 0 for a foot in the air.
        contact: (N,) bool.
        switches: Contact changes taken by the search.
    """

    converged: bool
    reason: str
    height_m: float
    slope_x: float
    slope_y: float
    load_n: FloatArray
    contact: BoolArray
    switches: int


@dataclass(frozen=True, slots=True, eq=False)
class Traction:
    """Planar balance of friction: body velocity, slip and forces.

    Attributes:
        valid: False when the balance has no unique answer; ``reason`` says why, numbers are NaN.
        reason: Empty when valid.
        velocity_B: Body velocity in body axes, (3,): vx [m/s], vy [m/s], yaw rate [rad/s].
        slip_B: Velocity of each foot over the ground in body axes, (N, 2) [m/s]; NaN in the air.
        force_B: Ground's force on each foot in body axes, (N, 3) [N]; 0 in the air.
    """

    valid: bool
    reason: str
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    slip_B: FloatArray  # noqa: N815
    force_B: FloatArray  # noqa: N815


@dataclass(frozen=True, slots=True, eq=False)
class ContactSolution:
    """The model's answer for one frame: support, then traction."""

    support: Support
    traction: Traction


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
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


@dataclass(frozen=True, slots=True, eq=False)
class BodyTruth:
    """Ground truth, where one exists (the plant, or motion capture).

    Attributes:
        t_ns: Time it holds for.
        position_W: Body origin in the world, (3,) [m].
        quaternion_xyzw: Body to world, (4,), scalar last.
        velocity_B: Velocity of the body origin in body axes, (3,) [m/s].
        angular_velocity_B: (3,) [rad/s], body axes.
        foot_position_W: (N, 3) [m].
        foot_velocity_W: (N, 3) [m/s].
        foot_force_B: Ground's force on each foot in body axes, (N, 3) [N].
        contact: (N,) bool, foot loaded.
    """

    t_ns: int
    position_W: FloatArray  # noqa: N815
    quaternion_xyzw: FloatArray
    velocity_B: FloatArray  # noqa: N815
    angular_velocity_B: FloatArray  # noqa: N815
    foot_position_W: FloatArray  # noqa: N815
    foot_velocity_W: FloatArray  # noqa: N815
    foot_force_B: FloatArray  # noqa: N815
    contact: BoolArray


class Intent(enum.Enum):
    """What the operator wants now."""

    LISTEN = 0  # torque off, only sense
    STAND = 1  # stand on all feet
    WALK = 2  # walk the gait named in the request
    STOP = 3  # come to rest on all feet and end the run
    CUT = 4  # cut torque now


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
    """

    servos: ServoReadings | None
    forces: tuple[ForceRecord, ...]
    request: Request
    timing: LoopTiming
    truth: BodyTruth | None
    faults: tuple[Fault, ...]
    poses: "tuple[PoseRecord, ...]" = ()


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
        estimate: Dead-reckoned pose: the model's velocity added up.
        faults: All faults of this tick.
        odometry: What the estimator makes of shafts, forces and poses; None where it is switched off,
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
    estimate: Estimate
    faults: tuple[Fault, ...]
    odometry: "OdometryEstimate | None" = None
