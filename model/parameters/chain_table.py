"""The table ``[leg.chain]`` of a robot file: legs of several joints as plain numbers, read and written.

It is made once from an MJCF or URDF, so that a robot file, and every log that carries its text, is complete
without the file and without its simulator. Keys and meanings are those of ``ChainParameters``.
"""

from collections.abc import Sequence

import numpy as np

from model.errors import ConfigError
from model.parameters.toml_table import Table
from model.values.arrays import FloatArray, readonly
from model.values.parameters import ChainParameters

UNIT_LENGTH = 1e-6  # an axis may be off a unit vector by so much


def read_chain(table: Table, legs: int) -> ChainParameters:
    """Read [leg.chain] of a robot with so many legs.

    Raises:
        ConfigError: A key is missing or wrong, or joints and feet do not make legs.
    """
    joints = table.part_names("joints")
    count = len(joints)
    if count == 0:
        raise ConfigError(table.name("joints"), "is empty; a leg needs a joint")
    chain = ChainParameters(
        joints=joints,
        parent=table.integers("parent", count, minimum=-1, maximum=count - 1),
        slides=readonly(table.integers("slides", count, minimum=0, maximum=1).astype(np.bool_)),
        axis=table.numbers("axis", (count, 3)),
        place=table.numbers("place", (count, 3)),
        sign=_signs(table, count),
        zero=table.numbers("zero", (count,)),
        foot_joint=table.integers("foot_joint", legs, minimum=0, maximum=count - 1),
        foot=table.numbers("foot", (legs, 3)),
        radius=table.numbers("radius", (legs,)),
    )
    if np.any(chain.radius < 0):
        raise ConfigError(table.name("radius"), "must not be negative; 0 is a point")
    for row in np.flatnonzero(chain.parent >= np.arange(count)):
        words = f"{joints[row]} comes before the joint that carries it; list that one first"
        raise ConfigError(table.name("parent"), words)
    lengths = np.linalg.norm(chain.axis, axis=1)
    for row in np.flatnonzero(np.abs(lengths - 1) > UNIT_LENGTH):
        words = f"that of {joints[row]} has length {lengths[row]:g}, not 1"
        raise ConfigError(table.name("axis"), words)
    moving = {row for leg in range(legs) for row in chain.joints_of(leg)}
    idle = [name for row, name in enumerate(joints) if row not in moving]
    if idle:
        raise ConfigError(table.name("joints"), f"{idle[0]} moves no foot; leave it out")
    return chain


def _signs(table: Table, count: int) -> FloatArray:
    signs = table.integers("sign", count, minimum=-1, maximum=1)
    if np.any(signs == 0):
        raise ConfigError(table.name("sign"), "must be 1 or -1, not 0")
    values: FloatArray = readonly(signs.astype(np.float64))
    return values


def first_places(chain: ChainParameters) -> FloatArray:
    """Return where legs are fixed to the body, (N, 3) [m]: the first joint that only one of them has."""
    paths = [chain.joints_of(leg) for leg in range(len(chain.foot))]
    shared = [row for row in range(chain.count) if sum(row in path for path in paths) > 1]
    own = [next((row for row in path if row not in shared), path[-1]) for path in paths]
    places: FloatArray = readonly(chain.place[own])
    return places


def chain_lines(chain: ChainParameters, source: str) -> list[str]:
    """Return [leg.chain] as lines of TOML, exact to the last bit.

    Args:
        chain: The legs.
        source: Where they come from, for the comment.
    """
    names = ", ".join(f'"{_escaped(name)}"' for name in chain.joints)
    return [
        f"[leg.chain]  # from {_escaped(source)}; remove this table to have it read again",
        f"joints = [{names}]",
        f"parent = {chain.parent.tolist()}",
        f"slides = {chain.slides.astype(int).tolist()}",
        *_rows("axis", chain.axis),
        *_rows("place", chain.place),
        f"sign = {chain.sign.astype(int).tolist()}",
        f"zero = {chain.zero.tolist()}",
        f"foot_joint = {chain.foot_joint.tolist()}",
        *_rows("foot", chain.foot),
        f"radius = {chain.radius.tolist()}",
    ]


def _rows(key: str, values: FloatArray) -> Sequence[str]:
    return (f"{key} = [", *(f"  {row.tolist()}," for row in values), "]")


def _escaped(text: str) -> str:
    """A text as it may stand between quotation marks, or in a comment."""
    shown = text.replace("\\", "\\\\").replace('"', '\\"')
    return "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in shown)
