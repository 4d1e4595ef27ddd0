"""The plant's own four-bar: solved by angles, independently of the model's vector solution.

Two implementations of one mechanism, so that a mistake in either shows as a difference between the
robot's feet and the model's.
"""

import math

import numpy as np

from model.compiled import compiled, in_place
from model.values.arrays import FloatArray
from sim_hw.plant.parameters import FourBarLegs

# What the compiled code takes of a leg, a row.
CRANK, COUPLER, ROCKER, PIVOT_X, PIVOT_Z, FOOT_X, FOOT_Z, BRANCH, MID_STANCE = range(9)


def four_bar_row(legs: FourBarLegs) -> FloatArray:
    """Return the dimensions as ``four_bar_point`` takes them, (N, 9)."""
    rows = np.empty((len(legs.crank), 9))
    rows[:, CRANK], rows[:, COUPLER], rows[:, ROCKER] = legs.crank, legs.coupler, legs.rocker
    rows[:, PIVOT_X:FOOT_X], rows[:, FOOT_X:BRANCH] = legs.ground_pivot, legs.foot
    rows[:, BRANCH], rows[:, MID_STANCE] = legs.branch, legs.mid_stance
    return rows


@in_place
@compiled
def four_bar_point(
    geometry: FloatArray, shaft_rad: float
) -> tuple[float, float, float, float, float, float]:
    """Return the foot of one leg, its slope, and the coupler's turn.

    Args:
        geometry: Row of ``four_bar_row``, (9,) or longer.
        shaft_rad: Crank angle from mid-stance.

    Returns:
        x, z [m]; dx/dangle, dz/dangle [m/rad]; the coupler's direction, from +x towards +z [rad], and its
        slope.
    """
    crank, coupler, rocker = geometry[0], geometry[1], geometry[2]
    px, pz, fx, fz = geometry[3], geometry[4], geometry[5], geometry[6]
    crank_angle = geometry[8] - shaft_rad
    ax, az = crank * math.cos(crank_angle), crank * math.sin(crank_angle)
    dx, dz = px - ax, pz - az
    distance = math.hypot(dx, dz)
    cosine = (coupler**2 + distance**2 - rocker**2) / (2 * coupler * distance)
    opening = math.acos(min(max(cosine, -1.0), 1.0))
    coupler_angle = math.atan2(dz, dx) + geometry[7] * opening
    c, s = math.cos(coupler_angle), math.sin(coupler_angle)
    x = ax + fx * c - fz * s
    z = az + fx * s + fz * c
    # slopes by the velocity triangle: coupler and rocker rates for unit crank rate
    rocker_angle = math.atan2(az + coupler * s - pz, ax + coupler * c - px)
    sine = math.sin(coupler_angle - rocker_angle)
    coupler_rate = -crank * math.sin(crank_angle - rocker_angle) / (coupler * sine)
    x_slope = -az - (z - az) * coupler_rate
    z_slope = ax + (x - ax) * coupler_rate
    return x, z, -x_slope, -z_slope, coupler_angle, -coupler_rate
