"""The robot file's parameters as URDF and as MJCF, by element trees.

Axes as everywhere: x forward, y left, z up. A positive turn about +y takes x towards -z: so a crank joint
about +y whose frame is turned by minus the mid-stance direction has the shaft angle as its value.
"""

import math
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from model.parameters.robot import RobotParameters
from sim_hw.plant.four_bar import four_bar_point, leg_geometry
from sim_hw.plant.parameters import PlantParameters

# Masses of the moving links; assumed, as in the plant. The torso has the rest.
LINK_MASS = 0.03
LINK_INERTIA = 1e-5
LINK_RADIUS = 0.005
TORSO_HALF_HEIGHT = 0.03
POSITION_GAIN = 55.0  # N m/rad: the MX-106's own gain at 12 V
SERVO_DAMPING = 2.1  # N m s/rad: its back-EMF


def coupler_angles(robot: RobotParameters, shaft_rad: float) -> tuple[float, float]:
    """Return crank and coupler directions at a shaft angle, from +x towards +z [rad]."""
    geometry = leg_geometry(PlantParameters.nominal(robot))[0]
    return robot.linkage.mid_stance - shaft_rad, four_bar_point(geometry, shaft_rad)[4]


def urdf_text(name: str, robot: RobotParameters) -> str:
    """Return the robot as URDF."""
    top = Element("robot", name=name)
    # MuJoCo melts a root without joint into the world unless told otherwise
    mujoco = SubElement(top, "mujoco")
    SubElement(mujoco, "compiler", fusestatic="false", balanceinertia="true")
    legs, link = robot.legs, robot.linkage
    moving = 3 * LINK_MASS * legs.count
    base = _link(top, "base_link", robot.body.mass - moving, robot.body.inertia)
    _box(base, robot)
    for leg, place in zip(legs.names, legs.shaft_position, strict=True):
        crank = _link(top, f"{leg}_crank", LINK_MASS)
        _bar(crank, link.crank)
        coupler = _link(top, f"{leg}_coupler", LINK_MASS)
        _bar(coupler, link.coupler)
        _link(top, f"{leg}_foot", LINK_MASS)
        turn = [0.0, -link.mid_stance, 0.0]
        _joint(top, f"{leg}_shaft", "continuous", "base_link", f"{leg}_crank", place, turn, "0 1 0")
        pin = [link.crank, 0.0, 0.0]
        _joint(
            top,
            f"{leg}_coupler",
            "continuous",
            f"{leg}_crank",
            f"{leg}_coupler",
            pin,
            [0.0] * 3,
            "0 -1 0",
        )
        foot = [float(link.foot[0]), 0.0, float(link.foot[1])]
        _joint(top, f"{leg}_foot", "fixed", f"{leg}_coupler", f"{leg}_foot", foot, [0.0] * 3, "")
    indent(top)
    return '<?xml version="1.0"?>\n' + tostring(top, encoding="unicode") + "\n"


def _link(top: Element, name: str, mass: float, inertia: np.ndarray | None = None) -> Element:
    link = SubElement(top, "link", name=name)
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "mass", value=f"{mass:g}")
    xx, yy, zz = inertia if inertia is not None else [LINK_INERTIA] * 3
    SubElement(
        inertial, "inertia", ixx=f"{xx:g}", ixy="0", ixz="0", iyy=f"{yy:g}", iyz="0", izz=f"{zz:g}"
    )
    return link


def _box(link: Element, robot: RobotParameters) -> None:
    half = np.abs(robot.legs.shaft_position[:, :2]).max(axis=0)
    visual = SubElement(link, "visual")
    geometry = SubElement(visual, "geometry")
    SubElement(geometry, "box", size=_words([2 * half[0], 1.6 * half[1], 2 * TORSO_HALF_HEIGHT]))


def _bar(link: Element, length: float) -> None:
    visual = SubElement(link, "visual")
    SubElement(visual, "origin", xyz=_words([length / 2, 0, 0]), rpy=_words([0, math.pi / 2, 0]))
    geometry = SubElement(visual, "geometry")
    SubElement(geometry, "cylinder", radius=f"{LINK_RADIUS:g}", length=f"{length:g}")


def _joint(
    top: Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    place: object,
    turn: object,
    axis: str,
) -> None:
    joint = SubElement(top, "joint", name=f"{name}_joint", type=kind)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    SubElement(joint, "origin", xyz=_words(place), rpy=_words(turn))
    if axis:
        SubElement(joint, "axis", xyz=axis)


def mjcf_text(name: str, robot: RobotParameters) -> str:
    """Return the robot as a MuJoCo model: closed four-bars, position actuators, ground."""
    top = Element("mujoco", model=name)
    SubElement(
        top, "option", timestep="0.0005", integrator="implicitfast", cone="elliptic", impratio="20"
    )
    world = SubElement(top, "worldbody")
    SubElement(world, "geom", name="ground", type="plane", size="0 0 1", friction="1e-6 0 0")
    torso = SubElement(world, "body", name="torso", pos="0 0 0.14")
    SubElement(torso, "freejoint", name="free")
    legs = robot.legs
    half = np.abs(legs.shaft_position[:, :2]).max(axis=0)
    mass = robot.body.mass - 3 * LINK_MASS * legs.count
    SubElement(
        torso, "inertial", pos="0 0 0", mass=f"{mass:g}", diaginertia=_words(robot.body.inertia)
    )
    SubElement(
        torso, "geom", type="box", size=_words([half[0], 0.8 * half[1], TORSO_HALF_HEIGHT]), mass="0",
        contype="0", conaffinity="1",
    )  # fmt: skip
    equality, actuator = SubElement(top, "equality"), SubElement(top, "actuator")
    for at, leg in enumerate(legs.names):
        _mjcf_leg(torso, robot, at, leg)
        anchor = _words([robot.linkage.coupler, 0, 0])
        SubElement(
            equality, "connect", name=f"{leg}_loop", body1=f"{leg}_coupler", body2=f"{leg}_rocker",
            anchor=anchor, solref="0.002 1",
        )  # fmt: skip
        SubElement(
            actuator, "position", name=f"{leg}_shaft", joint=f"{leg}_shaft", kp=f"{POSITION_GAIN:g}"
        )
    indent(top)
    return tostring(top, encoding="unicode") + "\n"


def _mjcf_leg(torso: Element, robot: RobotParameters, at: int, leg: str) -> None:
    """Bodies stand as they do at shaft angle 0; every joint counts from there, the shaft's its angle."""
    link, place = robot.linkage, robot.legs.shaft_position[at]
    crank_angle, coupler_angle = coupler_angles(robot, 0.0)
    pin = np.array([link.crank * math.cos(crank_angle), link.crank * math.sin(crank_angle)])
    end = pin + link.coupler * np.array([math.cos(coupler_angle), math.sin(coupler_angle)])
    rocker_angle = math.atan2(*(end - link.ground_pivot)[::-1])
    crank = _mjcf_body(torso, f"{leg}_crank", place, crank_angle)
    SubElement(
        crank,
        "joint",
        name=f"{leg}_shaft",
        axis="0 1 0",
        armature="0.0246",
        damping=f"{SERVO_DAMPING:g}",
    )
    _capsule(crank, link.crank)
    coupler = _mjcf_body(crank, f"{leg}_coupler", [link.crank, 0, 0], coupler_angle - crank_angle)
    SubElement(coupler, "joint", name=f"{leg}_coupler", axis="0 1 0", damping="0.001")
    _capsule(coupler, link.coupler)
    foot = [link.foot[0], 0, link.foot[1]]
    SubElement(coupler, "site", name=f"{leg}_foot", pos=_words(foot))
    SubElement(
        coupler, "geom", name=f"{leg}_foot", type="sphere", size="0.005", pos=_words(foot), mass="0",
        friction=f"{robot.contact.mu[at]:g} 0 0", contype="0", conaffinity="1",
    )  # fmt: skip
    pivot = [place[0] + link.ground_pivot[0], place[1], place[2] + link.ground_pivot[1]]
    rocker = _mjcf_body(torso, f"{leg}_rocker", pivot, rocker_angle)
    SubElement(rocker, "joint", name=f"{leg}_rocker", axis="0 1 0", damping="0.001")
    _capsule(rocker, link.rocker)


def _mjcf_body(parent: Element, name: str, place: object, angle: float) -> Element:
    quat = _words([math.cos(angle / 2), 0, -math.sin(angle / 2), 0])
    body = SubElement(parent, "body", name=name, pos=_words(place), quat=quat)
    diagonal = _words([LINK_INERTIA] * 3)
    SubElement(body, "inertial", pos="0 0 0", mass=f"{LINK_MASS:g}", diaginertia=diagonal)
    return body


def _capsule(body: Element, length: float) -> None:
    SubElement(
        body, "geom", type="capsule", fromto=_words([0, 0, 0, length, 0, 0]), size=f"{LINK_RADIUS:g}",
        contype="0", conaffinity="0", mass="0",
    )  # fmt: skip


def _words(numbers: object) -> str:
    return " ".join(f"{float(value):.9g}" for value in np.asarray(numbers, dtype=float))
