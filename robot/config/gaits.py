"""Gaits of the robot file: any number of tables ``[gait.NAME]``, in the order in which they are written.

[gait.tripod]                # kind = "tripod": two groups of legs on the Buehler clock
[gait.metachronal]           # kind = "metachronal": waves from behind, shaft angle a cubic of time
[gait.ripple]                # any other gait: each leg's own touchdown, duty and sweep
kind = "phases"
frequency = 0.1
touchdown = [0.0, 0.3333, 0.6667, 0.5, 0.8333, 0.1667]   # share of the cycle, one a leg
duty = 0.6667                # a number, or a list of one a leg; so are the others
stance_sweep = 2.0
offset = 0.0                 # optional, shaft angle at mid-stance
cubic = 0.0                  # optional: as in the metachronal gait
# blend = 0.02               # instead of cubic: the Buehler clock
"""

import re
from functools import partial

import numpy as np

from gaits.names import METACHRONAL, TRIPOD
from gaits.touchdowns import two_groups, waves_from_behind
from model.errors import ConfigError
from model.parameters.toml_table import Table
from model.values.arrays import FloatArray, readonly
from model.values.parameters import (
    BuehlerParameters,
    ClockParameters,
    CubicParameters,
    LegParameters,
)

PHASES = "phases"
KINDS = (TRIPOD, METACHRONAL, PHASES)
FULL_TURN = 2 * np.pi
GAIT_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


def read_gaits(table: Table, legs: LegParameters) -> tuple[ClockParameters, ...]:
    """Read the gaits of a robot.

    Raises:
        ConfigError: A table cannot be used.
    """
    for name in table.names():
        if not GAIT_NAME.fullmatch(name):
            raise ConfigError(
                table.name(name), "must be named by letters, digits, _ and -, a letter first"
            )
    return tuple(_gait(name, table.table(name), legs) for name in table.names())


def _gait(name: str, table: Table, legs: LegParameters) -> ClockParameters:
    kind = name if name in KINDS and not table.has("kind") else table.word("kind", KINDS)
    frequency = table.number("frequency", above=0)
    if kind == TRIPOD:
        return _tripod(name, frequency, table, legs)
    if kind == METACHRONAL:
        return _metachronal(name, frequency, table, legs)
    return _phases(name, frequency, table, legs.count)


def _tripod(name: str, frequency: float, table: Table, legs: LegParameters) -> BuehlerParameters:
    first = table.texts("group_a")
    for leg in first:
        if leg not in legs.names:
            raise ConfigError(
                table.name("group_a"), f"{leg!r} is no leg; legs are {', '.join(legs.names)}"
            )
    if not 0 < len(first) < legs.count:
        raise ConfigError(table.name("group_a"), "must leave at least one leg for the other group")
    return BuehlerParameters(
        name,
        frequency,
        touchdown=two_groups(legs, first),
        stance_sweep=_same(table.number("stance_sweep", above=0, below=FULL_TURN), legs.count),
        duty=_same(table.number("duty", above=0, below=1), legs.count),
        offset=_same(table.number("offset", above=-np.pi, below=np.pi), legs.count),
        blend=table.number("blend", minimum=0, below=1),
    )


def _metachronal(name: str, frequency: float, table: Table, legs: LegParameters) -> CubicParameters:
    return CubicParameters(
        name,
        frequency,
        touchdown=waves_from_behind(legs),
        stance_sweep=_same(table.number("stance_sweep", above=0, below=FULL_TURN), legs.count),
        duty=_same(table.number("duty", above=0, below=1), legs.count),
        offset=_same(0.0, legs.count),
        cubic=_same(table.number("cubic", minimum=0, maximum=1), legs.count),
    )


def _phases(name: str, frequency: float, table: Table, count: int) -> ClockParameters:
    if table.has("blend") and table.has("cubic"):
        raise ConfigError(table.name("blend"), "and cubic exclude each other; leave one out")
    each = partial(_each, table, count)
    touchdown = table.numbers("touchdown", (count,))
    if np.any((touchdown < 0) | (touchdown > 1)):
        raise ConfigError(table.name("touchdown"), "must be shares of the cycle, from 0 to 1")
    sweep = each("stance_sweep", above=0.0, below=FULL_TURN)
    duty = each("duty", above=0.0, below=1.0)
    offset = _same(0.0, count)
    if table.has("offset"):
        offset = each("offset", above=-np.pi, below=np.pi)
    if table.has("blend"):
        blend = table.number("blend", minimum=0, below=1)
        return BuehlerParameters(name, frequency, touchdown, sweep, duty, offset, blend)
    cubic = _same(0.0, count)
    if table.has("cubic"):
        cubic = each("cubic", minimum=0.0, maximum=1.0)
    return CubicParameters(name, frequency, touchdown, sweep, duty, offset, cubic)


def _same(value: float, count: int) -> FloatArray:
    return readonly(np.full(count, value))


def _each(table: Table, count: int, key: str, **bounds: float) -> FloatArray:
    """Return a number of each leg, (N,); one in the file stands for all of them."""
    if not isinstance(table.raw(key), list):
        return _same(table.number(key, **bounds), count)
    values = table.numbers(key, (count,))
    legs = [
        Table({key: value}, table.name(key).removesuffix(f".{key}")) for value in values.tolist()
    ]
    return readonly(np.array([leg.number(key, **bounds) for leg in legs]))
