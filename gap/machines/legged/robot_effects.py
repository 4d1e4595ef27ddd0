"""Effects that a robot file holds, as causes of the legged simulator, and back."""

import difflib
from collections.abc import Sequence

from gap.causes import check_cause
from gap.interfaces import Cause
from gap.machines.legged.catalogue import CATALOGUE
from model.errors import ConfigError, GapError
from model.parameters.effects import WrittenEffect

_EFFECTS = {entry.effect.name: entry.effect for entry in CATALOGUE}


def causes_of(written: Sequence[WrittenEffect], legs: tuple[str, ...]) -> tuple[Cause, ...]:
    """Return the causes that a robot file holds.

    Args:
        written: As they were read; a number that is left out is at its neutral value.
        legs: Names of the legs.

    Raises:
        ConfigError: An effect or a number is not known, or out of its bounds.
    """
    found = []
    for one in written:
        effect = _EFFECTS.get(one.name)
        if effect is None:
            near = difflib.get_close_matches(one.name, _EFFECTS, n=1)
            hint = f"did you mean {near[0]!r}?" if near else "bigant gap effects lists them"
            raise ConfigError(one.key, f"is no effect of the catalogue; {hint}")
        given = dict(one.values)
        known = [parameter.name for parameter in effect.parameters]
        for name in given:
            if name not in known:
                words = ", ".join(known) or "no numbers"
                raise ConfigError(f"{one.key}.{name}", f"is not known; {effect.name} has {words}")
        values = tuple(given.get(p.name, p.neutral) for p in effect.parameters)
        cause = Cause(effect.name, (one.leg,) if one.leg else (), values)
        try:
            check_cause(cause, effect, legs)
        except GapError as error:
            raise ConfigError(one.key, str(error)) from error
        found.append(cause)
    return tuple(found)


def written_of(cause: Cause) -> tuple[WrittenEffect, ...]:
    """Return how a robot file holds a cause: one table a leg.

    Raises:
        GapError: It is no effect of the catalogue.
    """
    effect = _EFFECTS.get(cause.effect)
    if effect is None:
        raise GapError(
            f"{cause.effect} is an effect of a user's own: a robot file holds numbers, not its Python; "
            "keep --effects FILE.py with the diagnosis"
        )
    names = [parameter.name for parameter in effect.parameters]
    values = tuple(zip(names, cause.values, strict=True))
    return tuple(WrittenEffect(cause.effect, leg, values) for leg in cause.joints or ("",))
