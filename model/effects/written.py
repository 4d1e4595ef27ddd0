"""The table ``[effects]`` of a robot file, what its nominal model lacks by name and place, and its causes.

::

    [effects.command_delay.all]
    delay_s = 0.05
    [effects.force_bias.ML]
    z_n = -1.9

Names and numbers are those of the catalogue.
"""

import difflib
from dataclasses import dataclass

from model.effects.catalogue import EFFECTS
from model.effects.causes import Cause, check_cause
from model.errors import ConfigError, GapError
from model.parameters.toml_table import Table

EFFECTS_KEY = "effects"
WHOLE_ROBOT = "all"


@dataclass(frozen=True, slots=True)
class WrittenEffect:
    """One effect at one place, as a robot file has it.

    Attributes:
        name: Its name.
        leg: Leg it acts on; empty for the whole robot.
        values: Name and value of each number that is given.
    """

    name: str
    leg: str
    values: tuple[tuple[str, float], ...]

    @property
    def key(self) -> str:
        """Dotted name of its table."""
        return f"{EFFECTS_KEY}.{self.name}.{self.leg or WHOLE_ROBOT}"


def read_effects(top: Table, legs: tuple[str, ...]) -> tuple[WrittenEffect, ...]:
    """Read the effects of a robot file, in its order; none where the table is left out.

    Args:
        top: The whole robot file.
        legs: Names of its legs.

    Raises:
        ConfigError: A place is no leg, or a value is no number.
    """
    found = []
    table = top.maybe_table(EFFECTS_KEY)
    for name in table.names():
        places = table.table(name)
        for place in places.names():
            if place != WHOLE_ROBOT and place not in legs:
                known = ", ".join((WHOLE_ROBOT, *legs))
                raise ConfigError(places.name(place), f"is no place; places are {known}")
            numbers = places.table(place)
            values = tuple((key, numbers.number(key)) for key in numbers.names())
            found.append(WrittenEffect(name, "" if place == WHOLE_ROBOT else place, values))
    return tuple(found)


def causes_of(top: Table, legs: tuple[str, ...]) -> tuple[Cause, ...]:
    """Return the causes that a robot file holds; a number that is left out is at its neutral value.

    Args:
        top: The whole robot file.
        legs: Names of its legs.

    Raises:
        ConfigError: An effect, a place or a number is not known, or out of its bounds.
    """
    return tuple(_cause_of(one, legs) for one in read_effects(top, legs))


def _cause_of(written: WrittenEffect, legs: tuple[str, ...]) -> Cause:
    effect = EFFECTS.get(written.name)
    if effect is None:
        near = difflib.get_close_matches(written.name, EFFECTS, n=1)
        hint = f"did you mean {near[0]!r}?" if near else "bigant gap effects lists them"
        raise ConfigError(written.key, f"is no effect of the catalogue; {hint}")
    given = dict(written.values)
    known = [parameter.name for parameter in effect.parameters]
    for name in given:
        if name not in known:
            words = ", ".join(known) or "no numbers"
            raise ConfigError(f"{written.key}.{name}", f"is not known; {effect.name} has {words}")
    values = tuple(given.get(p.name, p.neutral) for p in effect.parameters)
    cause = Cause(effect.name, (written.leg,) if written.leg else (), values)
    try:
        check_cause(cause, effect, legs)
    except GapError as error:
        raise ConfigError(written.key, str(error)) from error
    return cause


def written_of(cause: Cause) -> tuple[WrittenEffect, ...]:
    """Return how a robot file holds a cause: one table a leg.

    Raises:
        GapError: It is no effect of the catalogue.
    """
    effect = EFFECTS.get(cause.effect)
    if effect is None:
        raise GapError(
            f"{cause.effect} is an effect of a user's own: a robot file holds numbers, not its Python; "
            "keep --effects FILE.py with the diagnosis"
        )
    names = [parameter.name for parameter in effect.parameters]
    values = tuple(zip(names, cause.values, strict=True))
    return tuple(WrittenEffect(cause.effect, leg, values) for leg in cause.joints or ("",))
