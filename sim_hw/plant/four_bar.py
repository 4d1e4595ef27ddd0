"""The plant's own four-bar: solved by angles, independently of the model's vector solution.

Two implementations of one mechanism, so that a mistake in either shows as a difference between the
robot's feet and the model's.
"""

import math

import numpy as np

from model.compiled import compiled
from model.values.arrays import FloatArray
from sim_hw.plant.parameters import PlantParameters

# Columns of the geometry that the compiled code takes, one row a leg.
CRANK, COUPLER, ROCKER, PIVOT_X, PIVOT_Z, FOOT_X, FOOT_Z, BRANCH, MID_STANCE = range(9)


@compiled
def four_bar_point(
    geometry: FloatArray, shaft_rad: float
) -> tuple[float, float, float, float, float, float]:
    """Return the foot of one leg, its slope, and the coupler's turn.

    Args:
        geometry: Row of ``leg_geometry``, (9,).
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


def leg_geometry(plant: PlantParameters) -> FloatArray:
    """Return the dimensions of every leg's linkage as the compiled code takes them, (N, 9)."""
    geometry = np.empty((plant.legs, 9))
    geometry[:, CRANK], geometry[:, COUPLER] = plant.crank, plant.coupler
    geometry[:, ROCKER] = plant.rocker
    geometry[:, PIVOT_X:FOOT_X] = plant.ground_pivot
    geometry[:, FOOT_X:BRANCH] = plant.foot
    geometry[:, BRANCH], geometry[:, MID_STANCE] = plant.branch, plant.mid_stance
    return geometry


@compiled
def _paths(geometry: FloatArray, angles: FloatArray, out: FloatArray) -> None:
    for i in range(angles.shape[0]):
        for k in range(angles.shape[1]):
            point = four_bar_point(geometry[k], angles[i, k])
            for j in range(4):
                out[j, i, k] = point[j]


def foot_path(
    plant: PlantParameters, shaft_rad: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the unloaded feet in their legs' planes and their slopes.

    Args:
        plant: Dimensions.
        shaft_rad: Crank angles, (..., N).

    Returns:
        x, z [m] and dx/dangle, dz/dangle [m/rad], each (..., N).
    """
    flat = np.ascontiguousarray(shaft_rad, dtype=np.float64).reshape(-1, plant.legs)
    out = np.empty((4, *flat.shape))
    _paths(leg_geometry(plant), flat, out)
    x, z, x_slope, z_slope = out.reshape(4, *np.shape(shaft_rad))
    return x, z, x_slope, z_slope
