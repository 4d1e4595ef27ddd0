"""When each leg touches down in the paper's two gaits, from the places of the legs."""

from collections.abc import Collection

import numpy as np

from gaits.gait import leg_sides
from model.values.arrays import FloatArray, readonly
from model.values.parameters import LegParameters


def two_groups(legs: LegParameters, first: Collection[str]) -> FloatArray:
    """Touchdown of each leg, (N,) [cycles]: the first group, and the others half a cycle later."""
    return readonly(np.array([0.0 if name in first else 0.5 for name in legs.names]))


def waves_from_behind(legs: LegParameters) -> FloatArray:
    """Touchdown of each leg, (N,) [cycles]: on each side hind leg first, evenly spread.

    The right side is half a cycle later than the left.
    """
    delay, side = np.zeros(legs.count), leg_sides(legs)
    for sign, shift in ((1.0, 0.0), (-1.0, 0.5), (0.0, 0.25)):
        members = np.flatnonzero(side == sign)
        order = members[np.argsort(legs.shaft_position[members, 0], kind="stable")]
        delay[order] = shift + np.arange(len(order)) / max(len(order), 1)
    return readonly(delay)
