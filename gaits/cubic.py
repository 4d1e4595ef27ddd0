"""Shaft angles that are cubics of time, one in stance and one in the return: feet that are made to slip.

From the source paper: four feet, two a side, on the ground at any time, and feet that move at very
different speeds while they are, so that they must slip. In stance, with s from -1 to 1,

    angle = offset + sweep/2 ((1 - cubic) s + cubic s^3)

and the return is the cubic that meets the stance in angle and speed at both ends, so that the angle
is continuously differentiable everywhere. The paper does not give the coefficients; ours are in the
robot file. With cubic = 0 the shaft turns evenly in stance.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gaits.gait import TURN, DelayedLegs, ShaftMotion
from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.parameters import CubicParameters, LegParameters


class Cubics(NamedTuple):
    """Coefficients of the cubics at one steering, (N,) each.

    Attributes:
        half: Half of the stance sweep [rad].
        bend: Curvature of the stance for one s.
        end_slope: Slope of the return at its ends, for one share of it.
        rest: What the return turns more than that.
    """

    half: FloatArray
    bend: FloatArray
    end_slope: FloatArray
    rest: FloatArray


class CubicClock(DelayedLegs):
    """Legs that go through two cubics.

    Args:
        parameters: Touchdowns, duties, sweeps, offsets and shares of the cubic.
        legs: Places of the legs.

    Raises:
        ConfigError: The return stroke would turn backward, or steering sweeps a whole turn.
    """

    rounding = 1e-12

    def __init__(self, parameters: CubicParameters, legs: LegParameters) -> None:
        super().__init__(parameters, legs)
        self._parameters = parameters
        self._width, self._ds = 1 - parameters.duty, 2 / parameters.duty
        self._cubics = lru_cache(maxsize=4)(self._cubics_at)
        for steer in (-1.0, 0.0, 1.0):
            if self._slowest(steer) < -1e-9:
                raise ConfigError(
                    f"gait.{self.name}.stance_sweep",
                    "the shaft would turn backward in the return stroke; "
                    "lower the sweep, the cubic or the duty",
                )

    def _cubics_at(self, steer: float) -> Cubics:
        p, sweep = self._parameters, self.sweeps(steer)
        half = sweep / 2
        end_slope = half * (1 + 2 * p.cubic) * self._ds * self._width
        return Cubics(half, half * 6 * p.cubic, end_slope, TURN - sweep - end_slope)

    def _slowest(self, steer: float) -> float:
        """Least slope: of the parabolas of stance and return, in the middle or where they meet."""
        cubics, even = self._cubics(steer), 1 - self._parameters.cubic
        slopes = np.array([
            cubics.half * even * self._ds,
            cubics.end_slope / self._width,
            (cubics.end_slope + 1.5 * cubics.rest) / self._width,
        ])  # fmt: skip
        return float(slopes.min())

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        """Return shaft motion at phases of any shape (...), as (..., N)."""
        p, width, ds = self._parameters, self._width, self._ds
        half, bend, end_slope, rest = self._cubics(steer)
        leg_phase = self.leg_phase(phase)
        cycle = np.floor(leg_phase)
        x = leg_phase - cycle
        # stance: s from -1 to 1 over the duty
        s, even = 2 * x / p.duty - 1, 1 - p.cubic
        stance_angle = half * (even * s + p.cubic * s**3)
        stance_slope = half * (even + 3 * p.cubic * s**2) * ds
        stance_curvature = bend * s * ds**2
        # return: Hermite cubic over u from 0 to 1, same speed at both ends
        u = (x - p.duty) / width
        return_angle = half + end_slope * u + rest * (3 * u**2 - 2 * u**3)
        return_slope = (end_slope + rest * 6 * u * (1 - u)) / width
        return_curvature = rest * 6 * (1 - 2 * u) / width**2
        down = x < p.duty
        return ShaftMotion(
            np.where(down, stance_angle, return_angle) + TURN * cycle + p.offset,
            np.where(down, stance_slope, return_slope),
            np.where(down, stance_curvature, return_curvature),
        )

    def peaks(self, steer: float) -> tuple[float, float]:
        """Return the largest slope and curvature; both lie at ends or middles of the cubics."""
        duty = self._parameters.duty
        start, end = np.zeros_like(duty), np.ones_like(duty)
        corners = np.array([start, duty - 1e-9, duty, duty + (1 - duty) / 2, end - 1e-9])
        motion = self.motion((corners + self._delay).ravel(), steer)
        return float(np.abs(motion.slope).max()), float(np.abs(motion.curvature).max())
