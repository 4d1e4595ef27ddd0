"""The robot file's parameters as URDF and as MJCF, by element trees.

Axes as everywhere: x forward, y left, z up. A positive turn about +y takes x towards -z: so a crank joint
about +y whose frame is turned by minus the mid-stance direction has the shaft angle as its value.
"""

import math
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from model.errors import ConfigError
from model.values.parameters import RobotParameters
from record.whole_file import write_text
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.requests.robot import RobotExportRequest
from sim_hw.plant.four_bar import four_bar_point, leg_geometry
from sim_hw.plant.parameters import PlantParameters

# Masses of the moving links; assumed, as in the plant. The torso has the rest.
LINK_MASS = 0.03
LINK_INERTIA = 1e-5
LINK_RADIUS = 0.005
TORSO_HALF_HEIGHT = 0.03
POSITION_GAIN = 55.0  # N m/rad: the MX-106's own gain at 12 V
SERVO_DAMPING = 2.1  # N m s/rad: its back-EMF


def export(request: RobotExportRequest) -> ExitCode:
    """Write a robot file as URDF, as MJCF or both, and check that MuJoCo loads them.

    Raises:
        ConfigError: Nothing is asked for.
        RecordError: A file cannot be written.
    """
    if request.urdf is None and request.mjcf is None:
        raise ConfigError("robot export", "nothing to write: give --urdf OUT, --mjcf OUT or both")
    config = load_robot(request.robot)
    wanted = (("--urdf", request.urdf, urdf_text), ("--mjcf", request.mjcf, mjcf_text))
    for option, path, make in wanted:
        if path is None:
            continue
        text = make(config.name, config.parameters)
        model = mujoco.MjModel.from_xml_string(text)
        write_text(path, text, option)
        mass = float(model.body_mass.sum())
        print(f"{path}: {model.njnt} joints, {mass:.3f} kg; MuJoCo loads it")
    return ExitCode.OK


def coupler_angles(robot: RobotParameters, shaft_rad: float) -> tuple[float, float]:
    """Return crank and coupler directions at a shaft angle, from +x towards +z [rad]."""
    geometry = leg_geometry(PlantParameters.nominal(robot))[0]
    return robot.leg.mid_stance - shaft_rad, four_bar_point(geometry, shaft_rad)[4]


def urdf_text(name: str, robot: RobotParameters) -> str:
    """Return the robot as URDF."""
    top = Element("robot", name=name)
    # MuJoCo merges a root without joint into the world by default
    _add(_add(top, "mujoco"), "compiler", fusestatic="false", balanceinertia="true")
    legs, link = robot.legs, robot.leg
    base = _link(top, "base_link", _torso_mass(robot), robot.body.inertia)
    half = _half_sizes(robot)
    box = _add(_add(base, "visual"), "geometry")
    _add(box, "box", size=[2 * half[0], 1.6 * half[1], 2 * TORSO_HALF_HEIGHT])
    for leg, place in zip(legs.names, legs.shaft_position, strict=True):
        crank, coupler, foot = f"{leg}_crank", f"{leg}_coupler", f"{leg}_foot"
        _bar(_link(top, crank, LINK_MASS), link.crank)
        _bar(_link(top, coupler, LINK_MASS), link.coupler)
        _link(top, foot, LINK_MASS)
        shaft = _joint(top, f"{leg}_shaft", "continuous", "base_link", crank)
        _add(shaft, "origin", xyz=place, rpy=[0, -link.mid_stance, 0])
        _add(shaft, "axis", xyz="0 1 0")
        pin = _joint(top, coupler, "continuous", crank, coupler)
        _add(pin, "origin", xyz=[link.crank, 0, 0])
        _add(pin, "axis", xyz="0 -1 0")
        end = _joint(top, foot, "fixed", coupler, foot)
        _add(end, "origin", xyz=[link.foot[0], 0, link.foot[1]])
    indent(top)
    return '<?xml version="1.0"?>\n' + tostring(top, encoding="unicode") + "\n"


def _torso_mass(robot: RobotParameters) -> float:
    return robot.body.mass - 3 * LINK_MASS * robot.legs.count


def _half_sizes(robot: RobotParameters) -> np.ndarray:
    half: np.ndarray = np.abs(robot.legs.shaft_position[:, :2]).max(axis=0)
    return half


def _link(
    top: Element, name: str, mass: float, inertia: ArrayLike = (LINK_INERTIA,) * 3
) -> Element:
    link = _add(top, "link", name=name)
    inertial = _add(link, "inertial")
    _add(inertial, "mass", value=mass)
    xx, yy, zz = np.asarray(inertia)
    _add(inertial, "inertia", ixx=xx, ixy=0, ixz=0, iyy=yy, iyz=0, izz=zz)
    return link


def _bar(link: Element, length: float) -> None:
    visual = _add(link, "visual")
    _add(visual, "origin", xyz=[length / 2, 0, 0], rpy=[0, math.pi / 2, 0])
    _add(_add(visual, "geometry"), "cylinder", radius=LINK_RADIUS, length=length)


def _joint(top: Element, name: str, kind: str, parent: str, child: str) -> Element:
    joint = _add(top, "joint", name=f"{name}_joint", type=kind)
    _add(joint, "parent", link=parent)
    _add(joint, "child", link=child)
    return joint


def mjcf_text(name: str, robot: RobotParameters) -> str:
    """Return the robot as a MuJoCo model: closed four-bars, position actuators, ground."""
    top = Element("mujoco", model=name)
    _add(top, "option", timestep=0.0005, integrator="implicitfast", cone="elliptic", impratio=20)
    world = _add(top, "worldbody")
    _add(world, "geom", name="ground", type="plane", size="0 0 1", friction="1e-6 0 0")
    torso = _add(world, "body", name="torso", pos="0 0 0.14")
    _add(torso, "freejoint", name="free")
    _add(torso, "inertial", pos="0 0 0", mass=_torso_mass(robot), diaginertia=robot.body.inertia)
    half = _half_sizes(robot)
    size = [half[0], 0.8 * half[1], TORSO_HALF_HEIGHT]
    _add(torso, "geom", type="box", size=size, mass=0, contype=0, conaffinity=1)
    equality, actuator = _add(top, "equality"), _add(top, "actuator")
    for at, leg in enumerate(robot.legs.names):
        _mjcf_leg(torso, robot, at, leg)
        _add(
            equality, "connect", name=f"{leg}_loop", body1=f"{leg}_coupler", body2=f"{leg}_rocker",
            anchor=[robot.leg.coupler, 0, 0], solref="0.002 1",
        )  # fmt: skip
        _add(actuator, "position", name=f"{leg}_shaft", joint=f"{leg}_shaft", kp=POSITION_GAIN)
    indent(top)
    return tostring(top, encoding="unicode") + "\n"


def _mjcf_leg(torso: Element, robot: RobotParameters, at: int, leg: str) -> None:
    """Bodies stand as they do at shaft angle 0; every joint counts from there, the shaft's its angle."""
    link, place = robot.leg, robot.legs.shaft_position[at]
    crank_angle, coupler_angle = coupler_angles(robot, 0.0)
    pin = np.array([link.crank * math.cos(crank_angle), link.crank * math.sin(crank_angle)])
    end = pin + link.coupler * np.array([math.cos(coupler_angle), math.sin(coupler_angle)])
    rocker_angle = math.atan2(*(end - link.ground_pivot)[::-1])
    crank = _mjcf_body(torso, f"{leg}_crank", place, crank_angle, link.crank)
    _add(crank, "joint", name=f"{leg}_shaft", axis="0 1 0", armature=0.0246, damping=SERVO_DAMPING)
    pinned = [link.crank, 0, 0]
    turn = coupler_angle - crank_angle
    coupler = _mjcf_body(crank, f"{leg}_coupler", pinned, turn, link.coupler)
    _add(coupler, "joint", name=f"{leg}_coupler", axis="0 1 0", damping=0.001)
    foot = [link.foot[0], 0, link.foot[1]]
    _add(coupler, "site", name=f"{leg}_foot", pos=foot)
    _add(
        coupler, "geom", name=f"{leg}_foot", type="sphere", size=0.005, pos=foot, mass=0,
        friction=[robot.contact.mu[at], 0, 0], contype=0, conaffinity=1,
    )  # fmt: skip
    pivot = [place[0] + link.ground_pivot[0], place[1], place[2] + link.ground_pivot[1]]
    rocker = _mjcf_body(torso, f"{leg}_rocker", pivot, rocker_angle, link.rocker)
    _add(rocker, "joint", name=f"{leg}_rocker", axis="0 1 0", damping=0.001)


def _mjcf_body(
    parent: Element, name: str, place: ArrayLike, angle: float, length: float
) -> Element:
    """A bar of a length along its own x, turned by an angle about y."""
    quat = [math.cos(angle / 2), 0, -math.sin(angle / 2), 0]
    body = _add(parent, "body", name=name, pos=place, quat=quat)
    _add(body, "inertial", pos="0 0 0", mass=LINK_MASS, diaginertia=[LINK_INERTIA] * 3)
    _add(
        body, "geom", type="capsule", fromto=[0, 0, 0, length, 0, 0], size=LINK_RADIUS,
        contype=0, conaffinity=0, mass=0,
    )  # fmt: skip
    return body


def _add(parent: Element, tag: str, **attributes: ArrayLike) -> Element:
    """Add an element; its attributes are texts, numbers and vectors."""
    texts = {
        name: value
        if isinstance(value, str)
        else " ".join(f"{number:.9g}" for number in np.ravel(value).astype(float))
        for name, value in attributes.items()
    }
    return SubElement(parent, tag, texts)
