"""Shafts and feet of all legs: measured, commanded, and as geometry has them."""

from dataclasses import dataclass

import numpy as np

from model.values.arrays import BoolArray, FloatArray
from model.values.quick import quick


@quick
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


@quick
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


@quick
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


@quick
@dataclass(frozen=True, slots=True, eq=False)
class FootMotion:
    """Feet relative to the body, unloaded, body frame.

    Attributes:
        position_m: (..., N, 3) [m].
        velocity_m_s: (..., N, 3) [m/s], the exact derivative along the shaft speed.
    """

    position_m: FloatArray
    velocity_m_s: FloatArray


def no_feet(legs: int) -> FootMotion:
    """Return what is known of ``legs`` feet where the linkage was not evaluated."""
    absent = np.full((legs, 3), np.nan)
    return FootMotion(absent, absent)
