"""Where the centre of mass would stand best: the shift of all feet with the largest least margin."""

from typing import NamedTuple

import numpy as np

from model.support.static_margin import hull_edges
from model.values.arrays import BoolArray, FloatArray


class BestShift(NamedTuple):
    """What moving all shafts alike can do.

    Attributes:
        shift_m: To be added to every shaft position, (2,) x and y [m].
        margin_m: Least margin of the cycle then [m]; at most 0 where no shift keeps the robot from tipping.
    """

    shift_m: FloatArray
    margin_m: float


def best_shift(feet_m: FloatArray, stance: BoolArray) -> BestShift:
    """Return the shift of all feet that makes the least static margin of a cycle largest.

    A linear program: every edge ``normal . place <= reach`` moves with the feet, and the least of
    ``reach + normal . shift`` is to be largest.

    Args:
        feet_m: Feet over a cycle, (F, N, 2) [m].
        stance: Which of them stand, (F, N).
    """
    edges = hull_edges(feet_m, stance)
    if len(edges.reach_m) == 0:
        return BestShift(np.zeros(2), -np.inf)
    from scipy.optimize import linprog  # takes longer to import than all else here

    rows = np.column_stack([-edges.normal, np.ones(len(edges.reach_m))])
    solved = linprog([0.0, 0.0, -1.0], A_ub=rows, b_ub=edges.reach_m, bounds=[(None, None)] * 3)
    if solved.x is None:  # no feet in any frame has edges that bound it
        return BestShift(np.zeros(2), -np.inf)
    x, y, margin = solved.x
    return BestShift(np.array([x, y]), float(margin))
