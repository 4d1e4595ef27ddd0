"""Bounds and spreads of the catalogue for a robot of another size or weight.

The catalogue's numbers are those of a robot of 64 N that reaches 0.46 m from its middle. A length grows
with a robot's reach, a force with its weight, a compliance as the one over the other; times, angles and
ratios are any robot's. Scales are powers of two, so that robots alike have the same catalogue.
"""

import math
from dataclasses import replace

from model.effects.catalogue import ChainEffect
from model.effects.causes import Parameter

WEIGHT_N = 64.0
REACH_M = 0.46
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


def scaled_effect(effect: ChainEffect, weight_n: float, reach_m: float) -> ChainEffect:
    """Return an effect with bounds and spreads for a robot of this weight and reach."""
    reach, weight = _power_of_two(reach_m / REACH_M), _power_of_two(weight_n / WEIGHT_N)
    return replace(
        effect, parameters=tuple(_scaled(one, reach, weight) for one in effect.parameters)
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
