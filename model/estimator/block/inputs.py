"""What was known in ticks of a block, as arrays."""

from collections.abc import Callable
from typing import NamedTuple

from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.estimate import OdometryInputs


class BlockInputs(NamedTuple):
    """Shafts and forces of T ticks of N legs, without poses, IMU and effects.

    Attributes:
        t_ns: Times of the ticks, (T,).
        position_m: Unloaded feet, body frame, (T, N, 3); NaN for a leg without encoder.
        velocity_m_s: Of the feet, (T, N, 3).
        force_ns: Times that the newest forces hold for, -1 for none, (T,).
        force_n: These forces, (T, N, 3).
        force_there: Which of them are there, (T, N).
        shaft_rad_s: Speed of each leg's shaft, (T, N); None where legs have no shafts of their own.
        of_tick: A tick by itself.
    """

    t_ns: IntArray
    position_m: FloatArray
    velocity_m_s: FloatArray
    force_ns: IntArray
    force_n: FloatArray
    force_there: BoolArray
    shaft_rad_s: FloatArray | None
    of_tick: Callable[[int], OdometryInputs]
