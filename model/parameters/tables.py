"""The physical tables of a robot file: body, legs, leg and contact, read strictly.

``robot.config.robot_file`` reads whole robot files with these readers; the diagnosis reads the robot beside
a trial with the same ones, so that the two cannot drift apart.
"""

from collections.abc import Container

import numpy as np

from model.errors import ConfigError
from model.kinematics.crank import check_crank
from model.kinematics.four_bar import check_linkage
from model.parameters.chain_table import first_places, read_chain
from model.parameters.toml_table import Table, parse_toml
from model.values.parameters import (
    BodyParameters,
    ChainParameters,
    ContactParameters,
    CrankParameters,
    FourBarParameters,
    LegGeometry,
    LegParameters,
)

FEWEST_LEGS = 3
LEG_TABLE = "leg"
OLD_LEG_TABLE = "linkage"
FOUR_BAR, CRANK, CHAIN = LEG_KINDS = ("four_bar", "crank", "chain")
# Of a chain, where its table of numbers came from.
CHAIN_SOURCE = ("model", "feet", "body", "origin", "joints", "sign", "zero", "radius")


def parse_table(text: str, what: str = "robot file") -> Table:
    """Parse the text of a robot file, or of another TOML file.

    Raises:
        ConfigError: It is no TOML.
    """
    return Table(parse_toml(text, what))


def read_body(table: Table) -> BodyParameters:
    """Read [body]: mass and inertia.

    Raises:
        ConfigError: A key is missing, or no rigid body is like that.
    """
    body = BodyParameters(
        mass=table.number("mass", above=0), inertia=table.numbers("inertia", (3,), above=0)
    )
    moments = np.sort(body.inertia)
    if moments[0] + moments[1] < moments[2]:
        raise ConfigError(
            table.name("inertia"),
            f"no rigid body has these moments: the largest, {moments[2]:g}, exceeds the sum of the "
            f"other two, {moments[0] + moments[1]:g}",
        )
    return body


def read_leg_names(table: Table) -> tuple[str, ...]:
    """Read the names of [legs].

    Raises:
        ConfigError: They are missing, or too few.
    """
    names = table.part_names("order")
    if len(names) < FEWEST_LEGS:
        raise ConfigError(table.name("order"), f"needs three legs or more, not {len(names)}")
    return names


def read_legs(table: Table, leg: LegGeometry) -> LegParameters:
    """Read names and crank shafts of [legs]; a chain knows itself where it is fixed to the body.

    Raises:
        ConfigError: A key is missing, or there are too few legs.
    """
    names = read_leg_names(table)
    if isinstance(leg, ChainParameters):
        return LegParameters(names, first_places(leg))
    return LegParameters(names, table.numbers("shaft_position", (len(names), 3)))


def leg_table(names: Container[str]) -> str:
    """Return which table of a robot file has the geometry of a leg; older files name it otherwise."""
    return OLD_LEG_TABLE if OLD_LEG_TABLE in names and LEG_TABLE not in names else LEG_TABLE


def read_leg(top: Table) -> LegGeometry:
    """Read [leg] of a whole robot file, or [linkage] of an older one, which is a four-bar.

    Raises:
        ConfigError: A key is missing, a kind is not known, or the leg cannot move.
    """
    name = leg_table(top.names())
    table = top.table(name)
    kind = table.word("kind", LEG_KINDS) if name == LEG_TABLE else FOUR_BAR
    if kind == CHAIN:
        return _chain(table, len(read_leg_names(top.table("legs"))))
    return _crank(table) if kind == CRANK else _four_bar(table)


def _chain(table: Table, legs: int) -> ChainParameters:
    for key in CHAIN_SOURCE:
        table.has(key)
    if not table.has(CHAIN):
        words = "is missing: the legs are in a file of their own; name the robot file where it lies"
        raise ConfigError(table.name(CHAIN), words)
    return read_chain(table.table(CHAIN), legs)


def _crank(table: Table) -> CrankParameters:
    crank = CrankParameters(
        length=table.number("length", above=0),
        radius=table.number("radius", minimum=0, otherwise=0.0),
    )
    check_crank(crank, table.name)
    return crank


def _four_bar(table: Table) -> FourBarParameters:
    branch = table.integer("branch", minimum=-1, maximum=1)
    if branch == 0:
        raise ConfigError(table.name("branch"), "must be 1 or -1, not 0")
    linkage = FourBarParameters(
        crank=table.number("crank", above=0),
        ground_pivot=table.numbers("ground_pivot", (2,)),
        coupler=table.number("coupler", above=0),
        rocker=table.number("rocker", above=0),
        foot=table.numbers("foot", (2,)),
        branch=branch,
        mid_stance=table.number("mid_stance"),
    )
    check_linkage(linkage, table.name)
    return linkage


def read_contact(table: Table, count: int) -> ContactParameters:
    """Read [contact] of ``count`` legs.

    Raises:
        ConfigError: A key is missing or of the wrong length.
    """
    return ContactParameters(
        stiffness=table.numbers("stiffness", (count,), above=0),
        mu=table.numbers("mu", (count,), above=0),
        anisotropy=table.numbers("anisotropy", (count, 2)),
    )
