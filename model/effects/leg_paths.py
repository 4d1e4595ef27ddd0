"""Where each kind of leg puts its foot, with what effects change in its links."""

from dataclasses import dataclass, replace

import numpy as np

from model.effects.settings import Settings
from model.kinematics.crank import crank_pose
from model.kinematics.four_bar import LinkagePose, linkage_pose
from model.values.arrays import FloatArray
from model.values.parameters import CrankParameters, FourBarParameters


@dataclass(frozen=True, slots=True, eq=False)
class FootPaths:
    """Feet in their legs' x-z planes, of W frames and N legs.

    Attributes:
        foot_m: Relative to the shaft, (W, N, 2).
        slope_m_rad: Motion of the leg's matter at the foot with the shaft, (W, N, 2).
        turn_rad: Angle of the foot's link from its angle at shaft angle 0, from +x to +z, (W, N); (1, 1)
            where nothing asks for it.
        rolled_m: How far a round leg has rolled: what its matter has gone along x beyond the place of
            contact, (W, N); (1, 1) of a leg that is not round.
    """

    foot_m: FloatArray
    slope_m_rad: FloatArray
    turn_rad: FloatArray
    rolled_m: FloatArray


def foot_paths(
    leg: FourBarParameters | CrankParameters, angle_rad: FloatArray, settings: Settings
) -> FootPaths:
    """Return where shaft angles, (W, N), put the feet."""
    turns = settings.has("foot_rolling")
    turn = rolled = np.zeros((1, 1))
    match leg:
        case FourBarParameters():
            links = _linkages(leg, angle_rad, settings)
            if turns:
                turn = _coupler_turn(leg, links)
            return FootPaths(links.foot, links.foot_slope, turn, rolled)
        case CrankParameters():
            pose = crank_pose(leg, angle_rad)
            if turns:
                turn = -angle_rad
            if leg.radius > 0:
                rolled = leg.radius * pose.roll
            return FootPaths(pose.foot, pose.foot_slope, turn, rolled)


def _linkages(nominal: FourBarParameters, crank: FloatArray, settings: Settings) -> LinkagePose:
    """All linkages; those with other links are solved on their own."""
    changes = [tuple(change) for change in settings.each("link_length").T.tolist()]
    pose = linkage_pose(nominal, crank)
    for change in dict.fromkeys(c for c in changes if any(c)):
        legs = [leg for leg, own_change in enumerate(changes) if own_change == change]
        crank_m, coupler_m, rocker_m = change
        links = replace(
            nominal,
            crank=nominal.crank + crank_m,
            coupler=nominal.coupler + coupler_m,
            rocker=nominal.rocker + rocker_m,
        )
        other = linkage_pose(links, crank[:, legs])
        for name in LinkagePose.__slots__:
            getattr(pose, name)[:, legs] = getattr(other, name)
    return pose


def _coupler_turn(nominal: FourBarParameters, pose: LinkagePose) -> FloatArray:
    middle = linkage_pose(nominal, np.zeros(1))
    along = pose.rocker_pin - pose.crank_pin
    at_zero = (middle.rocker_pin - middle.crank_pin)[0]
    cross = at_zero[0] * along[..., 1] - at_zero[1] * along[..., 0]
    turn: FloatArray = np.arctan2(cross, along @ at_zero)
    return turn
