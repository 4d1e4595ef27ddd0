"""The four-bar linkage of a leg: shaft angle to foot position, and its exact first derivative.

In the leg's x-z plane, angles from +x towards +z, "left" of a direction is +90 degrees from it::

    A = crank (cos phi, sin phi),  phi = mid_stance - shaft angle     crank pin
    P = ground pivot                                                  rocker pivot
    B = the point with |B - A| = coupler, |B - P| = rocker, on the side ``branch`` of A -> P
    foot = A + u foot[0] + left(u) foot[1],  u = (B - A) / coupler

The derivative follows from the loop closure A + coupler u - rocker v = P by implicit differentiation
(any text on mechanisms, for example Norton, "Design of Machinery", chapter 6).
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ConfigError
from model.kinematics.four_bar_kernel import feet_kernel, poses_kernel, prepare
from model.parameters.robot import LinkageParameters
from model.values.arrays import FloatArray
from model.values.legs import FootMotion

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


def linkage_pose(linkage: LinkageParameters, angle_rad: FloatArray) -> LinkagePose:
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


def _numbers(linkage: LinkageParameters) -> FloatArray:
    return np.array([
        linkage.crank, *linkage.ground_pivot, linkage.coupler, linkage.rocker, *linkage.foot,
        linkage.branch, linkage.mid_stance,
    ])  # fmt: skip


def check_linkage(linkage: LinkageParameters) -> None:
    """Refuse a linkage whose crank cannot make a full turn on one branch.

    The distance from crank pin to rocker pivot sweeps all of ``ground +- crank``; at every one of
    them coupler and rocker must still form a triangle with it, with something to spare.

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
            "linkage.crank",
            f"the linkage cannot turn: crank pin and rocker pivot come {farthest * 1e3:.1f} mm "
            f"apart, coupler and rocker reach {longest * 1e3:.1f} mm",
        )
    if nearest < shortest + margin:
        raise ConfigError(
            "linkage.rocker",
            f"the linkage cannot turn: crank pin and rocker pivot come within "
            f"{nearest * 1e3:.1f} mm, coupler and rocker fold to no less than "
            f"{shortest * 1e3:.1f} mm",
        )


class Linkage:
    """All legs' linkages: shaft angles to feet in the body frame.

    Args:
        linkage: Dimensions, the same for all legs.
        shaft_position: Crank shafts in the body frame, (N, 3) [m].

    Raises:
        ConfigError: The linkage cannot turn.
    """

    def __init__(self, linkage: LinkageParameters, shaft_position: FloatArray) -> None:
        check_linkage(linkage)
        self._numbers, self._shaft_position = (
            _numbers(linkage),
            np.ascontiguousarray(shaft_position),
        )

    def feet(self, angle_rad: FloatArray, rate_rad_s: FloatArray) -> FootMotion:
        """Return unloaded feet in the body frame.

        Args:
            angle_rad: Shaft angles, (..., N) [rad]; NaN gives NaN.
            rate_rad_s: Shaft speeds, (..., N) [rad/s].

        Returns:
            Positions and velocities, (..., N, 3).
        """
        angle = np.ascontiguousarray(angle_rad, dtype=np.float64)
        rate = np.ascontiguousarray(rate_rad_s, dtype=np.float64)
        position, velocity = np.empty((2, *angle.shape, 3))
        frames = angle.reshape(-1, angle.shape[-1]), rate.reshape(-1, angle.shape[-1])
        rows = (-1, angle.shape[-1], 3)
        feet_kernel(
            *frames,
            self._numbers,
            self._shaft_position,
            position.reshape(rows),
            velocity.reshape(rows),
        )
        return FootMotion(position, velocity)

    def prepare(self) -> None:
        """Load or make the machine code of ``feet`` now, so that no tick has to wait for it."""
        prepare()
