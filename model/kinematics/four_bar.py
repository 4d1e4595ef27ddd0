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
from model.kinematics.four_bar_kernel import feet_kernel, prepare
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
        transmission_sine: Sine of the angle between coupler and rocker, (...); 0 is a dead centre.
    """

    crank_pin: FloatArray
    rocker_pin: FloatArray
    foot: FloatArray
    foot_slope: FloatArray
    transmission_sine: FloatArray


def linkage_pose(linkage: LinkageParameters, angle_rad: FloatArray) -> LinkagePose:
    """Solve the linkage.

    Args:
        linkage: Dimensions; must be able to turn (``check_linkage``).
        angle_rad: Shaft angles, any shape [rad].
    """
    phi = linkage.mid_stance - np.asarray(angle_rad, dtype=np.float64)
    direction = _direction(phi)
    crank_pin = linkage.crank * direction
    to_pivot = linkage.ground_pivot - crank_pin
    distance = np.linalg.norm(to_pivot, axis=-1)  # [m]
    along = (linkage.coupler**2 - linkage.rocker**2 + distance**2) / (2 * distance)
    # beyond a dead centre there is no pose; check_linkage has excluded that, rounding has not
    across = linkage.branch * np.sqrt(np.maximum(linkage.coupler**2 - along**2, 0.0))
    e = to_pivot / distance[..., None]
    rocker_pin = crank_pin + along[..., None] * e + across[..., None] * _left(e)
    u = (rocker_pin - crank_pin) / linkage.coupler
    v = (rocker_pin - linkage.ground_pivot) / linkage.rocker
    foot = crank_pin + linkage.foot[0] * u + linkage.foot[1] * _left(u)
    # closure differentiated by phi, times v:  (dA + coupler du) . v = 0,  du = left(u) dpsi
    crank_pin_slope = linkage.crank * _left(direction)
    sine = np.sum(_left(u) * v, axis=-1)
    coupler_turn = -np.sum(crank_pin_slope * v, axis=-1) / (linkage.coupler * sine)
    foot_by_phi = crank_pin_slope + coupler_turn[..., None] * _left(foot - crank_pin)
    return LinkagePose(
        crank_pin=crank_pin,
        rocker_pin=rocker_pin,
        foot=foot,
        foot_slope=-foot_by_phi,
        transmission_sine=sine,
    )


def _direction(angle: FloatArray) -> FloatArray:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _left(vector: FloatArray) -> FloatArray:
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


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
        self.parameters = linkage
        self._shaft_position = shaft_position
        self._numbers = np.array([
            linkage.crank, *linkage.ground_pivot, linkage.coupler, linkage.rocker, *linkage.foot,
            linkage.branch, linkage.mid_stance,
        ])  # fmt: skip

    def feet(self, angle_rad: FloatArray, rate_rad_s: FloatArray) -> FootMotion:
        """Return unloaded feet in the body frame.

        Args:
            angle_rad: Shaft angles, (..., N) [rad]; NaN gives NaN.
            rate_rad_s: Shaft speeds, (..., N) [rad/s].

        Returns:
            Positions and velocities, (..., N, 3).
        """
        pose = linkage_pose(self.parameters, angle_rad)
        position = self._shaft_position + _in_body(pose.foot)
        velocity = _in_body(pose.foot_slope * np.asarray(rate_rad_s)[..., None])
        return FootMotion(position, velocity)

    def prepare(self) -> None:
        """Load or make the machine code of ``frame_feet`` now, so that no tick has to wait for it."""
        prepare()

    def frame_feet(self, angle_rad: FloatArray, rate_rad_s: FloatArray) -> FootMotion:
        """As ``feet``, for one frame and an order of magnitude faster.

        Args:
            angle_rad: (N,) [rad]; NaN gives NaN.
            rate_rad_s: (N,) [rad/s].

        Returns:
            Positions and velocities, (N, 3).
        """
        position, velocity = np.empty((len(angle_rad), 3)), np.empty((len(angle_rad), 3))
        angle, rate = np.ascontiguousarray(angle_rad), np.ascontiguousarray(rate_rad_s)
        feet_kernel(angle, rate, self._numbers, self._shaft_position, position, velocity)
        return FootMotion(position, velocity)


def _in_body(plane: FloatArray) -> FloatArray:
    """(x, z) of the leg's plane to (x, y, z) of the body: legs move fore and aft, never sideways."""
    x, z = plane[..., 0], plane[..., 1]
    return np.stack([x, np.zeros_like(x), z], axis=-1)
