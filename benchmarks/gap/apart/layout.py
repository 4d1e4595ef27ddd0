"""Legs, joints and sizes of the hexapod: two joints a leg, yaw at the hip and lift behind it.

Axes of the trunk: x ahead, y left, z up. A leg at zero points along its mount's direction, its shank down.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]
IndexArray: TypeAlias = NDArray[np.intp]


class Mount(NamedTuple):
    """Place of a hip in the trunk [m], and the direction in which its leg points [deg]."""

    x_m: float
    y_m: float
    direction_deg: float


MOUNTS = {
    "L1": Mount(0.16, 0.07, 60),
    "L2": Mount(0.0, 0.10, 90),
    "L3": Mount(-0.16, 0.07, 120),
    "R1": Mount(0.16, -0.07, -60),
    "R2": Mount(0.0, -0.10, -90),
    "R3": Mount(-0.16, -0.07, -120),
}
LEGS = tuple(MOUNTS)
JOINTS = tuple(f"{leg}_{joint}" for leg in LEGS for joint in ("yaw", "lift"))

COXA_M = 0.05  # from the axis of yaw to that of lift
FEMUR_M = 0.11  # from the axis of lift out to the shank
SHANK_M = 0.130  # from the axis of lift down to the centre of the foot
FOOT_RADIUS_M = 0.012
HIP_HEIGHT_M = 0.013  # of the axes over the trunk's centre

FOOT_FRICTION = 0.7
SHANK_STIFFNESS_N_M = 5000.0
POSITION_GAIN_NM_RAD = 60.0
RATE_GAIN_NM_S_RAD = 1.2
TORQUE_LIMIT_NM = 6.0
