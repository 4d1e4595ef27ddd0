"""Legs that turn about two axes: feet and their exact velocities.

A foot sits at ``arm`` in the frame of its leg, which rolls about its own x axis, then yaws about the
vertical through ``pivot``, then slides up and down::

    foot = pivot + Rz(yaw) Rx(roll) arm + (0, 0, slide)
"""

from dataclasses import dataclass

import numpy as np

from model.values.arrays import FloatArray
from model.values.legs import FootMotion


@dataclass(frozen=True, slots=True, eq=False)
class LegAngles:
    """Joint positions and speeds of N legs; every array is (F, N).

    Attributes:
        yaw: From body x towards body y [rad].
        roll: About the yawed x axis [rad].
        slide: Upwards [m].
        yaw_rate: [rad/s].
        roll_rate: [rad/s].
        slide_rate: [m/s].
    """

    yaw: FloatArray
    roll: FloatArray
    slide: FloatArray
    yaw_rate: FloatArray
    roll_rate: FloatArray
    slide_rate: FloatArray


def swing(pivot: FloatArray, arm: FloatArray, angles: LegAngles) -> FootMotion:
    """Feet in the body frame.

    Args:
        pivot: Where each leg turns, body frame, (N, 3) [m].
        arm: Foot in the leg's frame, (N, 3) [m].
        angles: Joints of F frames.

    Returns:
        Positions and velocities, (F, N, 3).
    """
    cr, sr = np.cos(angles.roll), np.sin(angles.roll)
    cy, sy = np.cos(angles.yaw), np.sin(angles.yaw)
    x = np.broadcast_to(arm[:, 0], cr.shape)
    y = cr * arm[:, 1] - sr * arm[:, 2]  # rolled
    z = sr * arm[:, 1] + cr * arm[:, 2]
    dy, dz = -z * angles.roll_rate, y * angles.roll_rate
    ahead, left = cy * x - sy * y, sy * x + cy * y  # yawed
    position = pivot + np.stack([ahead, left, z + angles.slide], axis=-1)
    velocity = np.stack(
        [
            -left * angles.yaw_rate - sy * dy,
            ahead * angles.yaw_rate + cy * dy,
            dz + angles.slide_rate,
        ],
        axis=-1,
    )
    return FootMotion(position, velocity)


def rotations(yaw: FloatArray, roll: FloatArray) -> FloatArray:
    """Rotations from the legs' frames to the body frame, Rz(yaw) Rx(roll), (..., 3, 3)."""
    cr, sr, cy, sy = np.cos(roll), np.sin(roll), np.cos(yaw), np.sin(yaw)
    zero = np.zeros_like(cr)
    rows = (
        np.stack([cy, -sy * cr, sy * sr], axis=-1),
        np.stack([sy, cy * cr, -cy * sr], axis=-1),
        np.stack([zero, sr, cr], axis=-1),
    )
    return np.stack(rows, axis=-2)
