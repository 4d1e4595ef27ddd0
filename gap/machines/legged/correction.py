"""What causes change in a robot file: keys that it has, and effects for what no key can express.

A key is changed where the robot itself differs from its drawing: links, mounts, springs, friction. What
the world, servos, clocks or sensors do stays an effect, because a robot file's other keys say how devices
are to be read: changing those would make the file contradict what it recorded.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gap.interfaces import Cause
from gap.machines.legged.catalogue import CATALOGUE, Combine
from gap.machines.legged.robot_effects import written_of
from model.errors import GapError
from model.parameters.effects import WrittenEffect

_ENTRIES = {entry.effect.name: entry for entry in CATALOGUE}


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
        write = _KEYS.get(cause.effect)
        if write is None or (cause.effect in _ONE_FOR_ALL and cause.joints):
            effects += written_of(cause)
        else:
            on = [legs.index(leg) for leg in cause.joints or legs]
            changes += write(cause, on)
    return Correction(tuple(changes), merged((), effects))


def _times(key: str) -> Callable[[Cause, list[int]], list[KeyChange]]:
    return lambda cause, on: [
        KeyChange("contact", key, (leg,), cause.values[0], 0.0, cause) for leg in on
    ]


def _plus_pair(table: str, key: str) -> Callable[[Cause, list[int]], list[KeyChange]]:
    return lambda cause, on: [
        KeyChange(table, key, (leg, axis), 1.0, value, cause)
        for leg in on
        for axis, value in enumerate(cause.values)
        if value != 0.0
    ]


def _links(cause: Cause, on: list[int]) -> list[KeyChange]:
    pairs = zip(("crank", "coupler", "rocker"), cause.values, strict=True)
    return [KeyChange("linkage", name, (), 1.0, by, cause) for name, by in pairs if by != 0.0]


_KEYS: dict[str, Callable[[Cause, list[int]], list[KeyChange]]] = {
    "leg_stiffness": _times("stiffness"),
    "foot_friction": _times("mu"),
    "friction_level": _times("mu"),
    "friction_anisotropy": _plus_pair("contact", "anisotropy"),
    "hip_mount_offset": _plus_pair("legs", "shaft_position"),
    "link_length": _links,
}
# A robot file has one four-bar for all legs: a single leg's links are an effect.
_ONE_FOR_ALL = frozenset({"link_length"})


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
    entry = _ENTRIES[old.name]
    names = [parameter.name for parameter in entry.effect.parameters]
    neutral = {parameter.name: parameter.neutral for parameter in entry.effect.parameters}
    a, b = neutral | dict(old.values), neutral | dict(new.values)
    if any(place.combine is Combine.LIST for place in entry.places):
        # loads on the body: their centre
        mass = a["mass_kg"] + b["mass_kg"]
        share = b["mass_kg"] / mass if mass else 0.0
        values = [mass] + [(1 - share) * a[name] + share * b[name] for name in names[1:]]
        return WrittenEffect(old.name, old.leg, tuple(zip(names, values, strict=True)))
    values = []
    for name, place in zip(names, entry.places, strict=False):
        if place.combine is Combine.SET and a[name] != b[name]:
            raise GapError(
                f"{old.key} has {name} = {a[name]:g} already, and another at {b[name]:g} cannot be added; "
                "take the old one out of the robot file"
            )
        values.append(_COMBINED[place.combine](a[name], b[name]))
    return WrittenEffect(old.name, old.leg, tuple(zip(names, values, strict=True)))


_COMBINED: dict[Combine, Callable[[float, float], float]] = {
    Combine.ADD: lambda a, b: a + b,
    Combine.MULTIPLY: lambda a, b: a * b,
    Combine.LEAST: min,
    Combine.SET: lambda a, b: b,
}
