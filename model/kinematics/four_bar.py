"""The four-bar linkage of a leg: shaft angle to foot position, and its exact first derivative.

In the leg's x-z plane, angles from +x towards +z, "left" of a direction is +90 degrees from it::

    A = crank (cos phi, sin phi),  phi = mid_stance - shaft angle     crank pin
    P = ground pivot                                                  rocker pivot
    B = the point with |B - A| = coupler, |B - P| = rocker, on the side ``branch`` of A -> P
    foot = A + u foot[0] + left(u) foot[1],  u = (B - A) / coupler

The derivative follows from the loop closure A + coupler u - rocker v = P by implicit differentiation
(any text on mechanisms, for example Norton, "Design of Machinery", chapter 6).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from model.compiled import compile_for, compiled, given, in_place, out
from model.errors import ConfigError
from model.kinematics.one_shaft import OneShaftKinematics
from model.values.arrays import FloatArray
from model.values.parameters import FourBarParameters

# Pins must keep this share of the rocker and coupler lengths away from a dead centre.
DEAD_CENTRE_MARGIN = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class LinkagePose:
    """The linkage at some shaft angles; every array has the shape of the angles, and 2 for (x, z).

    Attributes:
        crank_pin: A, (..., 2) [m].
        rocker_pin: B, (..., 2) [m].
        foot: (..., 2) [m], relative to the crank shaft.
        foot_slope: d foot / d shaft angle, (..., 2) [m/rad].
    """

    crank_pin: FloatArray
    rocker_pin: FloatArray
    foot: FloatArray
    foot_slope: FloatArray


def linkage_pose(linkage: FourBarParameters, angle_rad: FloatArray) -> LinkagePose:
    """Solve the linkage.

    Args:
        linkage: Dimensions; must be able to turn (``check_linkage``).
        angle_rad: Shaft angles, any shape [rad].
    """
    angle = np.asarray(angle_rad, dtype=np.float64)
    out = np.empty((angle.size, 8))
    prepare()
    poses_kernel(np.ascontiguousarray(angle.ravel()), _numbers(linkage), out)
    return LinkagePose(*(out[:, i : i + 2].reshape(*angle.shape, 2) for i in (0, 2, 4, 6)))


def _numbers(linkage: FourBarParameters) -> FloatArray:
    return np.array([
        linkage.crank, *linkage.ground_pivot, linkage.coupler, linkage.rocker, *linkage.foot,
        linkage.branch, linkage.mid_stance,
    ])  # fmt: skip


def check_linkage(
    linkage: FourBarParameters, named: Callable[[str], str] = "leg.{}".format
) -> None:
    """Refuse a linkage whose crank cannot make a full turn on one branch.

    The distance from crank pin to rocker pivot sweeps all of ``ground +- crank``; at every one of
    them coupler and rocker must still form a triangle with it, with something to spare.

    Args:
        linkage: Dimensions.
        named: Name of a key as its file has it, for the message.

    Raises:
        ConfigError: It cannot be assembled or passes a dead centre; names the key and the figures.
    """
    ground = float(np.hypot(*linkage.ground_pivot))
    nearest, farthest = abs(ground - linkage.crank), ground + linkage.crank
    longest = linkage.coupler + linkage.rocker
    shortest = abs(linkage.coupler - linkage.rocker)
    margin = DEAD_CENTRE_MARGIN * min(linkage.coupler, linkage.rocker)
    if farthest > longest - margin:
        raise ConfigError(
            named("crank"),
            f"the linkage cannot turn: crank pin and rocker pivot come {farthest * 1e3:.1f} mm "
            f"apart, coupler and rocker reach {longest * 1e3:.1f} mm",
        )
    if nearest < shortest + margin:
        raise ConfigError(
            named("rocker"),
            f"the linkage cannot turn: crank pin and rocker pivot come within "
            f"{nearest * 1e3:.1f} mm, coupler and rocker fold to no less than "
            f"{shortest * 1e3:.1f} mm",
        )


class FourBarKinematics(OneShaftKinematics):
    """All legs' linkages: shaft angles to feet in the body frame; joint k turns leg k.

    Args:
        linkage: Dimensions, the same for all legs.
        shaft_position: Crank shafts in the body frame, (N, 3) [m].

    Raises:
        ConfigError: The linkage cannot turn.
    """

    def __init__(self, linkage: FourBarParameters, shaft_position: FloatArray) -> None:
        check_linkage(linkage)
        super().__init__(feet_kernel, prepare, _numbers(linkage), shaft_position)


@in_place
@compiled
def _pose(
    angle: float, numbers: FloatArray
) -> tuple[float, float, float, float, float, float, float, float]:
    """Crank pin, rocker pin, foot and d foot / d shaft angle, x and z each [m], [m/rad]."""
    crank, pivot_x, pivot_z, coupler, rocker = (
        numbers[0], numbers[1], numbers[2], numbers[3], numbers[4],
    )  # fmt: skip
    along_foot, across_foot, branch = numbers[5], numbers[6], numbers[7]
    phi = numbers[8] - angle
    c, s = np.cos(phi), np.sin(phi)
    ax, az = crank * c, crank * s
    ex, ez = pivot_x - ax, pivot_z - az
    distance = np.sqrt(ex * ex + ez * ez)
    along = (coupler**2 - rocker**2 + distance**2) / (2.0 * distance)
    # beyond a dead centre there is no pose; check_linkage has excluded that, rounding has not
    across = branch * np.sqrt(max(coupler**2 - along**2, 0.0))
    ex, ez = ex / distance, ez / distance
    bx, bz = ax + along * ex - across * ez, az + along * ez + across * ex
    ux, uz = (bx - ax) / coupler, (bz - az) / coupler
    vx, vz = (bx - pivot_x) / rocker, (bz - pivot_z) / rocker
    fx = ax + along_foot * ux - across_foot * uz
    fz = az + along_foot * uz + across_foot * ux
    # closure differentiated by phi, times v:  (dA + coupler du) . v = 0,  du = left(u) dpsi
    sine = ux * vz - uz * vx
    turn = -(-crank * s * vx + crank * c * vz) / (coupler * sine)
    return ax, az, bx, bz, fx, fz, crank * s + turn * (fz - az), -crank * c - turn * (fx - ax)


@in_place
@compiled
def poses_kernel(angle: FloatArray, numbers: FloatArray, out: FloatArray) -> None:
    """Poses at many angles.

    Args:
        angle: Shaft angles, (M,) [rad].
        numbers: crank, ground pivot x and z, coupler, rocker, foot along and across [m], branch,
            mid-stance [rad], (9,).
        out: Out: as ``_pose`` has them, (M, 8).
    """
    for m in range(angle.size):
        (
            out[m, 0], out[m, 1], out[m, 2], out[m, 3],
            out[m, 4], out[m, 5], out[m, 6], out[m, 7],
        ) = _pose(angle[m], numbers)  # fmt: skip


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
        numbers: As for ``poses_kernel``.
        shaft: Crank shafts, (N, 3) [m].
        position: Out: (F N, 3) [m].
        velocity: Out: (F N, 3) [m/s].
    """
    for m in range(angle.size):
        k = m % shaft.shape[0]
        _, _, _, _, x, z, x_slope, z_slope = _pose(angle[m], numbers)
        position[m, 0] = shaft[k, 0] + x
        position[m, 1] = shaft[k, 1]
        position[m, 2] = shaft[k, 2] + z
        velocity[m, 0] = x_slope * rate[m]
        velocity[m, 1] = 0.0
        velocity[m, 2] = z_slope * rate[m]


def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    compile_for(poses_kernel, *given(1, 1), *out(2))
    compile_for(feet_kernel, *given(1, 1, 1, 2), *out(2, 2))
