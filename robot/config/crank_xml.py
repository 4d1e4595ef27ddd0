"""A crank, straight or with a half circle, as URDF and as MJCF."""

from itertools import pairwise
from xml.etree.ElementTree import Element

import numpy as np

from model.kinematics.crank import crank_outline
from model.values.arrays import FloatArray
from model.values.parameters import CrankParameters
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

LINKS = 1


def _middle_line(leg: CrankParameters) -> FloatArray:
    """Corners (x, z) of bars whose outside is the leg's, from the shaft to the toe, (K, 2) [m]."""
    inner = leg
    if leg.radius > LINK_RADIUS:
        inner = CrankParameters(leg.length - LINK_RADIUS, leg.radius - LINK_RADIUS)
    corners = crank_outline(inner, 0.0)
    return corners if not corners[0].any() else np.concatenate([np.zeros((1, 2)), corners])


def urdf_crank(top: Element, crank: CrankParameters, leg: str, place: FloatArray) -> None:
    """Add a leg; its toe is a link, straight down at angle 0."""
    bars = urdf_link(top, f"{leg}_leg", LINK_MASS / 2)
    for start, end in pairwise(_middle_line(crank)):
        urdf_bar(bars, start, end)
    urdf_link(top, f"{leg}_foot", LINK_MASS / 2)
    shaft = urdf_joint(top, f"{leg}_shaft", "continuous", "base_link", f"{leg}_leg")
    add(shaft, "origin", xyz=place)
    add(shaft, "axis", xyz="0 1 0")
    toe = urdf_joint(top, f"{leg}_foot", "fixed", f"{leg}_leg", f"{leg}_foot")
    add(toe, "origin", xyz=[0, 0, -crank.length])


def mjcf_crank(
    torso: Element, crank: CrankParameters, leg: str, place: FloatArray, mu: float
) -> None:
    """Add a leg. A half circle touches the ground with all of its bars, a straight leg with its toe."""
    body = mjcf_body(torso, f"{leg}_leg", place)
    mjcf_shaft(body, leg)
    toe = [0, 0, -crank.length]
    if crank.radius <= LINK_RADIUS:
        mjcf_foot(body, leg, toe, mu)
    else:
        add(body, "site", name=f"{leg}_foot", pos=toe)
    for start, end in pairwise(_middle_line(crank)):
        touching = int(crank.radius > LINK_RADIUS)
        add(
            body, "geom", type="capsule", fromto=[start[0], 0, start[1], end[0], 0, end[1]],
            size=LINK_RADIUS, friction=[mu, 0, 0], contype=0, conaffinity=touching, mass=0,
        )  # fmt: skip
