"""What passes a stage of the chain, and what a user's effect of that stage gets and returns.

F frames of J joints and N legs; body axes unless noted. Return a changed copy
(``dataclasses.replace``); never write into the arrays.
"""

from dataclasses import dataclass

from model.values.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ShaftSignals:
    """Actuation, after the chain's own servo.

    Attributes:
        time_s: (F,).
        command_rad: What was asked for, (F, J).
        load_nm: Torque of the foot's force about the shaft, positive where it drives it on, (F, J).
        shaft_rad: Where the shaft is, (F, J).
    """

    time_s: FloatArray
    command_rad: FloatArray
    load_nm: FloatArray
    shaft_rad: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FootSignals:
    """Kinematics, after the chain's own linkage.

    Attributes:
        time_s: (F,).
        crank_rad: Crank angle, or angles of all joints, (F, J).
        position_m: Unloaded feet in the body frame, (F, N, 3).
        slope_m_rad: Motion of the foot with its shaft, x and z, (F, N, 2); NaN, (1, N, 2), where a leg has
            several joints.
        jacobian_m_rad: Motion of such feet with all joints, (F, N, 3, J), where loads move them, else None.
    """

    time_s: FloatArray
    crank_rad: FloatArray
    position_m: FloatArray
    slope_m_rad: FloatArray
    jacobian_m_rad: FloatArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class SupportSignals:
    """Support, before its balance.

    Attributes:
        time_s: (F,).
        feet_m: Unloaded feet in the body frame, (F, N, 3).
        ground_m: Height of the ground under each foot, (F, N).
        stiffness_n_m: Springs of leg and ground together, (N,).
        weight_n: Weight carried.
        com_m: Where the weight acts in the body frame, (F, 2).
    """

    time_s: FloatArray
    feet_m: FloatArray
    ground_m: FloatArray
    stiffness_n_m: FloatArray
    weight_n: float
    com_m: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FrictionSignals:
    """Friction and external forces, before their balance.

    Attributes:
        time_s: (F,).
        feet_m: Feet in the body frame, (F, N, 2).
        speed_m_s: Their velocities in it, (F, N, 2).
        load_n: (F, N).
        mu: Friction coefficients, (F, N).
        anisotropy_B: w of each foot, (F, N, 2).
        wrench_B: Force x, y [N] and moment about z through the body's origin [N m] that act on the
            body besides its feet, (F, 3).
    """

    time_s: FloatArray
    feet_m: FloatArray
    speed_m_s: FloatArray
    load_n: FloatArray
    mu: FloatArray
    anisotropy_B: FloatArray  # noqa: N815 - frame suffix
    wrench_B: FloatArray  # noqa: N815


@dataclass(frozen=True, slots=True, eq=False)
class MotionSignals:
    """Dynamics, after the balance: vx, vy [m/s], yaw rate [rad/s], (F, 3)."""

    time_s: FloatArray
    velocity_B: FloatArray  # noqa: N815


@dataclass(frozen=True, slots=True, eq=False)
class SensorSignals:
    """Sensing, after the chain's own sensors.

    Attributes:
        time_s: (F,).
        shaft_rad: Encoders, (F, J).
        foot_m: Foot markers in the body frame, with the leg's compression, (F, N, 3).
        force_n: Force-torque sensors, (F, N, 3).
        body_m: Body in the world, (F, 3).
        body_rad: Roll, pitch, yaw, (F, 3).
    """

    time_s: FloatArray
    shaft_rad: FloatArray
    foot_m: FloatArray
    force_n: FloatArray
    body_m: FloatArray
    body_rad: FloatArray
