"""What devices report, before calibration: servos, forces, IMU, poses from outside; and ground truth."""

from dataclasses import dataclass

import numpy as np

from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.quick import quick


@quick
@dataclass(frozen=True, slots=True, eq=False)
class ServoReadings:
    """One sync read of all servos, before calibration.

    Attributes:
        t_ns: The middle of the read.
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


def silent_readings(t_ns: int, count: int) -> ServoReadings:
    """Return readings in which none of ``count`` servos answered."""
    zeros = readonly(np.zeros(count, dtype=np.int64))
    unknown = readonly(np.full(count, -1, dtype=np.int64))
    return ServoReadings(
        t_ns=t_ns,
        position_ticks=zeros,
        velocity_counts=zeros,
        current_counts=zeros,
        duty_counts=zeros,
        voltage_counts=zeros,
        temperature_c=zeros,
        error_byte=zeros,
        hardware_error=unknown,
        valid=readonly(np.zeros(count, dtype=bool)),
        age_ns=unknown,
    )


@quick
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


@quick
@dataclass(frozen=True, slots=True, eq=False)
class BodyTruth:
    """Ground truth, where one exists (the plant, or motion capture); what is not known of it is NaN.

    Attributes:
        t_ns: Time it holds for.
        position_W: Body origin in the world, (3,) [m].
        quaternion_xyzw: Body to world, (4,), scalar last. Where only the heading is known, x and y are NaN
            (``model.motion.se2.heading_quaternion``).
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

    @property
    def pose(self) -> FloatArray:
        """Position [m] and quaternion x y z w, (7,)."""
        return np.concatenate([self.position_W, self.quaternion_xyzw])

    @property
    def planar_velocity_B(self) -> FloatArray:  # noqa: N802
        """vx, vy [m/s], yaw rate [rad/s], body axes, (3,)."""
        return np.array([*self.velocity_B[:2], self.angular_velocity_B[2]])


@dataclass(frozen=True, slots=True, eq=False)
class PoseRecord:
    """An absolute pose from outside: motion capture, a camera, a surveyor.

    Attributes:
        t_ns: When it was measured, on the loop's clock.
        position_W: (3,) [m], in its own world.
        quaternion_xyzw: Body to world, (4,), scalar last; NaN where only the place is known.
        sd_position_m: Standard deviation of the position [m]; NaN if it was not told.
        sd_angle_rad: The same of the angles [rad].
    """

    t_ns: int
    position_W: FloatArray  # noqa: N815
    quaternion_xyzw: FloatArray
    sd_position_m: float
    sd_angle_rad: float


@quick
@dataclass(frozen=True, slots=True)
class ImuRecord:
    """A reading of an inertial unit, as it reported it: its own axes, nothing subtracted.

    Attributes:
        t_ns: When it was measured, on the loop's clock.
        yaw_rate_rad_s: About its z axis [rad/s]; NaN without a gyro. So are the angles without them.
        roll_rad: About its x axis [rad], after ``pitch_rad``: a vector of its own is turned into the
            world's by roll first, then pitch, then yaw.
        pitch_rad: About its y axis [rad].
    """

    t_ns: int
    yaw_rate_rad_s: float
    roll_rad: float
    pitch_rad: float
