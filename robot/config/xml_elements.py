"""Elements that URDF and MJCF of any kind of leg are made of."""

import math
from xml.etree.ElementTree import Element, SubElement

import numpy as np
from numpy.typing import ArrayLike

# Masses of the moving links; assumed, as in the plant. The torso has the rest.
LINK_MASS = 0.03
LINK_INERTIA = 1e-5
LINK_RADIUS = 0.005
SHAFT_ARMATURE = 0.0246  # kg m^2: the MX-106's rotor seen at its output
SERVO_DAMPING = 2.1  # N m s/rad: its back-EMF


def add(parent: Element, tag: str, **attributes: ArrayLike) -> Element:
    """Add an element; its attributes are texts, numbers and vectors."""
    texts = {
        name: value
        if isinstance(value, str)
        else " ".join(f"{number:.9g}" for number in np.ravel(value).astype(float))
        for name, value in attributes.items()
    }
    return SubElement(parent, tag, texts)


def urdf_link(
    top: Element, name: str, mass: float, inertia: ArrayLike = (LINK_INERTIA,) * 3
) -> Element:
    """Add a link."""
    link = add(top, "link", name=name)
    inertial = add(link, "inertial")
    add(inertial, "mass", value=mass)
    xx, yy, zz = np.asarray(inertia)
    add(inertial, "inertia", ixx=xx, ixy=0, ixz=0, iyy=yy, iyz=0, izz=zz)
    return link


def urdf_bar(link: Element, start: ArrayLike, end: ArrayLike) -> None:
    """Draw a bar between two points (x, z) of a link."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    along, middle = end - start, (start + end) / 2
    visual = add(link, "visual")
    place = [middle[0], 0, middle[1]]
    add(visual, "origin", xyz=place, rpy=[0, math.atan2(along[0], along[1]), 0])
    length = float(np.hypot(*along))
    add(add(visual, "geometry"), "cylinder", radius=LINK_RADIUS, length=length)


def urdf_joint(top: Element, name: str, kind: str, parent: str, child: str) -> Element:
    """Add a joint."""
    joint = add(top, "joint", name=f"{name}_joint", type=kind)
    add(joint, "parent", link=parent)
    add(joint, "child", link=child)
    return joint


def mjcf_body(parent: Element, name: str, place: ArrayLike, angle: float = 0.0) -> Element:
    """Add a moving link, turned by an angle from +x towards +z."""
    quat = [math.cos(angle / 2), 0, -math.sin(angle / 2), 0]
    body = add(parent, "body", name=name, pos=place, quat=quat)
    add(body, "inertial", pos="0 0 0", mass=LINK_MASS, diaginertia=[LINK_INERTIA] * 3)
    return body


def mjcf_shaft(body: Element, leg: str) -> None:
    """Give a link the servo's shaft; its value is the shaft angle."""
    add(
        body, "joint", name=f"{leg}_shaft", axis="0 1 0", armature=SHAFT_ARMATURE,
        damping=SERVO_DAMPING,
    )  # fmt: skip


def mjcf_foot(body: Element, leg: str, place: ArrayLike, mu: float) -> None:
    """Give a link a foot: a site, and a small sphere that touches the ground."""
    add(body, "site", name=f"{leg}_foot", pos=place)
    add(
        body, "geom", name=f"{leg}_foot", type="sphere", size=LINK_RADIUS, pos=place, mass=0,
        friction=[mu, 0, 0], contype=0, conaffinity=1,
    )  # fmt: skip
