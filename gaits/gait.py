"""What a gait is: shaft angle, speed and stance of every leg as pure functions of phase and steering.

Phase is in cycles and unwrapped; one cycle turns every shaft once, so ``angle(phase + 1) =
angle(phase) + 2 pi`` exactly. Time enters only through ``gaits.plan``.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from model.errors import ConfigError
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import LegParameters

TURN = 2 * np.pi
# Full steering shortens the stance sweep on the inner side and lengthens it outside by this share.
# The source paper only cites its steering strategy (Zhao 2020); this one is ours.
STEER_GAIN = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class ShaftMotion:
    """Shaft motion by phase; every array is (..., N).

    Attributes:
        angle_rad: Shaft angle, unwrapped [rad].
        slope: d angle / d phase [rad a cycle]; times frequency it is the speed.
        curvature: d2 angle / d phase2 [rad a cycle squared].
    """

    angle_rad: FloatArray
    slope: FloatArray
    curvature: FloatArray


class Gait(Protocol):
    """One gait of one robot."""

    @property
    def name(self) -> str:
        """Name as the command line knows it."""
        ...

    @property
    def frequency_hz(self) -> float:
        """Cycles a second unless told otherwise."""
        ...

    @property
    def start_phase(self) -> float:
        """Phase to begin at: the middle of the longest time with most feet in stance."""
        ...

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        """Return shaft motion at phases of any shape (...), as (..., N)."""
        ...

    def stance(self, phase: FloatArray | float) -> BoolArray:
        """Return which legs are scheduled to be on the ground, (..., N)."""
        ...

    def peaks(self, steer: float) -> tuple[float, float]:
        """Return the largest slope and the largest curvature over a cycle."""
        ...


def leg_sweeps(stance_sweep: float, steer: float, side: FloatArray) -> FloatArray:
    """Stance sweep of each leg: less on the inner side of the turn, more on the outer.

    Args:
        stance_sweep: Sweep when going straight [rad].
        steer: -1 (right) to 1 (left).
        side: +1 for left legs, -1 for right legs, 0 for legs on the middle line, (N,).
    """
    sweeps: FloatArray = stance_sweep * (1.0 - STEER_GAIN * steer * side)
    return sweeps


def leg_sides(legs: LegParameters) -> FloatArray:
    """Return +1 for left legs, -1 for right legs, (N,)."""
    sides: FloatArray = np.sign(legs.shaft_position[:, 1])
    return sides


def check_sweep(key: str, stance_sweep: float) -> None:
    """Refuse a sweep that full steering would make a full turn.

    Raises:
        ConfigError: It would.
    """
    widest = stance_sweep * (1 + STEER_GAIN)
    if widest >= TURN:
        raise ConfigError(
            key, f"full steering widens it to {widest:.3f} rad; it must stay below a turn"
        )


def middle_of_most_support(stance: BoolArray) -> float:
    """Phase in the middle of the longest run of samples with the most feet in stance.

    Args:
        stance: Stance sampled evenly over one cycle, (S, N).
    """
    samples = len(stance)
    count = stance.sum(axis=1)
    best = count == count.max()
    if best.all():
        return 0.0
    first = int(np.flatnonzero(~best)[0])  # begin the search where a run cannot be cut
    length, longest, end = 0, 0, 0
    for index in range(samples):
        length = length + 1 if best[(first + index) % samples] else 0
        if length > longest:
            longest, end = length, first + index
    return ((end - (longest - 1) / 2) % samples) / samples
