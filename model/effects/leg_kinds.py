"""Which effects of the catalogue a kind of leg can have, and why it cannot have the others."""

from collections.abc import Iterable

from model.effects.catalogue import CATALOGUE, ChainEffect
from model.effects.causes import Cause
from model.errors import GapError
from model.values.parameters import ChainParameters, CrankParameters, FourBarParameters, LegGeometry

# What is not known of a chain of joints.
OF_ONE_JOINT = {
    "link_length": "which links a chain has is said by its model alone; correct the model",
    "foot_rolling": "how far the last link of several joints has turned is not looked at",
}


def effects_of(leg: LegGeometry) -> tuple[ChainEffect, ...]:
    """Return the effects of the catalogue that a robot with such legs can have, in its order."""
    return tuple(effect for effect in CATALOGUE if not why_not(effect.name, leg))


def why_not(effect: str, leg: LegGeometry) -> str:
    """Return why such legs cannot have an effect of the catalogue, in words; empty where they can."""
    match leg:
        case FourBarParameters():
            return ""
        case CrankParameters():
            if effect == "link_length":
                return "a crank has no links; what is longer or shorter about it is leg_length"
            if effect == "foot_rolling" and leg.radius > 0:
                return "the robot file has these legs roll already; it is radius in its [leg]"
            return ""
        case ChainParameters():
            return OF_ONE_JOINT.get(effect, "")


def check_effects(causes: Iterable[Cause], leg: LegGeometry) -> None:
    """Refuse causes that such legs cannot have.

    Raises:
        GapError: One of them is such a cause; with the reason.
    """
    for cause in causes:
        reason = why_not(cause.effect, leg)
        if reason:
            raise GapError(f"this robot cannot have {cause.effect}: {reason}")
