"""The metachronal gait made to slip: two thirds of the cycle on the ground, shaft angle a cubic of time.

From the source paper: four feet, two a side, on the ground at any time, and feet that move at very
different speeds while they are, so that they must slip. In stance, with s from -1 to 1,

    angle = sweep/2 ((1 - cubic) s + cubic s^3)

and the return is the cubic that meets the stance in angle and speed at both ends, so that the angle
is continuously differentiable everywhere. On each side a wave runs from the hind to the front leg;
the two sides are half a cycle apart. The paper does not give the coefficients; ours are in the robot file.
"""

import numpy as np

from gaits.gait import SAMPLES, TURN, DelayedLegs, ShaftMotion, leg_sides
from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.parameters import LegParameters, MetachronalParameters


class Metachronal(DelayedLegs):
    """A wave of legs on each side.

    Args:
        parameters: Duty, sweep and the cubic's share.
        legs: Places of the legs.

    Raises:
        ConfigError: The return stroke would turn backward, or steering sweeps a whole turn.
    """

    name = "metachronal"
    rounding = 1e-12

    def __init__(self, parameters: MetachronalParameters, legs: LegParameters) -> None:
        super().__init__(parameters, legs, _delays(legs))
        self._parameters = parameters
        for steer in (-1.0, 0.0, 1.0):
            slowest = float(self.motion(np.arange(SAMPLES) / SAMPLES, steer).slope.min())
            if slowest < -1e-9:
                raise ConfigError(
                    "gait.metachronal.stance_sweep",
                    "the shaft would turn backward in the return stroke; "
                    "lower the sweep, the cubic or the duty",
                )

    def motion(self, phase: FloatArray | float, steer: float) -> ShaftMotion:
        """Return shaft motion at phases of any shape (...), as (..., N)."""
        p, sweep = self._parameters, self.sweeps(steer)
        leg_phase = self.leg_phase(phase)
        cycle = np.floor(leg_phase)
        x = leg_phase - cycle
        # stance: s from -1 to 1 over the duty
        s, ds = 2 * x / p.duty - 1, 2 / p.duty
        stance_angle = sweep / 2 * ((1 - p.cubic) * s + p.cubic * s**3)
        stance_slope = sweep / 2 * ((1 - p.cubic) + 3 * p.cubic * s**2) * ds
        stance_curvature = sweep / 2 * 6 * p.cubic * s * ds**2
        # return: Hermite cubic over u from 0 to 1, same speed at both ends
        width = 1 - p.duty
        u = (x - p.duty) / width
        end_slope = sweep / 2 * (1 + 2 * p.cubic) * ds * width  # per unit of u
        span = TURN - sweep
        return_angle = sweep / 2 + end_slope * u + (span - end_slope) * (3 * u**2 - 2 * u**3)
        return_slope = (end_slope + (span - end_slope) * 6 * u * (1 - u)) / width
        return_curvature = (span - end_slope) * 6 * (1 - 2 * u) / width**2
        down = x < p.duty
        return ShaftMotion(
            np.where(down, stance_angle, return_angle) + TURN * cycle,
            np.where(down, stance_slope, return_slope),
            np.where(down, stance_curvature, return_curvature),
        )

    def peaks(self, steer: float) -> tuple[float, float]:
        """Return the largest slope and curvature; both lie at ends or middles of the cubics."""
        p = self._parameters
        corners = np.array([0.0, p.duty - 1e-9, p.duty, p.duty + (1 - p.duty) / 2, 1 - 1e-9])
        phases = (corners[:, None] + self._delay).ravel()
        motion = self.motion(phases, steer)
        return float(np.abs(motion.slope).max()), float(np.abs(motion.curvature).max())


def _delays(legs: LegParameters) -> FloatArray:
    """Delay of each leg: on each side hind leg first, evenly spread; right half a cycle later."""
    delay, side = np.zeros(legs.count), leg_sides(legs)
    for sign, shift in ((1.0, 0.0), (-1.0, 0.5), (0.0, 0.25)):
        members = np.flatnonzero(side == sign)
        order = members[np.argsort(legs.shaft_position[members, 0], kind="stable")]
        delay[order] = shift + np.arange(len(order)) / max(len(order), 1)
    return delay
