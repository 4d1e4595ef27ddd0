"""The plant's own four-bar: solved by angles, independently of the model's vector solution.

Two implementations of one mechanism, so that a mistake in either shows as a difference between the
robot's feet and the model's.
"""

import numpy as np

from model.signals import FloatArray
from sim_hw.plant_parameters import PlantParameters


def foot_path(
    plant: PlantParameters, shaft_rad: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the foot in the leg's plane and its slope.

    Args:
        plant: Dimensions.
        shaft_rad: Shaft angles, any shape.

    Returns:
        x, z [m] and dx/dangle, dz/dangle [m/rad], each of the shape of ``shaft_rad``.
    """
    crank_angle = plant.mid_stance - shaft_rad
    px, pz = plant.ground_pivot
    ax, az = plant.crank * np.cos(crank_angle), plant.crank * np.sin(crank_angle)
    dx, dz = px - ax, pz - az
    distance = np.hypot(dx, dz)
    bearing = np.arctan2(dz, dx)
    cosine = (plant.coupler**2 + distance**2 - plant.rocker**2) / (2 * plant.coupler * distance)
    opening = np.arccos(np.clip(cosine, -1.0, 1.0))
    coupler_angle = bearing + plant.branch * opening
    c, s = np.cos(coupler_angle), np.sin(coupler_angle)
    x = ax + plant.foot[0] * c - plant.foot[1] * s
    z = az + plant.foot[0] * s + plant.foot[1] * c
    # slopes by the velocity triangle: coupler and rocker rates for unit crank rate
    rocker_angle = np.arctan2(az + plant.coupler * s - pz, ax + plant.coupler * c - px)
    sine = np.sin(coupler_angle - rocker_angle)
    coupler_rate = -plant.crank * np.sin(crank_angle - rocker_angle) / (plant.coupler * sine)
    x_slope = -az - (z - az) * coupler_rate
    z_slope = ax + (x - ax) * coupler_rate
    return x, z, -x_slope, -z_slope
