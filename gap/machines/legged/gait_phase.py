"""Where in the cycle of its gait a legged machine is, over a run."""

import numpy as np

from model.values.arrays import FloatArray

TURNING = (
    0.5  # share of a gait's cycles from which on shafts turn with it; one cycle always is enough
)
LEAST_SWING_RAD = 1e-3
CLEAR_SWING = 0.3  # share of the largest swing from which on a joint's is one to go by


def gait_cycle(
    time_s: FloatArray, command_rad: FloatArray, shaft_rad: FloatArray, frequency_hz: float
) -> FloatArray:
    """Return cycles of the gait, (W,): from the commands, else from the shafts; NaN if not known.

    Cranks and wheel-legs turn once a cycle: their mean angle since the start says where they are. Joints
    that swing come back to where they were. There the gait's frequency says how fast the cycle goes on, and
    the first joint that clearly swings with it where it begins: at that joint's largest angle, whenever the
    run was begun.

    Args:
        time_s: (W,).
        command_rad: Of J joints, (W, J); NaN where there is none.
        shaft_rad: Measured, (W, J).
        frequency_hz: Of the gait; NaN if it is not known.
    """
    since_s = time_s - time_s[0]
    evenly: FloatArray = frequency_hz * since_s
    turning = np.fmin(1.0, TURNING * evenly[-1])  # cycles that shafts turn which turn with the gait
    for angles in (command_rad, shaft_rad):
        known = np.isfinite(angles).all(axis=0)
        if not known.any():
            continue
        moved = angles[:, known] - angles[0, known]
        directions = np.sign(moved[-1])  # of a robot that turns on the spot, shafts turn both ways
        directions *= 1.0 if directions.sum() >= 0.0 else -1.0
        turned: FloatArray = (moved * directions).mean(axis=1) / (2 * np.pi)
        if abs(turned[-1]) >= turning:
            return turned
        wave = np.exp(-2j * np.pi * evenly)[:, None]
        swing = 2.0 * np.mean((moved - moved.mean(axis=0)) * wave, axis=0)
        size = np.abs(swing)
        if size.max() > LEAST_SWING_RAD:  # NaN without a frequency
            first = int(np.argmax(size >= CLEAR_SWING * size.max()))
            return evenly + float(np.angle(swing[first])) / (2 * np.pi)
    return evenly
