"""What differs from run to run of a healthy robot: friction, springs, zeros, floor, battery, markers.

The figures in docs/gap_realities.md depend on these numbers, so their draws keep their order, with one that
nothing uses.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.gap.apart.layout import (
    FOOT_FRICTION,
    JOINTS,
    LEGS,
    POSITION_GAIN_NM_RAD,
    SHANK_STIFFNESS_N_M,
    FloatArray,
)

DRY_FRICTION_NM = 0.06


@dataclass(frozen=True, slots=True, eq=False)
class Day:
    """How a healthy robot, its floor and its sensors are in one run.

    Attributes:
        foot_friction: Coulomb's coefficient of each foot, (6,).
        shank_stiffness_n_m: Of each rubber shank, (6,).
        encoder_zero_rad: Of each joint, (12,).
        battery_offset_m: In the trunk, (x, y).
        floor_slope: Sine of the floor's slope along x and y, (2,).
        first_yaw_rad: Yaw of the trunk at first.
        first_position_m: Of the trunk at first, (x, y).
        marker_offset_m: Of the markers' origin in the trunk, (3,).
        marker_yaw_rad: Of the markers in the trunk.
        force_bias_n: Of each foot's sensor, (6, 3).
        position_gain_nm_rad: Of each joint's loop, (12,).
        dry_friction_nm: Of each joint, (12,).
    """

    foot_friction: FloatArray
    shank_stiffness_n_m: FloatArray
    encoder_zero_rad: FloatArray
    battery_offset_m: FloatArray
    floor_slope: FloatArray
    first_yaw_rad: float
    first_position_m: FloatArray
    marker_offset_m: FloatArray
    marker_yaw_rad: float
    force_bias_n: FloatArray
    position_gain_nm_rad: FloatArray
    dry_friction_nm: FloatArray


def draw_day(random: np.random.Generator) -> Day:
    """Draw how a healthy robot is in one run; arguments are evaluated, and so drawn, in this order."""
    legs, joints = len(LEGS), len(JOINTS)
    day = Day(
        foot_friction=(
            FOOT_FRICTION * (1 + 0.04 * random.normal()) * (1 + 0.03 * random.normal(size=legs))
        ),
        shank_stiffness_n_m=SHANK_STIFFNESS_N_M * (1 + 0.03 * random.normal(size=legs)),
        encoder_zero_rad=0.003 * random.normal(size=joints),
        battery_offset_m=0.001 * random.normal(size=2) * 4,
        floor_slope=0.002 * random.normal(size=2),
        first_yaw_rad=0.03 * random.normal(),
        first_position_m=0.02 * random.normal(size=2),
        marker_offset_m=0.0007 * random.normal(size=3),
        marker_yaw_rad=0.002 * random.normal(),
        force_bias_n=0.15 * random.normal(size=(legs, 3)),
        position_gain_nm_rad=POSITION_GAIN_NM_RAD * (1 + 0.02 * random.normal(size=joints)),
        dry_friction_nm=DRY_FRICTION_NM * (1 + 0.2 * random.normal(size=joints)),
    )
    random.random()  # was for an offset of clocks that the simulator does not have
    return day
