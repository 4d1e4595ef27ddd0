"""What the servos can follow: a gait stays inside it, or is refused with the limit named."""

import numpy as np

from gaits.gait import Gait
from model.errors import GaitRefused
from model.values.parameters import ServoParameters

STEERING = (-1.0, 0.0, 1.0)  # slope and curvature are monotone in between


def gait_peaks(gait: Gait) -> tuple[float, float]:
    """Return the largest slope [rad a cycle] and curvature over all steering."""
    peaks = [gait.peaks(steer) for steer in STEERING]
    return max(p[0] for p in peaks), max(p[1] for p in peaks)


def check_gait(gait: Gait, frequency_hz: float, servo: ServoParameters) -> None:
    """Refuse a gait at a frequency that the servos cannot follow, at any steering.

    Raises:
        GaitRefused: Speed or acceleration exceed the robot file's limits.
    """
    slope, curvature = gait_peaks(gait)
    speed, acceleration = slope * frequency_hz, curvature * frequency_hz**2
    if speed > servo.max_speed:
        raise GaitRefused("servo.max_speed", speed, servo.max_speed, "rad/s")
    if acceleration > servo.max_acceleration:
        raise GaitRefused("servo.max_acceleration", acceleration, servo.max_acceleration, "rad/s^2")


def frequency_limit(gait: Gait, servo: ServoParameters) -> float:
    """Return the highest frequency that passes ``check_gait`` [Hz]; 0 if none does."""
    slope, curvature = gait_peaks(gait)
    by_speed = servo.max_speed / slope
    by_acceleration = float(np.sqrt(servo.max_acceleration / curvature)) if curvature else np.inf
    return min(by_speed, by_acceleration) * (1 - 1e-9)
