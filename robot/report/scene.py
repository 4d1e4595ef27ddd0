"""What a viewer draws of a robot, as plain geometry in the body frame: of one tick, or of many. Pure."""

from dataclasses import dataclass

import numpy as np

from model.kinematics.chain import ChainKinematics
from model.kinematics.crank import crank_outline
from model.kinematics.four_bar import linkage_pose
from model.kinematics.legs import leg_kinematics
from model.values.arrays import FloatArray
from model.values.parameters import (
    ChainParameters,
    CrankParameters,
    FourBarParameters,
    RobotParameters,
)
from model.values.tick import Tick

Colour = tuple[float, float, float]
# Okabe and Ito: distinct for the colour-blind; the same as in the pictures of ``bigant show``.
MEASURED: Colour = (0.0, 0.447, 0.698)
PREDICTED: Colour = (0.835, 0.369, 0.0)
ESTIMATED: Colour = (0.0, 0.62, 0.45)
LINK: Colour = (0.25, 0.25, 0.25)
COUPLER: Colour = (0.45, 0.45, 0.45)
LOADED: Colour = (0.80, 0.475, 0.655)
LIFTED: Colour = (0.6, 0.6, 0.6)
# 20 N, a third of BigANT's weight, is drawn as long as a leg.
METRES_PER_NEWTON = 0.006
LEAST_FORCE_N = 0.2
# Between these slip speeds a foot's path on the ground turns from grey to red.
SHOWN_SLIP_M_S, FULL_SLIP_M_S = 0.002, 0.02
BODY_MARGIN_M = 0.03
BODY_HEIGHT_M = 0.04
SHAFT_SHARE = 0.7


@dataclass(frozen=True, slots=True, eq=False)
class Strip:
    """Points joined by lines, (..., K, 3) [m], body frame."""

    points: FloatArray
    colour: Colour


@dataclass(frozen=True, slots=True, eq=False)
class Arrow:
    """An arrow from ``start`` along ``vector``, (3,) each [m], body frame."""

    start: FloatArray
    vector: FloatArray
    colour: Colour


@dataclass(frozen=True, slots=True, eq=False)
class Dot:
    """A small sphere at ``place``, (3,) [m], body frame."""

    place: FloatArray
    colour: Colour


@dataclass(frozen=True, slots=True, eq=False)
class LegScene:
    """One leg: its linkage, its foot and the forces on it. Empty where the shaft is not known."""

    name: str
    links: tuple[Strip, ...]
    feet: tuple[Dot, ...]
    forces: tuple[Arrow, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """The body as a box: its middle and its size, (3,) each [m], body frame."""

    centre: FloatArray
    size: FloatArray


def body_of(parameters: RobotParameters) -> Body:
    """Return a box about as large as the body; the robot file does not say its size."""
    shafts = parameters.legs.shaft_position
    low, high = shafts.min(axis=0), shafts.max(axis=0)
    size = high - low
    size[1] *= SHAFT_SHARE
    size += 2 * BODY_MARGIN_M
    size[2] = BODY_HEIGHT_M
    return Body((low + high) / 2, size)


def legs_of(tick: Tick, parameters: RobotParameters) -> tuple[LegScene, ...]:
    """Return all legs of a tick.

    Args:
        tick: The tick.
        parameters: Dimensions, from the log's own robot file.
    """
    angles = tick.joints.angle_rad
    feet = leg_kinematics(parameters).feet(angles, np.zeros_like(angles)).position_m
    loaded = np.asarray(tick.contact.support.contact)
    legs = []
    for leg, name in enumerate(parameters.legs.names):
        if not np.isfinite(feet[leg]).all():
            legs.append(LegScene(name, (), (), ()))
            continue
        foot = feet[leg]
        links = leg_links(parameters, leg, angles)
        forces = (
            *_arrow(foot, tick.forces.force_n[leg], MEASURED),
            *_arrow(foot, tick.contact.traction.force_B[leg], PREDICTED),
        )
        legs.append(LegScene(name, links, (Dot(foot, LOADED if loaded[leg] else LIFTED),), forces))
    return tuple(legs)


def leg_links(parameters: RobotParameters, leg: int, angles_rad: FloatArray) -> tuple[Strip, ...]:
    """Return what a leg consists of, at the angles of all joints, (..., J)."""
    geometry, shaft = parameters.leg, parameters.legs.shaft_position[leg]
    if isinstance(geometry, ChainParameters):
        kinematics, joints = ChainKinematics(geometry), list(geometry.joints_of(leg))
        feet = kinematics.feet(angles_rad, np.zeros_like(angles_rad)).position_m
        foot = feet[..., leg : leg + 1, :]
        places = kinematics.joint_places(angles_rad)[..., joints, :]
        return (Strip(np.concatenate([places, foot], axis=-2), LINK),)
    angle_rad = angles_rad[..., leg]
    match geometry:
        case FourBarParameters():
            pose = linkage_pose(geometry, angle_rad)
            crank_pin, rocker_pin = _placed(shaft, pose.crank_pin), _placed(shaft, pose.rocker_pin)
            pivot, foot = _placed(shaft, geometry.ground_pivot), _placed(shaft, pose.foot)
            return (
                _strip(LINK, shaft, crank_pin),
                _strip(LINK, pivot, rocker_pin),
                _strip(COUPLER, crank_pin, rocker_pin, foot, crank_pin),
            )
        case CrankParameters():
            sole = _placed(shaft, crank_outline(geometry, angle_rad))
            return _strip(LINK, shaft, sole[..., 0, :]), Strip(sole, COUPLER)


def _strip(colour: Colour, *points: FloatArray) -> Strip:
    """Joined points, some of which may be fixed in the body, (3,), and others (..., 3)."""
    return Strip(np.stack(np.broadcast_arrays(*points), axis=-2), colour)


def _placed(shaft: FloatArray, plane: FloatArray | tuple[float, float]) -> FloatArray:
    """(x, z) in the leg's plane, (..., 2), to the body frame."""
    in_plane = np.asarray(plane)
    aside = np.zeros(in_plane.shape[:-1])
    place: FloatArray = shaft + np.stack([in_plane[..., 0], aside, in_plane[..., 1]], axis=-1)
    return place


def _arrow(foot: FloatArray, force_n: FloatArray, colour: Colour) -> tuple[Arrow, ...]:
    if not np.isfinite(force_n).all() or np.linalg.norm(force_n) < LEAST_FORCE_N:
        return ()
    return (Arrow(foot, METRES_PER_NEWTON * force_n, colour),)


def turn_from_x(vector: FloatArray) -> FloatArray:
    """Return the rotation that takes +x into the direction of a vector, (4,) x y z w."""
    along = vector / np.linalg.norm(vector)
    if along[0] < -1 + 1e-9:  # half a turn: about any axis across
        return np.array([0.0, 0.0, 1.0, 0.0])
    quaternion = np.array([0.0, -along[2], along[1], 1 + along[0]])
    unit: FloatArray = quaternion / np.linalg.norm(quaternion)
    return unit
