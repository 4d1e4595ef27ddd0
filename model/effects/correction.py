"""What causes change in a robot file: keys that it has, and effects for what no key can express.

A key is changed where the robot itself differs from its drawing: links, mounts, springs, friction. What
the world, servos, clocks or sensors do stays an effect, because a robot file's other keys say how devices
are to be read: changing those would make the file contradict what it recorded.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from model.effects.catalogue import EFFECTS, TOGETHER, Combine
from model.effects.causes import Cause
from model.effects.written import table_name
from model.errors import GapError
from model.values.parameters import ChainParameters, LegGeometry

PAYLOAD = "payload"
# Effects for which a robot file has a key: one number a leg in [contact], or a pair a leg.
FACTORS = {"leg_stiffness": "stiffness", "foot_friction": "mu", "friction_level": "mu"}
SUMMANDS = {
    "friction_anisotropy": ("contact", "anisotropy"),
    "hip_mount_offset": ("legs", "shaft_position"),
}


@dataclass(frozen=True, slots=True)
class KeyChange:
    """One number of a robot file, by itself or in an array: new = factor times old plus ``plus``."""

    table: str
    key: str
    index: tuple[int, ...]
    factor: float
    plus: float
    cause: Cause


@dataclass(frozen=True, slots=True)
class Correction:
    """Numbers to change in a robot file, and what its table of effects is to hold besides, each a leg's."""

    changes: tuple[KeyChange, ...]
    effects: tuple[Cause, ...]


def keyless_of(leg: LegGeometry) -> frozenset[str]:
    """Return the effects for which the file of a robot with such legs has no key, though others have."""
    return frozenset({"hip_mount_offset"} if isinstance(leg, ChainParameters) else ())


def correction_of(
    causes: Sequence[Cause], legs: tuple[str, ...], keyless: frozenset[str] = frozenset()
) -> Correction:
    """Return what causes change in a robot file.

    Args:
        causes: The causes.
        legs: Names of its legs.
        keyless: Effects for which it has no key; see ``keyless_of``.

    Raises:
        GapError: A robot file cannot hold a cause.
    """
    changes: list[KeyChange] = []
    effects: list[Cause] = []
    for cause in causes:
        own = None
        if cause.effect not in keyless and not set(cause.joints) - set(legs):
            own = _key_changes(cause, [legs.index(leg) for leg in cause.joints or legs])
        if own is None:
            effects += _each_leg(cause)
        else:
            changes += own
    return Correction(tuple(changes), merged((), effects))


def _each_leg(cause: Cause) -> list[Cause]:
    if cause.effect not in EFFECTS:
        raise GapError(
            f"{cause.effect} is an effect of a user's own: a robot file holds numbers, not its Python; "
            "keep --effects FILE.py with the diagnosis"
        )
    return [replace(cause, joints=(leg,)) for leg in cause.joints] or [cause]


def _key_changes(cause: Cause, legs: list[int]) -> list[KeyChange] | None:
    """Changes of keys that a robot file has for a cause, None where it has none."""
    effect, values = cause.effect, cause.values
    if effect in FACTORS:
        return [
            KeyChange("contact", FACTORS[effect], (leg,), values[0], 0.0, cause) for leg in legs
        ]
    places: list[tuple[str, tuple[int, ...], float]]
    if effect in SUMMANDS:
        table, key = SUMMANDS[effect]
        places = [(key, (leg, axis), value) for leg in legs for axis, value in enumerate(values)]
    elif effect == "link_length" and not cause.joints:
        # a robot file has one four-bar for all legs: a single leg's links are an effect
        table, names = "leg", ("crank", "coupler", "rocker")
        places = [(key, (), value) for key, value in zip(names, values, strict=True)]
    else:
        return None
    return [
        KeyChange(table, key, at, 1.0, value, cause) for key, at, value in places if value != 0.0
    ]


def merged(there: Sequence[Cause], added: Sequence[Cause]) -> tuple[Cause, ...]:
    """Add causes of one leg or of the whole robot to those that are there; one that is there grows.

    Raises:
        GapError: The two cannot be one: a step here and a step there.
    """
    together = {(one.effect, one.joints): one for one in there}
    for one in added:
        key = (one.effect, one.joints)
        together[key] = _together(together[key], one) if key in together else one
    return tuple(together.values())


def _together(old: Cause, new: Cause) -> Cause:
    effect, key = EFFECTS[old.effect], table_name(old.effect, old.joints)
    pairs = zip(old.values, new.values, strict=True)
    if effect.name == PAYLOAD:  # loads on the body: their centre
        mass = old.values[0] + new.values[0]
        share = new.values[0] / mass if mass else 0.0
        centre = [(1 - share) * a + share * b for a, b in pairs]
        return replace(old, values=(mass, *centre[1:]))
    if effect.apart:
        raise GapError(
            f"{key} is there already, and two of it act one behind the other, which one table cannot "
            "say; take the old one out of the robot file"
        )
    values = []
    for (a, b), parameter, how in zip(pairs, effect.parameters, effect.combine, strict=True):
        if how is Combine.SET and a != b:
            raise GapError(
                f"{key} has {parameter.name} = {a:g} already, and another at {b:g} cannot be added; "
                "take the old one out of the robot file"
            )
        values.append(TOGETHER[how](a, b))
    return replace(old, values=tuple(values))
