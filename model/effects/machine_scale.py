"""Bounds and spreads of the catalogue for a robot of another size or weight.

The catalogue's numbers are those of a robot of 64 N that reaches 0.46 m from its middle. A length grows
with a robot's reach, a force with its weight, a compliance as the one over the other; times, angles and
ratios are any robot's. Scales are powers of two, so that robots alike have the same catalogue.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from model.effects.catalogue import EFFECTS, ChainEffect
from model.effects.causes import Parameter
from model.kinematics.legs import reach_m
from model.values.gravity import STANDARD_GRAVITY
from model.values.parameters import LegGeometry, LegParameters


@dataclass(frozen=True, slots=True)
class RobotSize:
    """What bounds of effects grow with.

    Attributes:
        weight_n: Weight of the whole robot.
        reach_m: From the middle of the robot to the farthest place along x where a foot may stand.
    """

    weight_n: float
    reach_m: float


USUAL_SIZE = RobotSize(64.0, 0.46)  # the robot that the catalogue's numbers were written for
# Unit of a parameter: powers of reach and of weight that it grows with.
POWERS = {
    "m": (1, 0),
    "m/s": (1, 0),
    "N": (0, 1),
    "N/s": (0, 1),
    "kg": (0, 1),
    "m/N": (1, -1),
    "N s/m": (-1, 1),
    "rad/(N m)": (-1, -1),
}


def size_of(mass_kg: float, legs: LegParameters, leg: LegGeometry) -> RobotSize:
    """Return the size of a robot; all its legs have the same geometry."""
    shaft = float(np.abs(legs.shaft_position[:, 0]).max())
    return RobotSize(mass_kg * STANDARD_GRAVITY, shaft + reach_m(leg))


@lru_cache
def effects_for(size: RobotSize) -> Mapping[str, ChainEffect]:
    """Return the catalogue with bounds and spreads for a robot of this size."""
    reach = _power_of_two(size.reach_m / USUAL_SIZE.reach_m)
    weight = _power_of_two(size.weight_n / USUAL_SIZE.weight_n)
    return MappingProxyType(
        {
            name: replace(
                effect, parameters=tuple(_scaled(one, reach, weight) for one in effect.parameters)
            )
            for name, effect in EFFECTS.items()
        }
    )


def _scaled(one: Parameter, reach: float, weight: float) -> Parameter:
    if one.unit not in POWERS or one.located:
        return one
    reaches, weights = POWERS[one.unit]
    by = reach**reaches * weight**weights
    return replace(
        one,
        neutral=one.neutral * by,
        lower=one.lower * by,
        upper=one.upper * by,
        spread=one.spread * by,
    )


def _power_of_two(ratio: float) -> float:
    return 2.0 ** round(math.log2(ratio))
