"""Poses from outside, as they come in."""

from dataclasses import dataclass

from model.values.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PoseRecord:
    """An absolute pose from outside: motion capture, a camera, a surveyor.

    Attributes:
        t_ns: When it was measured, on the loop's clock.
        position_W: (3,) [m], in its own world.
        quaternion_xyzw: Body to world, (4,), scalar last; NaN where only the place is known.
        sd_position_m: Standard deviation of the position [m]; NaN if it was not told.
        sd_angle_rad: The same of the angles [rad].
    """

    t_ns: int
    position_W: FloatArray  # noqa: N815
    quaternion_xyzw: FloatArray
    sd_position_m: float
    sd_angle_rad: float
