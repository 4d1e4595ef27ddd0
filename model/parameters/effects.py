"""The table ``[effects]`` of a robot file: what the nominal model lacks, by name and place.

::

    [effects.command_delay.all]
    delay_s = 0.05
    [effects.force_bias.ML]
    z_n = -1.9

Names and numbers are those of the diagnosis; who uses them checks them against its catalogue.
"""

from dataclasses import dataclass

from model.errors import ConfigError
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
