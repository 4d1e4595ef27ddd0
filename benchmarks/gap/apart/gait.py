"""The tripod that is commanded: stance by the geometry of the yaw joints, swing by a cycloid."""

import math

import numpy as np

from benchmarks.gap.apart.layout import COXA_M, FEMUR_M, JOINTS, MOUNTS, FloatArray

COMMAND_RATE_HZ = 500
STAND_S = 0.5  # no foot moves before
RAMP_S = 1.0  # in which steps grow to their size
STEP_M = 0.05
LIFT_RAD = 0.30
DUTY = 0.6  # share of a period that a foot stands
FIRST_PHASE = 0.3
PHASES = {"L1": 0.0, "R2": 0.0, "L3": 0.0, "R1": 0.5, "L2": 0.5, "R3": 0.5}


def commanded_angles(period_s: float, duration_s: float) -> FloatArray:
    """Return what all joints are told, at 500 Hz.

    Args:
        period_s: Of the gait.
        duration_s: From the first command on.

    Returns:
        Angles in the order of ``JOINTS``, (samples, 12) [rad].
    """
    time_s = np.arange(int(duration_s * COMMAND_RATE_HZ)) / COMMAND_RATE_HZ
    angles = np.zeros((len(time_s), len(JOINTS)))
    ramp = np.clip((time_s - STAND_S) / RAMP_S, 0, 1)
    reach_m = COXA_M + FEMUR_M
    for leg, mount in enumerate(MOUNTS.items()):
        name, (_, _, direction_deg) = mount
        phase = (np.maximum(time_s - STAND_S, 0) / period_s + PHASES[name] + FIRST_PHASE) % 1.0
        swing = np.clip((phase - DUTY) / (1 - DUTY), 0, 1)
        cycloid = -0.5 + (swing - np.sin(2 * np.pi * swing) / (2 * np.pi))
        ahead_m = ramp * STEP_M * np.where(phase < DUTY, 0.5 - phase / DUTY, cycloid)
        rest = math.radians(direction_deg)
        pointing = np.arccos(np.clip(np.cos(rest) + ahead_m / reach_m, -1, 1))
        angles[:, 2 * leg] = np.sign(rest) * pointing - rest
        angles[:, 2 * leg + 1] = ramp * LIFT_RAD * np.sin(np.pi * swing) ** 2
    return angles
