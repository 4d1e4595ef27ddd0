"""Legs that turn about two axes and slide: feet and their exact velocities.

A foot sits at ``arm`` in the frame of its leg, which rolls about its own x axis, then yaws about the
vertical through ``pivot``, then slides up and down::

    foot = pivot + Rz(yaw) Rx(roll) arm + (0, 0, slide)
"""

import numpy as np

from model.values.arrays import FloatArray
from model.values.legs import FootMotion

YAW, ROLL, SLIDE = 0, 1, 2  # [rad], [rad], [m]: places of a leg's joints


def swing(pivot: FloatArray, arm: FloatArray, joints: FloatArray, rates: FloatArray) -> FootMotion:
    """Feet in the body frame.

    Args:
        pivot: Where each leg turns, body frame, (N, 3) [m].
        arm: Foot in the leg's frame, (N, 3) [m].
        joints: Yaw from body x towards body y, roll about the yawed x axis [rad], slide upwards [m] of
            F frames, (F, N, 3).
        rates: Their rates [rad/s], [m/s], (F, N, 3).

    Returns:
        Positions and velocities, (F, N, 3).
    """
    position = np.einsum("...ij,...j->...i", rotations(joints), arm, order="C")
    turning = rates[..., ROLL, None] * np.stack(
        [np.cos(joints[..., YAW]), np.sin(joints[..., YAW]), np.zeros(joints.shape[:2])], axis=-1
    )
    turning[..., 2] = rates[..., YAW]
    velocity = np.cross(turning, position)
    velocity[..., 2] += rates[..., SLIDE]
    position += pivot
    position[..., 2] += joints[..., SLIDE]
    return FootMotion(position, velocity)


def rotations(joints: FloatArray) -> FloatArray:
    """Rotations from the legs' frames to the body frame, Rz(yaw) Rx(roll), (..., 3, 3)."""
    cy, cr = np.cos(joints[..., YAW]), np.cos(joints[..., ROLL])
    sy, sr = np.sin(joints[..., YAW]), np.sin(joints[..., ROLL])
    rows = [[cy, -sy * cr, sy * sr], [sy, cy * cr, -cy * sr], [0 * cr, sr, cr]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
