"""What goes into the estimator, what it remembers, and what comes out. N legs, n = 13 + 2 N states."""

import enum
from dataclasses import dataclass, replace

import numpy as np

from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.legs import FootForces, FootMotion
from model.values.quick import quick

# Places in the state: pose and yaw, body velocity, its bias, log of the common friction, gyro bias, offset
# of measured roll and pitch against the model's (how the IMU is mounted, and the slope of the ground); then
# log mu and log K of each leg, both relative to the robot file.
POSE = slice(0, 3)
YAW = 2
VELOCITY = slice(3, 6)
BIAS = slice(6, 9)
SCALE = 9
GYRO_BIAS = 10
TILT_BIAS = slice(11, 13)
FIXED = 13
NEVER = -1  # a time
BETWEEN = "; "  # reasons of an estimate's health, and its remarks


# Where measurements come from: vertical forces, horizontal forces, absolute poses, yaw gyro, inclinometer.
SOURCES = ("load", "friction", "pose", "gyro", "tilt")


class Health(enum.Enum):
    """Whether the estimate may be relied on."""

    OK = "ok"
    DEGRADED = "degraded"  # works, with a larger covariance; the reason says why
    LOST = "lost"  # the pose is a guess until something absolute is heard


@quick
@dataclass(frozen=True, slots=True, eq=False)
class AddedByEffects:
    """What effects of the robot file add to the model's answer at a tick.

    Attributes:
        velocity_B: To the body's velocity, (3,).
        load_n: To the vertical force on each foot, (N,).
    """

    velocity_B: FloatArray  # noqa: N815 - frame suffix
    load_n: FloatArray


@quick
@dataclass(frozen=True, slots=True, eq=False)
class OdometryInputs:
    """What is known at a tick. Absent inputs are None or NaN.

    Attributes:
        t_ns: Time of the tick.
        feet: Unloaded feet, body frame, (N, 3) each; NaN for a leg without encoder.
        forces: Newest forces with the time they hold for, or None.
        yaw_rate_rad_s: Of a gyro [rad/s].
        roll_rad: Of an inclinometer [rad].
        pitch_rad: The same [rad].
        pose_W: Absolute x, y [m], yaw [rad], (3,); NaN where unknown. None if there is none.
        added: What effects add to the model; None without any.
        pose_sd_m: Standard deviation of its x and y; NaN for that of the settings.
        yaw_sd_rad: The same of its yaw.
        shaft_rad_s: Speed of each leg's shaft, (N,); None where legs have no shafts of their own.
    """

    t_ns: int
    feet: FootMotion
    forces: FootForces | None = None
    yaw_rate_rad_s: float = np.nan
    roll_rad: float = np.nan
    pitch_rad: float = np.nan
    pose_W: FloatArray | None = None  # noqa: N815 - frame suffix
    added: AddedByEffects | None = None
    pose_sd_m: float = np.nan
    yaw_sd_rad: float = np.nan
    shaft_rad_s: FloatArray | None = None


def paired_covariance(apart: FloatArray) -> FloatArray:
    """Covariance of what errors of one standard deviation make, each once up and once down.

    Args:
        apart: What each of M robots with one error answers less the answer without, (..., M, d).

    Returns:
        Half the second moment, (..., d, d).
    """
    covariance: FloatArray = 0.5 * np.swapaxes(apart, -1, -2) @ apart
    return covariance


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Companions:
    """M robots that walk along, each with its own errors of the robot file.

    Attributes:
        twist: Velocity without sway, from which the next frame starts, (M, 3); NaN before the first.
        resting: Feet at rest, (M, N).
        apart: Pose minus that of the file's robot: x, y [m] in the frame of the estimate, yaw [rad], (M,
            3).
        pose_covariance: What that amounts to, of x, y, yaw, (3, 3): ``paired_covariance``.
    """

    twist: FloatArray
    resting: BoolArray
    apart: FloatArray
    pose_covariance: FloatArray

    def gathered(self) -> "Companions":
        """The same robots, all at one place again: what lay between them is in the covariance."""
        nowhere, certain = readonly(np.zeros_like(self.apart)), readonly(np.zeros((3, 3)))
        return replace(self, apart=nowhere, pose_covariance=certain)


@quick
@dataclass(frozen=True, slots=True, eq=False)
class ForceMemory:
    """How predicted horizontal forces of filter and open loop compared lately, axes x and y.

    Attributes:
        apart: Mean square of the filter's less the open loop's, over the weight, (2,).
        agree: Mean of that difference times what the sensors measured beyond the open loop, (2,).
    """

    apart: FloatArray
    agree: FloatArray


@quick
@dataclass(frozen=True, slots=True, eq=False)
class SourceMemory:
    """Innovations of the last seconds, source by source, S sources as in ``SOURCES``.

    Sums fade with time.

    Attributes:
        t_ns: When each was last received, -1 for never, (S,).
        product: Of normalised innovations with those before them, (S,).
        normal: The same squared, (S,).
        last: Newest normalised innovation of each number that can be measured, NaN before the first.
        bias: Mean innovation of each.
        misfit: Innovations squared over what the settings expect of them, in the last moments, (S,).
        scale: Variance of the noise over that of the settings, (S,).
        colour: How many times as much it counts because errors last, (S,).
    """

    t_ns: IntArray
    product: FloatArray
    normal: FloatArray
    last: FloatArray
    bias: FloatArray
    misfit: FloatArray
    scale: FloatArray
    colour: FloatArray


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Vibration:
    """How forces and a gyro changed from one record to the next in the last moments.

    Attributes:
        force: Horizontal force of all feet along x and y over the weight, and its moment about z [m], of
            the newest record, (3,); NaN without forces.
        force_change: Half the mean square of their changes, (3,).
        turn: Newest innovation of the gyro [rad/s]; NaN without one.
        turn_change: Half the mean square of its changes [rad^2/s^2].
    """

    force: FloatArray
    force_change: FloatArray
    turn: float
    turn_change: float


@quick
@dataclass(frozen=True, slots=True, eq=False)
class ZeroEvidence:
    """What loads say of the shafts' zeros (``model.estimator.shaft_zeros``).

    Attributes:
        information: Of a height and an angle of each leg, (2N, 2N).
        pull: Its right side, (2N,).
        square: Sum of squares of the loads that are fitted, and number of these loads, (2,).
        records: How many records of forces came.
        angle_rad: By how much each zero seems to be off, and its standard deviation, (2, N).
        standing_out: Leg whose angle stands out in this record, -1 for none.
        since: Record since which this leg stands out, or none does.
        suspected: Leg whose zero seems wrong, -1 for none.
    """

    information: FloatArray
    pull: FloatArray
    square: FloatArray
    records: int
    angle_rad: FloatArray
    standing_out: int
    since: int
    suspected: int


@quick
@dataclass(frozen=True, slots=True, eq=False)
class EstimatorState:
    """All that the estimator remembers from one tick to the next.

    Attributes:
        t_ns: Time of the last tick, -1 before the first.
        mean: State, (n,).
        covariance: (n, n).
        feet: Last known feet.
        force_ns: Time of the newest force record seen, -1 for none.
        used_ns: Time of the newest one used.
        share: Measured shares of the weight in it, (N,).
        expected: The model's forces at the last tick over the weight, (N, 3); NaN without an answer.
        contact: Feet taken to be loaded, (N,).
        rejected: Rejections in a row by source and leg, (S, N); those of a body are in the first column, of
            roll and pitch in the first two.
        rejects: Rejections ever, of all sources.
        idle_ns: Since when the feet stand still in the body, -1 if they do not.
        answer_ns: Last time that the model had an answer, -1 for never.
        fine_ns: Since when all has been in order, -1 if it is not.
        lost: Whether the estimate is lost.
        airborne: Whether the forces say that the robot is picked up.
        anchored: Whether an absolute position has been used since the robot was last carried or lost:
            from then on one that is too far off is never used.
        far_poses: Absolute poses in a row that were too far off; 0 again with the next one that is used.
        before: Mean and covariance before this tick's measurements (for smoothing).
        transition: (n, n) from the tick before to ``before`` (for smoothing).
        companions: Robots that differ from the file by its tolerances.
        sources: What the innovations of each source have been like.
        forces: How predicted forces compared with measured ones.
        balance: Mean of all forces together over the weight, axes of the estimate's frame, and of how many
            records, (4,).
        strain: Variance of the noise of vx, vy and yaw rate over that of the settings, as innovations ask
            for, (3,).
        vibration: How fast the body shakes.
        zeros: What loads say of the shafts' zeros.
        gyro_ns: Time of the last tick with a yaw rate, -1 for never.
    """

    t_ns: int
    mean: FloatArray
    covariance: FloatArray
    feet: FootMotion
    force_ns: int
    used_ns: int
    share: FloatArray
    expected: FloatArray
    contact: BoolArray
    rejected: IntArray
    rejects: int
    idle_ns: int
    answer_ns: int
    fine_ns: int
    lost: bool
    airborne: bool
    anchored: bool
    far_poses: int
    before: tuple[FloatArray, FloatArray]
    transition: FloatArray
    companions: Companions
    sources: SourceMemory
    forces: ForceMemory
    balance: FloatArray
    strain: FloatArray
    vibration: Vibration
    zeros: ZeroEvidence
    gyro_ns: int = NEVER


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """What the estimator says after a tick, N legs.

    Attributes:
        t_ns: Time it holds for.
        position_m: x, y in the frame where it was reset, (2,) [m].
        yaw_rad: Yaw, unwrapped [rad].
        velocity_B: vx, vy [m/s], yaw rate [rad/s], body axes, (3,).
        pose_covariance: Of x, y, yaw, (3, 3).
        companion_pose: Part of it: by how much robots that differ from the file by its tolerances would be
            elsewhere now, (M, 3).
        twist_covariance: Of the velocity, (3, 3).
        bias_B: What is added to the model's velocity, (3,).
        mu: Friction coefficients, (N,), their common part included.
        mu_sd: Of their logarithms, (N,).
        stiffness: (N,) [N/m].
        stiffness_sd: Of its logarithm, (N,).
        force_B: Predicted ground force on each foot, body axes, (N, 3) [N]; NaN without an answer.
        force_covariance: (N, 3, 3) [N^2].
        load_share: Predicted vertical force over the weight, (N,).
        load_share_sd: (N,).
        tilt_rad: Roll and pitch of the support model, (2,).
        height_m: Height of the body origin over the ground [m].
        contact: Feet taken to be loaded, (N,).
        slipping: Feet that clearly slip, (N,).
        holding: Whether pose and parameters are held because nothing moves.
        nis: Normalised innovation squared of this tick; NaN without a measurement.
        nis_dof: Its degrees of freedom.
        source_nis: The same by source, (S,); NaN where it gave nothing.
        source_dof: Numbers of each that were used, (S,).
        noise_scale: Variance of each source's noise over that of the settings, as learned, (S,).
        log_likelihood: Of this tick's innovations; NaN without a measurement.
        innovation: Measured minus predicted force over the sd that the filter gives it, (N, 3); NaN
            where none was used.
        rejects: Measurements rejected so far.
        force_age_s: Age of the newest force record; NaN if there never was one.
        health: Verdict.
        reason: Why it is not ok; empty if it is.
        gyro_bias_rad_s: Of the yaw gyro [rad/s]; NaN until it has reported a rate. So is its sd.
        gyro_bias_sd: Its standard deviation [rad/s].
        remark: What of the robot file or the ground does not agree with the measurements, though the
            covariance covers it; empty without any.
    """

    t_ns: int
    position_m: FloatArray
    yaw_rad: float
    velocity_B: FloatArray  # noqa: N815
    pose_covariance: FloatArray
    companion_pose: FloatArray
    twist_covariance: FloatArray
    bias_B: FloatArray  # noqa: N815
    mu: FloatArray
    mu_sd: FloatArray
    stiffness: FloatArray
    stiffness_sd: FloatArray
    force_B: FloatArray  # noqa: N815
    force_covariance: FloatArray
    load_share: FloatArray
    load_share_sd: FloatArray
    tilt_rad: FloatArray
    height_m: float
    contact: BoolArray
    slipping: BoolArray
    holding: bool
    nis: float
    nis_dof: int
    source_nis: FloatArray
    source_dof: IntArray
    noise_scale: FloatArray
    log_likelihood: float
    innovation: FloatArray
    rejects: int
    force_age_s: float
    health: Health
    reason: str
    gyro_bias_rad_s: float = np.nan
    gyro_bias_sd: float = np.nan
    remark: str = ""

    @property
    def pose(self) -> FloatArray:
        """x, y [m], yaw [rad], (3,)."""
        return np.array([*self.position_m, self.yaw_rad])
