"""Legs of any kind: one protocol from joint angles to feet, and one place that makes it.

N legs have J joints. A four-bar and a crank have one joint each, so J = N there and joint k belongs to
leg k; whoever calls must not count on it.
"""

from typing import Protocol

import numpy as np

from model.kinematics.chain import ChainKinematics, chain_reach_m
from model.kinematics.crank import CrankKinematics
from model.kinematics.four_bar import FourBarKinematics
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import (
    ChainParameters,
    CrankParameters,
    FourBarParameters,
    LegGeometry,
    LegParameters,
)


class LeggedRobot(Protocol):
    """Whatever has legs: where they are fixed to the body, and what one of them is."""

    @property
    def legs(self) -> LegParameters:
        """Names and places."""

    @property
    def leg(self) -> LegGeometry:
        """Geometry, with the kind of leg in its type."""


class LegKinematics(Protocol):
    """Joint angles to unloaded feet in the body frame, and the exact derivative."""

    @property
    def joint_count(self) -> int:
        """Number of joints J of all legs together."""

    def feet(self, angle_rad: FloatArray, rate_rad_s: FloatArray) -> FootMotion:
        """Return feet in the body frame.

        Args:
            angle_rad: Joint angles, (..., J) [rad]; NaN gives NaN in the legs that it moves.
            rate_rad_s: Joint speeds, (..., J) [rad/s].

        Returns:
            Positions and velocities, (..., N, 3). A velocity is that of the leg's matter at the foot, which
            for a foot that rolls is not that of the place of contact.
        """

    def jacobian(self, angle_rad: FloatArray) -> FloatArray:
        """Return d foot velocity / d joint speed, (..., N, 3, J) [m/rad], from angles (..., J) [rad]."""

    def prepare(self) -> None:
        """Load or make the machine code of ``feet`` now, so that no tick has to wait for it."""


def reach_m(leg: LegGeometry) -> float:
    """Return a distance from its shaft beyond which no foot of a leg comes [m]."""
    match leg:
        case FourBarParameters():
            return leg.crank + float(np.hypot(*leg.foot))
        case CrankParameters():
            return leg.length
        case ChainParameters():
            return chain_reach_m(leg)


def leg_kinematics(robot: LeggedRobot) -> LegKinematics:
    """Return the kinematics of a robot's legs, whatever their kind.

    Raises:
        ConfigError: The legs cannot move as they are.
    """
    leg, shaft_position = robot.leg, robot.legs.shaft_position
    match leg:
        case FourBarParameters():
            return FourBarKinematics(leg, shaft_position)
        case CrankParameters():
            return CrankKinematics(leg, shaft_position)
        case ChainParameters():
            return ChainKinematics(leg)
