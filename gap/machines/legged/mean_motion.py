"""How fast the body is in the mean of whole cycles of the gait.

The slope of a measured place is noise at any one time, and in the mean over a window the noise of all but
its ends cancels. So a speed that is off by a hundredth is hidden in every frame, and plain in the mean.
"""

import math

import numpy as np

from gap.machines.legged.grip import Windows
from model.compiled import compiled
from model.values.arrays import FloatArray, IntArray

MEANS = (("vx", "m/s"), ("vy", "m/s"), ("wz", "rad/s"))


def means_of(windows: Windows, velocity_B: FloatArray) -> FloatArray:  # noqa: N803 - frame suffix
    """Return the mean of each window, (F, 3), of velocities in body axes, (F, 3).

    NaN where more than half of a window is not known.
    """
    out = np.empty(velocity_B.shape)
    _means(windows.starts, velocity_B, out)
    return out


@compiled
def _means(starts: IntArray, values: FloatArray, out: FloatArray) -> None:
    for w in range(len(starts) - 1):
        first, last = starts[w], starts[w + 1]
        for i in range(values.shape[1]):
            total, count = 0.0, 0
            for f in range(first, last):
                if np.isfinite(values[f, i]):
                    total += values[f, i]
                    count += 1
            mean = total / count if 2 * count >= last - first and count > 0 else np.nan
            for f in range(first, last):
                out[f, i] = mean


def mean_noise(position_m: float, angle_rad: float, window_s: float) -> FloatArray:
    """Return the noise of the three means, from that of the places where a window begins and ends."""
    return math.sqrt(2.0) / window_s * np.array([position_m, position_m, angle_rad])
