"""At which flank of its gear's play a joint lies, by the torque that its loop asks for along the motion.

A loop on the motor's side of a gear holds the motor. The joint lies at the flank through which it is
driven, or held back, and goes to the other one when that torque changes sign: half a width ahead of the
motor or behind it. What rubs at the joint is overcome through the gear as well.
"""

import numpy as np
from scipy.ndimage import uniform_filter1d

from gap.machines.mujoco.drive import TorqueLaw
from model.values.arrays import FloatArray

# How long a joint takes from one flank to the other: the mean over that is as sure as its time. Assumed.
CROSSING_S = 0.05


def gear_flank(
    angle_rad: FloatArray,
    speed_rad_s: FloatArray,
    target_rad: FloatArray,
    law: TorqueLaw,
    period_s: float,
) -> FloatArray:
    """Return 1 where the motor drives the joint on and -1 where it drives it back, (F,).

    Args:
        angle_rad: Measured, (F,).
        speed_rad_s: Its slope, (F,).
        target_rad: What its loop pursues, with nothing added, (F,) or (F - 1,).
        law: Of the loop, as the file has it.
        period_s: Between frames.
    """
    target = target_rad[np.minimum(np.arange(len(angle_rad)), len(target_rad) - 1)]
    torque = law.asked(target, angle_rad, speed_rad_s) - law.back_emf * speed_rad_s
    frames = max(1, round(CROSSING_S / period_s))
    return np.asarray(uniform_filter1d(np.sign(np.nan_to_num(torque)), frames, mode="nearest"))
