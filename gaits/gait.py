"""What a gait is: shaft angle, speed and stance of every leg as pure functions of phase and steering.

Phase is in cycles and unwrapped; one cycle turns every shaft once, so ``angle(phase + 1) =
angle(phase) + 2 pi`` exactly. Time enters only through ``gaits.plan``.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from model.errors import ConfigError
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import ClockParameters, LegParameters
from model.values.quick import quick

TURN = 2 * np.pi
# Full steering shortens the stance sweep on the inner side and lengthens it outside by this share.
# The source paper only cites its steering strategy (Zhao 2020); this one is ours.
STEER_GAIN = 0.3
SAMPLES = 720  # of a cycle, where a gait is searched


@quick
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


class DelayedLegs:
    """What a robot file's gaits share: each leg goes through a cycle, stance first, with its own delay.

    Args:
        parameters: Name, frequency, touchdowns, sweeps and duties.
        legs: Places of the legs.

    Raises:
        ConfigError: Full steering would sweep a whole turn.
    """

    rounding = 0.0  # of the phase, so that stance includes its beginning and not its end

    def __init__(self, parameters: ClockParameters, legs: LegParameters) -> None:
        self.name = parameters.name
        widest = float(parameters.stance_sweep.max()) * (1 + STEER_GAIN)
        if widest >= TURN:
            raise ConfigError(
                f"gait.{self.name}.stance_sweep",
                f"full steering widens it to {widest:.3f} rad; it must stay below a turn",
            )
        self._sweep, self._duty = parameters.stance_sweep, parameters.duty
        self._side = leg_sides(legs)
        self._delay = parameters.touchdown
        self.frequency_hz = parameters.frequency
        self.start_phase = middle_of_most_support(self.stance(np.arange(SAMPLES) / SAMPLES))

    def leg_phase(self, phase: FloatArray | float) -> FloatArray:
        """Return each leg's own phase, touchdown at whole numbers, (..., N) [cycles]."""
        if isinstance(phase, float):  # of a tick
            return phase - self._delay + self.rounding
        legs: FloatArray = np.asarray(phase, dtype=np.float64)[..., None] - self._delay
        return legs + self.rounding

    def stance(self, phase: FloatArray | float) -> BoolArray:
        """Return which legs are in stance, (..., N)."""
        down: BoolArray = np.mod(self.leg_phase(phase), 1.0) < self._duty
        return down

    def sweeps(self, steer: float) -> FloatArray:
        """Return each leg's stance sweep, (N,) [rad]: less on the inner side of a turn, more outside."""
        sweeps: FloatArray = self._sweep * (1.0 - STEER_GAIN * steer * self._side)
        return sweeps


def leg_sides(legs: LegParameters) -> FloatArray:
    """Return +1 for left legs, -1 for right legs, 0 for legs on the middle line, (N,)."""
    sides: FloatArray = np.sign(legs.shaft_position[:, 1])
    return sides


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
