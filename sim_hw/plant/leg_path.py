"""The end of a leg of any kind in the plant, as the compiled code asks for it."""

import math

import numpy as np

from model.compiled import compiled, in_place
from model.values.arrays import FloatArray
from sim_hw.plant.four_bar import four_bar_point, four_bar_row
from sim_hw.plant.parameters import FourBarLegs, PlantParameters

# A row of the geometry holds the dimensions of its kind, and which that is.
KIND = 9
FOUR_BAR, CRANK = 0.0, 1.0


def leg_geometry(plant: PlantParameters) -> FloatArray:
    """Return the dimensions of every leg as the compiled code takes them, (N, 10)."""
    geometry = np.zeros((plant.legs, KIND + 1))
    legs = plant.leg
    if isinstance(legs, FourBarLegs):
        geometry[:, :KIND], geometry[:, KIND] = four_bar_row(legs), FOUR_BAR
    else:
        geometry[:, 0], geometry[:, 1], geometry[:, KIND] = legs.length, legs.radius, CRANK
    return geometry


@in_place
@compiled
def leg_point(
    geometry: FloatArray, shaft_rad: float
) -> tuple[float, float, float, float, float, float]:
    """Return the end of one leg, its slope, and how far what turns at it has turned.

    Args:
        geometry: Row of ``leg_geometry``, (10,).
        shaft_rad: Shaft angle from mid-stance.

    Returns:
        x, z [m]; dx/dangle, dz/dangle [m/rad] of the place; the foot's turn, from +x towards +z [rad], and
        its slope.
    """
    if geometry[KIND] == CRANK:
        return _crank_point(geometry[0], geometry[1], shaft_rad)
    return four_bar_point(geometry, shaft_rad)


@in_place
@compiled
def _crank_point(
    length: float, radius: float, shaft_rad: float
) -> tuple[float, float, float, float, float, float]:
    """A crank: physics of its own, apart from ``model.kinematics.crank``.

    A half circle is lowest below its centre as long as that is on it, else at the toe; what is lowest while
    the leg is above the shaft slides from the toe to the half circle's other end.
    """
    half_turns = math.floor(shaft_rad / math.pi)
    past = shaft_rad - half_turns * math.pi  # since the toe was straight down, or up
    down = math.cos(shaft_rad), math.sin(shaft_rad)
    if radius == 0.0:
        return (
            -length * down[1],
            -length * down[0],
            -length * down[0],
            length * down[1],
            -shaft_rad,
            -1.0,
        )
    odd = half_turns % 2 != 0
    if odd:  # the toe is on its way down, the half circle below it
        centre = length - radius
        rolled = -(half_turns + 1) // 2 * math.pi + math.pi - past
        return (
            -centre * down[1], -centre * down[0] - radius, -centre * down[0], centre * down[1],
            rolled, -1.0,
        )  # fmt: skip
    rolled = -half_turns // 2 * math.pi
    share = max(past / (math.pi / 2) - 1.0, 0.0)
    reach = length - 2 * radius * share * share * (3.0 - 2.0 * share)
    slope = -2 * radius * 6.0 * share * (1.0 - share) / (math.pi / 2)
    return (
        -reach * down[1], -reach * down[0],
        -reach * down[0] - slope * down[1], reach * down[1] - slope * down[0], rolled, 0.0,
    )  # fmt: skip


@in_place
@compiled
def _paths(geometry: FloatArray, angles: FloatArray, out: FloatArray) -> None:
    for i in range(angles.shape[0]):
        for k in range(angles.shape[1]):
            point = leg_point(geometry[k], angles[i, k])
            for j in range(4):
                out[j, i, k] = point[j]


def foot_path(
    plant: PlantParameters, shaft_rad: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the unloaded feet in their legs' planes and their slopes.

    Args:
        plant: Dimensions.
        shaft_rad: Shaft angles, (..., N).

    Returns:
        x, z [m] and dx/dangle, dz/dangle [m/rad], each (..., N).
    """
    flat = np.ascontiguousarray(shaft_rad, dtype=np.float64).reshape(-1, plant.legs)
    out = np.empty((4, *flat.shape))
    _paths(leg_geometry(plant), flat, out)
    x, z, x_slope, z_slope = out.reshape(4, *np.shape(shaft_rad))
    return x, z, x_slope, z_slope
