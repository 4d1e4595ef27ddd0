"""Causes to settings: checked against the catalogue, then written where they act."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gap.causes import check_cause
from gap.effect_file import UserEffect
from gap.interfaces import Cause
from gap.machines.legged.catalogue import CATALOGUE, Combine, Place
from gap.machines.legged.settings import Added, Settings, neutral_settings
from model.errors import GapError

_ENTRIES = {entry.effect.name: entry for entry in CATALOGUE}


def settings_of(
    causes: Sequence[Cause], legs: tuple[str, ...], added: tuple[UserEffect, ...] = ()
) -> Settings:
    """Write causes into settings.

    Args:
        causes: Any number; two of one effect act together.
        legs: Names of the legs.
        added: Users' effects that causes may name too.

    Raises:
        GapError: A cause is not of the catalogue, or its joints or values do not fit.
    """
    settings = neutral_settings(len(legs))
    users = {user.effect.name: user for user in added}
    for cause in causes:
        if cause.effect in users:
            user = users[cause.effect]
            mask = check_cause(cause, user.effect, legs)
            extra = Added(user.effect.stage, user.act, cause.values, mask)
            settings = replace(settings, added=(*settings.added, extra))
        elif cause.effect in _ENTRIES:
            entry = _ENTRIES[cause.effect]
            mask = check_cause(cause, entry.effect, legs)
            settings = _write(settings, entry.places, cause.values, mask)
        else:
            known = ", ".join([*_ENTRIES, *users])
            raise GapError(f"{cause.effect!r} is no effect of this simulator; known are {known}")
    return settings


def _write(
    settings: Settings, places: tuple[Place, ...], values: tuple[float, ...], mask: tuple[bool, ...]
) -> Settings:
    changes: dict[str, dict[str, Any]] = {"shaft": {}, "ground": {}, "sensor": {}}
    for at, place in enumerate(places):
        old = getattr(getattr(settings, place.group), place.field)
        if place.combine is Combine.LIST:
            # nothing rides along when the first number, the mass, is 0
            new: Any = old if values[0] == 0.0 else (*old, values)
        elif place.combine is Combine.SERIES:
            new = (*old, tuple(values[at] if touched else 0.0 for touched in mask))
        elif not values:
            new = True  # a law that is there or not
        elif isinstance(old, tuple):
            new = tuple(
                _combined(number, values[at], place.combine) if touched else number
                for number, touched in zip(old, mask, strict=True)
            )
        else:
            new = _combined(old, values[at], place.combine)
        changes[place.group][place.field] = new
    groups = {
        name: replace(getattr(settings, name), **fields)
        for name, fields in changes.items()
        if fields
    }
    return replace(settings, **groups)


def _combined(old: float, value: float, combine: Combine) -> float:
    if combine is Combine.MULTIPLY:
        return old * value
    if combine is Combine.LEAST:
        return min(old, value)
    return value if combine is Combine.SET else old + value
