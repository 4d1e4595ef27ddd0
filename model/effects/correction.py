"""What causes change in a robot file: keys that it has, and effects for what no key can express.

A key is changed where the robot itself differs from its drawing: links, mounts, springs, friction. What
the world, servos, clocks or sensors do stays an effect, because a robot file's other keys say how devices
are to be read: changing those would make the file contradict what it recorded.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from model.effects.catalogue import EFFECTS, TOGETHER, Combine
from model.effects.causes import Cause
from model.effects.written import WrittenEffect, written_of
from model.errors import GapError

PAYLOAD = "payload"
# Effects for which a robot file has a key: one number a leg in [contact], or a pair a leg.
FACTORS = {"leg_stiffness": "stiffness", "foot_friction": "mu", "friction_level": "mu"}
SUMMANDS = {
    "friction_anisotropy": ("contact", "anisotropy"),
    "hip_mount_offset": ("legs", "shaft_position"),
}


@dataclass(frozen=True, slots=True)
class KeyChange:
    """One number of a robot file: new = factor times old plus ``plus``.

    Attributes:
        table: Its table.
        key: Its key.
        index: Where in an array; empty for a number by itself.
        factor: Factor.
        plus: Summand.
        cause: Why.
    """

    table: str
    key: str
    index: tuple[int, ...]
    factor: float
    plus: float
    cause: Cause


@dataclass(frozen=True, slots=True)
class Correction:
    """What is to be done to a robot file.

    Attributes:
        changes: Numbers of its keys.
        effects: What its table of effects is to hold besides.
    """

    changes: tuple[KeyChange, ...]
    effects: tuple[WrittenEffect, ...]


def correction_of(causes: Sequence[Cause], legs: tuple[str, ...]) -> Correction:
    """Return what causes change in a robot file.

    Raises:
        GapError: A robot file cannot hold a cause.
    """
    changes: list[KeyChange] = []
    effects: list[WrittenEffect] = []
    for cause in causes:
        own = _key_changes(cause, [legs.index(leg) for leg in cause.joints or legs])
        if own is None:
            effects += written_of(cause)
        else:
            changes += own
    return Correction(tuple(changes), merged((), effects))


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
        table, names = "linkage", ("crank", "coupler", "rocker")
        places = [(key, (), value) for key, value in zip(names, values, strict=True)]
    else:
        return None
    return [
        KeyChange(table, key, at, 1.0, value, cause) for key, at, value in places if value != 0.0
    ]


def merged(
    there: Sequence[WrittenEffect], added: Sequence[WrittenEffect]
) -> tuple[WrittenEffect, ...]:
    """Add effects to those that are there; one that is there already grows.

    Raises:
        GapError: The two cannot be one: a step here and a step there.
    """
    found = {(one.name, one.leg): one for one in there}
    for one in added:
        old = found.get((one.name, one.leg))
        found[one.name, one.leg] = one if old is None else _together(old, one)
    return tuple(found.values())


def _together(old: WrittenEffect, new: WrittenEffect) -> WrittenEffect:
    effect = EFFECTS[old.name]
    names = [parameter.name for parameter in effect.parameters]
    neutral = {parameter.name: parameter.neutral for parameter in effect.parameters}
    a, b = neutral | dict(old.values), neutral | dict(new.values)
    if effect.name == PAYLOAD:  # loads on the body: their centre
        mass = a["mass_kg"] + b["mass_kg"]
        share = b["mass_kg"] / mass if mass else 0.0
        values = [mass] + [(1 - share) * a[name] + share * b[name] for name in names[1:]]
        return WrittenEffect(old.name, old.leg, tuple(zip(names, values, strict=True)))
    if effect.apart:
        raise GapError(
            f"{old.key} is there already, and two of it act one behind the other, which one table cannot "
            "say; take the old one out of the robot file"
        )
    values = []
    for name, how in zip(names, effect.combine, strict=True):
        if how is Combine.SET and a[name] != b[name]:
            raise GapError(
                f"{old.key} has {name} = {a[name]:g} already, and another at {b[name]:g} cannot be added; "
                "take the old one out of the robot file"
            )
        values.append(TOGETHER[how](a[name], b[name]))
    return WrittenEffect(old.name, old.leg, tuple(zip(names, values, strict=True)))
