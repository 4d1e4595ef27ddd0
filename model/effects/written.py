"""The table ``[effects]`` of a robot file: what its nominal model lacks, by name and place.

::

    [effects.command_delay.all]
    delay_s = 0.05
    [effects.force_bias.ML]
    z_n = -1.9

Names and numbers are those of the catalogue.
"""

import difflib

from model.effects.catalogue import ChainEffect, places_of
from model.effects.causes import Cause, check_cause
from model.effects.leg_kinds import why_not
from model.effects.machine_scale import RobotSize, effects_for, size_of
from model.errors import ConfigError, GapError
from model.parameters.toml_table import Table
from model.values.machine_names import MachineNames
from model.values.parameters import LegGeometry, LegParameters, names_of

EFFECTS_KEY = "effects"
WHOLE_ROBOT = "all"


def table_name(effect: str, joints: tuple[str, ...]) -> str:
    """Return the dotted name of the table that holds an effect of one leg or of the whole robot."""
    return ".".join((EFFECTS_KEY, effect, *(joints or (WHOLE_ROBOT,))))


def causes_of(top: Table, names: MachineNames, size: RobotSize) -> tuple[Cause, ...]:
    """Return the causes that a whole robot file holds, in its order; a number that is left out is neutral.

    Args:
        top: The file.
        names: Names of joints and legs.
        size: Size of the robot, which bounds depend on.

    Raises:
        ConfigError: An effect, a place or a number is not known, or out of its bounds.
    """
    causes = []
    table, known_effects = top.maybe_table(EFFECTS_KEY), effects_for(size)
    for name in table.names():
        places = table.table(name)
        for place in places.names():
            legs = places_of(known_effects[name], names) if name in known_effects else names.legs
            if place != WHOLE_ROBOT and place not in legs:
                known = ", ".join((WHOLE_ROBOT, *legs))
                raise ConfigError(places.name(place), f"is no place; places are {known}")
            joints = () if place == WHOLE_ROBOT else (place,)
            effect = known_effects.get(name)
            if effect is None:
                near = difflib.get_close_matches(name, known_effects, n=1)
                hint = f"did you mean {near[0]!r}?" if near else "bigant gap effects lists them"
                raise ConfigError(
                    table_name(name, joints), f"is no effect of the catalogue; {hint}"
                )
            causes.append(_cause_of(effect, joints, places.table(place), legs))
    return tuple(causes)


def causes_for(
    top: Table, mass_kg: float, legs: LegParameters, leg: LegGeometry
) -> tuple[Cause, ...]:
    """Return the causes that a whole robot file holds, all such that its kind of leg can have them.

    Raises:
        ConfigError: An effect, a place or a number is not known or out of its bounds, or means nothing for
            such legs.
    """
    causes = causes_of(top, names_of(legs, leg), size_of(mass_kg, legs, leg))
    for cause in causes:
        reason = why_not(cause.effect, leg)
        if reason:
            raise ConfigError(table_name(cause.effect, cause.joints), f"cannot be: {reason}")
    return causes


def _cause_of(
    effect: ChainEffect, joints: tuple[str, ...], numbers: Table, legs: tuple[str, ...]
) -> Cause:
    name, key = effect.name, table_name(effect.name, joints)
    given = {number: numbers.number(number) for number in numbers.names()}
    known = [parameter.name for parameter in effect.parameters]
    for number in given:
        if number not in known:
            words = ", ".join(known) or "no numbers"
            raise ConfigError(f"{key}.{number}", f"is not known; {name} has {words}")
    cause = Cause(name, joints, tuple(given.get(p.name, p.neutral) for p in effect.parameters))
    try:
        check_cause(cause, effect, legs)
    except GapError as error:
        raise ConfigError(key, str(error)) from error
    return cause
