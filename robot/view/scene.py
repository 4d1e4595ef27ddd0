"""What a viewer draws of one tick, as plain geometry in the body frame. Pure."""

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
    LegGeometry,
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
BODY_MARGIN_M = 0.03
BODY_HEIGHT_M = 0.04
SHAFT_SHARE = 0.7


@dataclass(frozen=True, slots=True, eq=False)
class Strip:
    """Points joined by lines, (K, 3) [m], body frame."""

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
    shafts = parameters.legs.shaft_position
    feet = leg_kinematics(parameters).feet(angles, np.zeros_like(angles)).position_m
    loaded = np.asarray(tick.contact.support.contact)
    legs = []
    for leg, name in enumerate(parameters.legs.names):
        if not np.isfinite(feet[leg]).all():
            legs.append(LegScene(name, (), (), ()))
            continue
        foot = feet[leg]
        links = _links(parameters.leg, leg, shafts[leg], angles)
        forces = (
            *_arrow(foot, tick.forces.force_n[leg], MEASURED),
            *_arrow(foot, tick.contact.traction.force_B[leg], PREDICTED),
        )
        legs.append(LegScene(name, links, (Dot(foot, LOADED if loaded[leg] else LIFTED),), forces))
    return tuple(legs)


def _links(
    geometry: LegGeometry, leg: int, shaft: FloatArray, angles_rad: FloatArray
) -> tuple[Strip, ...]:
    """What a leg consists of, at the angles of all joints, (J,)."""
    if isinstance(geometry, ChainParameters):
        kinematics, joints = ChainKinematics(geometry), list(geometry.joints_of(leg))
        foot = kinematics.feet(angles_rad, np.zeros_like(angles_rad)).position_m[leg]
        return (Strip(np.stack([*kinematics.joint_places(angles_rad)[joints], foot]), LINK),)
    angle_rad = float(angles_rad[leg])
    match geometry:
        case FourBarParameters():
            pose = linkage_pose(geometry, np.array(angle_rad))
            crank_pin, rocker_pin = _placed(shaft, pose.crank_pin), _placed(shaft, pose.rocker_pin)
            pivot, foot = _placed(shaft, geometry.ground_pivot), _placed(shaft, pose.foot)
            return (
                Strip(np.stack([shaft, crank_pin]), LINK),
                Strip(np.stack([pivot, rocker_pin]), LINK),
                Strip(np.stack([crank_pin, rocker_pin, foot, crank_pin]), COUPLER),
            )
        case CrankParameters():
            sole = [_placed(shaft, point) for point in crank_outline(geometry, angle_rad)]
            return Strip(np.stack([shaft, sole[0]]), LINK), Strip(np.stack(sole), COUPLER)


def _placed(shaft: FloatArray, plane: FloatArray) -> FloatArray:
    """(x, z) in the leg's plane to the body frame."""
    place: FloatArray = shaft + np.array([plane[0], 0.0, plane[1]])
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
