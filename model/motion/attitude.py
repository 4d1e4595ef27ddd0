"""Roll, pitch and yaw of rotations, also where the nose points straight up or down.

There a turn about the vertical and one about the body's own axis are one and the same. The convention is
that of ``scipy``: roll is 0, and yaw is all of the turn; the three angles still make the same rotation.
"""

import warnings

import numpy as np
from scipy.spatial.transform import Rotation

from model.values.arrays import BoolArray, FloatArray

# A pitch this close to a quarter turn [rad] is one: below it scipy no longer tells roll from yaw.
POLE_RAD = 1e-7


def roll_pitch_yaw(turns: Rotation) -> FloatArray:
    """Return the angles of rotations of the body into the world, (..., 3) [rad].

    Yaw about z first, then pitch about the turned y, then roll; pitch is within a quarter turn, the others
    within half a turn.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Gimbal lock", UserWarning)  # said above
        yaw_first: FloatArray = turns.as_euler("ZYX")
    return yaw_first[..., ::-1]


def nose_vertical(turns: FloatArray) -> BoolArray:
    """Tell where roll and yaw are indistinguishable, of matrices (T, 3, 3); False where one is NaN."""
    ahead: BoolArray = np.hypot(turns[:, 0, 0], turns[:, 1, 0]) < POLE_RAD
    return ahead
