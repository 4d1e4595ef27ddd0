"""How fast a body moves as it tilts over the ground below it, compiled."""

from typing import NamedTuple

import numpy as np

from model.compiled import compiled, in_place
from model.support.kernel import ROWS, support_kernel
from model.values.arrays import FloatArray


class SwaySpace(NamedTuple):
    """Work space of ``tilt_sway`` for N feet.

    Attributes:
        moved: (N, 3).
        tilt: (3,).
        loads: (N,).
        work: (ROWS, N).
    """

    moved: FloatArray
    tilt: FloatArray
    loads: FloatArray
    work: FloatArray


@compiled
def sway_space(count: int) -> SwaySpace:
    """Work space for N feet."""
    return SwaySpace(np.empty((count, 3)), np.empty(3), np.empty(count), np.empty((ROWS, count)))


@in_place
@compiled
def tilt_sway(
    feet: FloatArray,
    feet_velocity: FloatArray,
    ground: FloatArray,
    stiffness: FloatArray,
    load: float,
    step_s: float,
    height: float,
    space: SwaySpace,
) -> tuple[float, float]:
    """Horizontal velocity of the body origin as it tilts over the ground below it.

    Slopes a moment before and after, from the feet's own velocities: exact, and without the delay of a
    filter. Where either has no support there is no sway to speak of.
    """
    moved, tilt, loads, work = space
    turn_x, turn_y = 0.0, 0.0
    for before in range(2):
        sign = 1.0 - 2.0 * before
        for k in range(feet.shape[0]):
            for i in range(3):
                moved[k, i] = feet[k, i] + sign * step_s * feet_velocity[k, i]
        if support_kernel(moved, ground, stiffness, load, tilt, loads, work) < 0:
            return 0.0, 0.0
        turn_x += sign * tilt[0]
        turn_y += sign * tilt[1]
    share = height / (2.0 * step_s)
    return share * turn_x, -share * turn_y
