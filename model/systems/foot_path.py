"""A walking foot's path fore and aft and up: even speed backward in stance, a lifted return."""

import numpy as np

from model.values.arrays import FloatArray
from model.values.legs import FootMotion


def walk(
    rest_B: FloatArray,  # noqa: N803
    phase: FloatArray,
    frequency_hz: float,
    *,
    stroke_m: float,
    lift_m: float,
    duty: float,
) -> FootMotion:
    """Feet that follow a path about a resting point.

    The return is a cubic that leaves and reaches the ground at the speed of stance, so that the
    velocity never jumps; the lift is a squared sine, which begins and ends without vertical speed.

    Args:
        rest_B: Middle of each foot's stance, body frame, (N, 3) [m].
        phase: Phase of each leg in cycles, stance begins at whole numbers, (F, N).
        frequency_hz: Its rate [cycles/s].
        stroke_m: Length of the stance on the ground [m].
        lift_m: Highest point of the return [m].
        duty: Stance share of the cycle, above 0 and below 1.

    Returns:
        Positions and velocities, (F, N, 3).
    """
    share = np.mod(phase, 1.0)
    stance = share < duty
    width = 1 - duty
    u = np.where(stance, 0.0, (share - duty) / width)  # share of the return
    stance_slope = -stroke_m / duty  # [m/cycle]
    end = stance_slope * width  # per unit of u
    x = np.where(
        stance,
        stroke_m / 2 + stance_slope * share,
        stroke_m * (3 * u**2 - 2 * u**3 - 0.5) + end * (u - 3 * u**2 + 2 * u**3),
    )
    x_slope = np.where(
        stance,
        stance_slope,
        (stroke_m * (6 * u - 6 * u**2) + end * (1 - 6 * u + 6 * u**2)) / width,
    )
    z = lift_m * np.sin(np.pi * u) ** 2
    z_slope = np.where(stance, 0.0, lift_m * np.pi * np.sin(2 * np.pi * u) / width)
    still = np.zeros_like(x)
    position = rest_B + np.stack([x, still, z], axis=-1)
    return FootMotion(position, frequency_hz * np.stack([x_slope, still, z_slope], axis=-1))
