"""A walking foot's path fore and aft and up: even speed backward in stance, a lifted return."""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import FloatArray
from model.values.legs import FootMotion


@dataclass(frozen=True, slots=True)
class FootPath:
    """Path of one foot over a gait cycle, about a resting point.

    The return is a cubic that leaves and reaches the ground at the speed of stance, so that the
    velocity never jumps; the lift is a squared sine, which begins and ends without vertical speed.

    Attributes:
        stroke_m: Way of the foot in stance [m].
        lift_m: Highest point of the return [m].
        duty: Stance share of the cycle, above 0 and below 1.

    Raises:
        ModelError: The duty is no share, or stroke or lift are negative.
    """

    stroke_m: float
    lift_m: float
    duty: float

    def __post_init__(self) -> None:
        if not 0 < self.duty < 1:
            raise ModelError(f"the duty must lie between 0 and 1, not {self.duty:g}")
        if self.stroke_m < 0 or self.lift_m < 0:
            raise ModelError("stroke and lift of a foot cannot be negative")


def walk(path: FootPath, rest_B: FloatArray, phase: FloatArray, rate: FloatArray) -> FootMotion:  # noqa: N803
    """Feet that follow a path.

    Args:
        path: The path of every foot.
        rest_B: Middle of each foot's stance, body frame, (N, 3) [m].
        phase: Phase of each leg in cycles, stance begins at whole numbers, (F, N).
        rate: Its rate [cycles/s], (F, N) or anything that broadcasts to it.

    Returns:
        Positions and velocities, (F, N, 3).
    """
    share = np.mod(phase, 1.0)
    stance = share < path.duty
    width = 1 - path.duty
    u = np.where(stance, 0.0, (share - path.duty) / width)  # share of the return
    stance_slope = -path.stroke_m / path.duty  # [m/cycle]
    end = stance_slope * width  # per unit of u
    x = np.where(
        stance,
        path.stroke_m / 2 + stance_slope * share,
        path.stroke_m * (3 * u**2 - 2 * u**3 - 0.5) + end * (u - 3 * u**2 + 2 * u**3),
    )
    x_slope = np.where(
        stance,
        stance_slope,
        (path.stroke_m * (6 * u - 6 * u**2) + end * (1 - 6 * u + 6 * u**2)) / width,
    )
    z = path.lift_m * np.sin(np.pi * u) ** 2
    z_slope = np.where(stance, 0.0, path.lift_m * np.pi * np.sin(2 * np.pi * u) / width)
    still = np.zeros_like(x)
    position = rest_B + np.stack([x, still, z], axis=-1)
    velocity = np.stack([x_slope * rate, still, z_slope * rate], axis=-1)
    return FootMotion(position, velocity)
