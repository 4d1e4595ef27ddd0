"""A leg fixed to its servo's shaft: a rigid crank, or a C-leg whose half circle rolls on the ground.

In the leg's x-z plane, d = (-sin a, -cos a) is the direction from the shaft to the toe at shaft angle a:
straight down at a = 0, swinging backward as a grows. The toe is at ``length`` d. A C-leg (RHex) is a half
circle of ``radius`` r: its centre is C = (length - r) d, its ends are the toe and (length - 2 r) d, and it
bulges towards the ground while the leg comes down. With -pi < a <= pi the foot is where the leg is lowest::

    a <= 0:          C + (0, -r)     the half circle rolls, and the toe is reached at a = 0
    0 < a <= pi/2:   length d        the leg turns about its toe
    a > pi/2:        (length - 2 r s) d,  s = 3 t^2 - 2 t^3,  t = 2 a / pi - 1

The last line is above the shaft, where no leg stands: it leads steadily from the toe to the other end. With
r = 0 all of it is the toe. A foot's velocity is that of the leg's matter at the foot, not of the place of
contact, which runs along the half circle: the matter turns about the shaft, so that at a foot (x, z)

    d(x, z)/da = (z, -x)

and a wheel that rolls on flat ground stands still where it touches. The half circle's own turn, which leads
from the velocity of the place to that of the matter, is ``roll``.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from model.compiled import compile_for, compiled, given, in_place, out
from model.errors import ConfigError
from model.kinematics.one_shaft import OneShaftKinematics
from model.values.arrays import FloatArray
from model.values.parameters import CrankParameters


@dataclass(frozen=True, slots=True, eq=False)
class CrankPose:
    """A crank at some shaft angles; every array has the shape of the angles, and 2 for (x, z).

    Attributes:
        foot: (..., 2) [m], relative to the shaft.
        foot_slope: Motion of the leg's matter at the foot with the shaft, (..., 2) [m/rad].
        roll: How far the half circle has rolled, from +x towards +z, over all turns, (...) [rad].
    """

    foot: FloatArray
    foot_slope: FloatArray
    roll: FloatArray


def check_crank(crank: CrankParameters, named: Callable[[str], str] = "leg.{}".format) -> None:
    """Refuse a leg whose half circle does not end between shaft and toe.

    Args:
        crank: Dimensions.
        named: Name of a key as its file has it, for the message.

    Raises:
        ConfigError: It is none; names the key and the figures.
    """
    if 2 * crank.radius > crank.length * (1 + 1e-9):
        raise ConfigError(
            named("radius"),
            f"a half circle of {crank.radius * 1e3:.1f} mm does not fit between a shaft and a toe "
            f"{crank.length * 1e3:.1f} mm apart; give at most half of the length",
        )


def crank_pose(crank: CrankParameters, angle_rad: FloatArray) -> CrankPose:
    """Return foot, slope and roll.

    Args:
        crank: Dimensions.
        angle_rad: Shaft angles, any shape [rad].
    """
    angle = np.asarray(angle_rad, dtype=np.float64)
    rows = np.empty((angle.size, 3))
    prepare()
    crank_kernel(np.ascontiguousarray(angle.ravel()), _numbers(crank), rows)
    foot = rows[:, :2].reshape(*angle.shape, 2)
    slope = np.stack([foot[..., 1], -foot[..., 0]], axis=-1)
    return CrankPose(foot, slope, rows[:, 2].reshape(angle.shape))


def crank_outline(
    crank: CrankParameters, angle_rad: float | FloatArray, corners: int = 17
) -> FloatArray:
    """Return the half circle at shaft angles, (...,), as a polygon, from its end near the shaft to the toe.

    A leg without half circle has shaft and toe.

    Returns:
        x and z relative to the shaft, (..., K, 2) [m].
    """
    angle = np.asarray(angle_rad)[..., None]
    c, s = np.cos(angle), np.sin(angle)
    around = np.linspace(np.pi, 0.0, corners)
    x, z = -crank.radius * np.sin(around), crank.radius * (1 - np.cos(around)) - crank.length
    if crank.radius == 0:
        x, z = np.zeros(2), np.array([0.0, -crank.length])
    return np.stack([x * c + z * s, z * c - x * s], axis=-1)


class CrankKinematics(OneShaftKinematics):
    """All legs' cranks: shaft angles to feet in the body frame; joint k turns leg k.

    Args:
        crank: Dimensions, the same for all legs.
        shaft_position: Shafts in the body frame, (N, 3) [m].

    Raises:
        ConfigError: The leg cannot be like that.
    """

    def __init__(self, crank: CrankParameters, shaft_position: FloatArray) -> None:
        check_crank(crank)
        super().__init__(feet_kernel, prepare, _numbers(crank), shaft_position)


def _numbers(crank: CrankParameters) -> FloatArray:
    return np.array([crank.length, crank.radius])


@in_place
@compiled
def _foot(angle: float, numbers: FloatArray) -> tuple[float, float, float]:
    """Foot x and z [m], and how far the half circle has rolled [rad]."""
    length, radius = numbers[0], numbers[1]
    turns = np.ceil((angle - np.pi) / (2 * np.pi))
    turn = angle - 2 * np.pi * turns  # -pi < turn <= pi
    s, c = np.sin(turn), np.cos(turn)
    rolled = -np.pi * turns - min(turn, 0.0)
    if turn <= 0.0:
        return -(length - radius) * s, -(length - radius) * c - radius, rolled
    t = max(2 * turn / np.pi - 1, 0.0)
    reach = length - 2 * radius * t * t * (3 - 2 * t)
    # NaN comes here too, and goes through
    return -reach * s, -reach * c, rolled


@in_place
@compiled
def crank_kernel(angle: FloatArray, numbers: FloatArray, rows: FloatArray) -> None:
    """Feet at many angles.

    Args:
        angle: Shaft angles, (M,) [rad].
        numbers: Length and radius, (2,) [m].
        rows: Out: foot x and z [m], roll [rad], (M, 3).
    """
    for m in range(angle.size):
        rows[m, 0], rows[m, 1], rows[m, 2] = _foot(angle[m], numbers)


@in_place
@compiled
def feet_kernel(
    angle: FloatArray, rate: FloatArray, numbers: FloatArray, shaft: FloatArray,
    position: FloatArray, velocity: FloatArray,
) -> None:  # fmt: skip
    """Feet in the body frame.

    Args:
        angle: Shaft angles, frame after frame, (F N,) [rad].
        rate: Shaft speeds, (F N,) [rad/s].
        numbers: As for ``crank_kernel``.
        shaft: Shafts, (N, 3) [m].
        position: Out: (F N, 3) [m].
        velocity: Out: (F N, 3) [m/s].
    """
    for m in range(angle.size):
        k = m % shaft.shape[0]
        x, z, _ = _foot(angle[m], numbers)
        position[m, 0] = shaft[k, 0] + x
        position[m, 1] = shaft[k, 1]
        position[m, 2] = shaft[k, 2] + z
        velocity[m, 0] = z * rate[m]
        velocity[m, 1] = 0.0
        velocity[m, 2] = -x * rate[m]


def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    compile_for(crank_kernel, *given(1, 1), *out(2))
    compile_for(feet_kernel, *given(1, 1, 1, 2), *out(2, 2))
