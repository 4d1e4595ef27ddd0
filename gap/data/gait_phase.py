"""Where in the cycle of its gait, or of its excitation, a machine is, over a run.

Runs are compared at equal phase, so it must not depend on where in the cycle a run was begun.
"""

import numpy as np

from model.values.arrays import FloatArray

# Share of a gait's cycles from which on shafts turn with it; one cycle always is enough.
TURNING = 0.5
LEAST_SWING_RAD = 1e-3
CLEAR_SWING = 0.3  # share of the largest swing from which on a joint's is one to go by


def gait_cycle(
    time_s: FloatArray,
    command_rad: FloatArray,
    shaft_rad: FloatArray,
    frequency_hz: float,
    *,
    cranks: bool = True,
) -> FloatArray:
    """Return cycles of the gait, (W,): from the commands, else from the shafts; NaN if not known.

    Cranks and wheel-legs turn once a cycle: their mean angle says how far it has gone on, and it begins
    where the first of them is at 0. Joints that swing come back to where they were. There the gait's
    frequency says how fast the cycle goes on, and it begins at the largest angle of the first joint that
    clearly swings with it. So runs of a gait have the same phase wherever in it they were begun.

    Args:
        time_s: (W,).
        command_rad: Of J joints, (W, J); NaN where there is none.
        shaft_rad: Measured, (W, J).
        frequency_hz: Of the gait; NaN if it is not known.
        cranks: Whether shafts that turn may be those. A wheel of another machine turns as it likes.
    """
    evenly: FloatArray = frequency_hz * (time_s - time_s[0])
    for angles in (command_rad, shaft_rad):
        known = np.isfinite(angles).all(axis=0)
        if not known.any():
            continue
        if cranks and (turned := _of_cranks(angles[:, known], evenly)) is not None:
            return turned
        if np.isfinite(begun := _of_swing(angles[:, known], evenly)):
            return evenly + begun
    return evenly


def _of_cranks(angle_rad: FloatArray, evenly: FloatArray) -> FloatArray | None:
    """Cycles of shafts that turn with the gait, whole where the first is at 0; None if they do not turn."""
    moved = angle_rad - angle_rad[0]
    directions = np.sign(moved[-1])  # of a robot that turns on the spot, shafts turn both ways
    directions *= 1.0 if directions.sum() >= 0.0 else -1.0
    turned: FloatArray = (moved * directions).mean(axis=1) / (2 * np.pi)
    if not abs(turned[-1]) >= np.fmin(1.0, TURNING * evenly[-1]):
        return None
    first = int(np.argmax(np.abs(moved[-1]) >= 2 * np.pi * TURNING * abs(turned[-1])))
    own = angle_rad[:, first] * directions[first] / (2 * np.pi)
    return turned + _from_its_zero(turned, own)


def _of_swing(angle_rad: FloatArray, evenly: FloatArray) -> float:
    """Phase at the start of the first joint that clearly swings with the gait, 0 at its largest angle.

    NaN where none does.
    """
    if evenly[-1] >= 1.0:  # what is left of a cycle at the end would turn the phase
        whole = evenly < np.floor(evenly[-1])
        angle_rad, evenly = angle_rad[whole], evenly[whole]
    wave = np.exp(-2j * np.pi * evenly)[:, None]
    swing = 2.0 * np.mean((angle_rad - angle_rad.mean(axis=0)) * wave, axis=0)
    size = np.abs(swing)
    if not size.max() > LEAST_SWING_RAD:  # NaN without a frequency
        return np.nan
    first = int(np.argmax(size >= CLEAR_SWING * size.max()))
    return float(np.angle(swing[first])) / (2 * np.pi)


def _from_its_zero(turned: FloatArray, own: FloatArray) -> float:
    """Return what to add to cycles, (W,), so that they are whole where a joint's own turns, (W,), are.

    Joints turn unevenly in a cycle, each in its own way, so only where that joint passes 0 does it tell the
    phase; a run that is too short for that has it in the mean.
    """
    forward = np.sign(turned[-1])
    done, ahead = np.maximum.accumulate(own * forward), turned * forward
    passed = np.arange(np.ceil(done[0]), np.floor(done[-1]) + 1)
    behind = np.interp(passed, done, ahead) if len(passed) else ahead - done
    return float(-forward * np.angle(np.mean(np.exp(2j * np.pi * behind))) / (2 * np.pi))
