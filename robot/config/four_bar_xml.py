"""A four-bar leg as URDF and as MJCF."""

import math
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import ArrayLike

from model.kinematics.four_bar import linkage_pose
from model.values.arrays import FloatArray
from model.values.parameters import FourBarParameters
from robot.config.xml_elements import (
    LINK_MASS,
    LINK_RADIUS,
    add,
    mjcf_body,
    mjcf_foot,
    mjcf_shaft,
    urdf_bar,
    urdf_joint,
    urdf_link,
)

LINKS = 3


def coupler_angles(link: FourBarParameters, shaft_rad: float) -> tuple[float, float]:
    """Return crank and coupler directions at a shaft angle, from +x towards +z [rad]."""
    pose = linkage_pose(link, np.array(shaft_rad))
    along = pose.rocker_pin - pose.crank_pin
    return link.mid_stance - shaft_rad, math.atan2(along[1], along[0])


def urdf_four_bar(top: Element, link: FourBarParameters, leg: str, place: FloatArray) -> None:
    """Add a leg, a tree: crank and coupler; the rocker that closes the loop is left out."""
    crank, coupler, foot = f"{leg}_crank", f"{leg}_coupler", f"{leg}_foot"
    urdf_bar(urdf_link(top, crank, LINK_MASS), (0, 0), (link.crank, 0))
    urdf_bar(urdf_link(top, coupler, LINK_MASS), (0, 0), (link.coupler, 0))
    urdf_link(top, foot, LINK_MASS)
    shaft = urdf_joint(top, f"{leg}_shaft", "continuous", "base_link", crank)
    add(shaft, "origin", xyz=place, rpy=[0, -link.mid_stance, 0])
    add(shaft, "axis", xyz="0 1 0")
    pin = urdf_joint(top, coupler, "continuous", crank, coupler)
    add(pin, "origin", xyz=[link.crank, 0, 0])
    add(pin, "axis", xyz="0 -1 0")
    end = urdf_joint(top, foot, "fixed", coupler, foot)
    add(end, "origin", xyz=[link.foot[0], 0, link.foot[1]])


def mjcf_four_bar(
    torso: Element,
    equality: Element,
    link: FourBarParameters,
    leg: str,
    place: FloatArray,
    mu: float,
) -> None:
    """Add a leg. Bodies stand as at shaft angle 0; every joint counts from there, the shaft's its angle."""
    crank_angle, coupler_angle = coupler_angles(link, 0.0)
    pin = np.array([link.crank * math.cos(crank_angle), link.crank * math.sin(crank_angle)])
    end = pin + link.coupler * np.array([math.cos(coupler_angle), math.sin(coupler_angle)])
    rocker_angle = math.atan2(*(end - link.ground_pivot)[::-1])
    crank = _bar(torso, f"{leg}_crank", place, crank_angle, link.crank)
    mjcf_shaft(crank, leg)
    pinned = [link.crank, 0, 0]
    coupler = _bar(crank, f"{leg}_coupler", pinned, coupler_angle - crank_angle, link.coupler)
    add(coupler, "joint", name=f"{leg}_coupler", axis="0 1 0", damping=0.001)
    mjcf_foot(coupler, leg, [link.foot[0], 0, link.foot[1]], mu)
    pivot = [place[0] + link.ground_pivot[0], place[1], place[2] + link.ground_pivot[1]]
    rocker = _bar(torso, f"{leg}_rocker", pivot, rocker_angle, link.rocker)
    add(rocker, "joint", name=f"{leg}_rocker", axis="0 1 0", damping=0.001)
    add(
        equality, "connect", name=f"{leg}_loop", body1=f"{leg}_coupler", body2=f"{leg}_rocker",
        anchor=[link.coupler, 0, 0], solref="0.002 1",
    )  # fmt: skip


def _bar(parent: Element, name: str, place: ArrayLike, angle: float, length: float) -> Element:
    """A bar of a length along its own x, turned by an angle from +x towards +z."""
    body = mjcf_body(parent, name, place, angle)
    add(
        body, "geom", type="capsule", fromto=[0, 0, 0, length, 0, 0], size=LINK_RADIUS,
        contype=0, conaffinity=0, mass=0,
    )  # fmt: skip
    return body
