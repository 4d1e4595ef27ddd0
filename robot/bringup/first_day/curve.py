"""What a leg did in a step of the first day beside what was expected of it: the curves of the page."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from model.values.arrays import FloatArray, IntArray

MOST_POINTS = 200


@dataclass(frozen=True, slots=True)
class DayCurve:
    """One leg in one step.

    Attributes:
        leg: Leg.
        across: What ``x`` is, with its unit.
        up: What is measured, with its unit.
        x: Time, or the number of a try.
        measured: One a place; all are known.
        expected: As many, or none.
    """

    leg: str
    across: str
    up: str
    x: tuple[float, ...]
    measured: tuple[float, ...]
    expected: tuple[float, ...] = ()


def turning_curves(
    names: Sequence[str], t_ns: IntArray, angle_rad: FloatArray, goal_rad: FloatArray
) -> list[DayCurve]:
    """Return how far each shaft turned, and should have, in degrees from its first goal.

    Args:
        names: Of N legs.
        t_ns: When the angles were measured, (T,).
        angle_rad: Measured, (T, N) [rad]; what is not known is left out.
        goal_rad: Goals, (T, N) [rad].
    """
    rows = np.unique(np.linspace(0, len(t_ns) - 1, min(len(t_ns), MOST_POINTS)).round().astype(int))
    t_s = (t_ns[rows] - t_ns[0]) * 1e-9
    curves = []
    for leg, name in enumerate(names):
        angle, goal = np.degrees(np.stack([angle_rad, goal_rad])[:, rows, leg] - goal_rad[0, leg])
        known = np.isfinite(angle) & np.isfinite(goal)
        x, measured, expected = (
            tuple(values[known].round(3).tolist()) for values in (t_s, angle, goal)
        )
        curves.append(DayCurve(name, "from the start [s]", "turned [deg]", x, measured, expected))
    return curves


def read_curve(data: dict[str, Any]) -> DayCurve:
    """Return a curve that was kept as JSON.

    Raises:
        TypeError: It is none.
    """
    values: dict[str, Any] = {
        key: tuple(one) if isinstance(one, list) else one for key, one in data.items()
    }
    return DayCurve(**values)
